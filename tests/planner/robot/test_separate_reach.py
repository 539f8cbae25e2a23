"""Reach that overlaps is cut apart for planning, so that legs do not cross."""

from dataclasses import replace
from itertools import combinations

import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.robot.separate_reach import separated

HEXAPOD = load_machine("hexapod")


def widened(machine, by, axis="x"):
    def wide(leg):
        low, high = getattr(leg, axis)
        return replace(leg, **{axis: (low - by, high + by)})

    return replace(machine, legs=tuple(wide(leg) for leg in machine.legs))


@pytest.mark.parametrize("name", ["hexapod", "titan3", "phantomx"])
def test_legs_with_ground_of_their_own_stay_as_they_are(name):
    machine = load_machine(name)
    assert separated(machine) is machine


@pytest.mark.parametrize(("by", "axis"), [(0.05, "x"), (0.15, "x"), (0.35, "y")])
def test_overlaps_are_cut_in_the_middle(by, axis):
    wide = widened(HEXAPOD, by, axis)
    apart = separated(wide)
    assert apart is not wide
    for a, b in combinations(apart.legs, 2):
        overlap_x = min(a.x[1], b.x[1]) - max(a.x[0], b.x[0])
        overlap_y = min(a.y[1], b.y[1]) - max(a.y[0], b.y[0])
        assert min(overlap_x, overlap_y) <= 1e-12
    for before, after in zip(wide.legs, apart.legs, strict=True):
        assert before.x[0] <= after.x[0] < after.x[1] <= before.x[1]
        assert before.y[0] <= after.y[0] < after.y[1] <= before.y[1]


def test_what_is_cut_is_shared_evenly():
    front, middle = separated(widened(HEXAPOD, 0.1)).legs[:2]
    assert front.x[0] == pytest.approx(0.3) == middle.x[1]
