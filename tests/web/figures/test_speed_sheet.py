"""Speed against lift: the formula of H §7 (28), what is walked, and where a foot cannot follow."""

from dataclasses import replace

import pytest

from walking_console.web.figures.catalogue import LIFT, PACE
from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.speed_sheet import (
    formula,
    setting,
    speeds,
    walked_speed,
    within_reach,
)


def test_lifting_higher_is_slower_and_lifting_faster_is_faster(walk: RecordedWalk) -> None:
    assert formula(walk, lift=0.2, pace=0.4) < formula(walk, lift=0.1, pace=0.4)
    assert formula(walk, lift=0.1, pace=0.8) > formula(walk, lift=0.1, pace=0.4)


def test_a_foot_coming_straight_down_allows_a_speed_of_its_overreach(walk: RecordedWalk) -> None:
    # δx = 0.05 m while the foot comes down 0.2 m at 0.8 m/s
    assert within_reach(walk, lift=0.1, pace=0.8) == pytest.approx(0.05 / 0.25)


def test_settings_are_those_the_walk_was_made_with(walk: RecordedWalk) -> None:
    assert setting(walk, LIFT) == walk.gait.lift_up
    assert setting(walk, PACE) == walk.machine.speed[2]


def test_the_walked_speed_leaves_the_first_cycle_out(walk: RecordedWalk) -> None:
    first, last = walk.steps[3]["tick"], walk.steps[7]["tick"]
    way = walk.way[last - 1] - walk.way[first - 1]
    assert walked_speed(walk) == pytest.approx(way / ((last - first) * 0.02))


def test_every_line_has_its_marks(walk: RecordedWalk) -> None:
    swept = {}
    for lift in (0.05, 0.1, 0.2):
        for pace in (0.2, 0.4, 0.8):
            speed = (*walk.machine.speed[:2], pace)
            machine = replace(walk.machine, speed=speed)
            gait = replace(walk.gait, lift_up=lift)
            swept[f"{lift} {pace}"] = replace(walk, machine=machine, gait=gait)
    sheet = speeds("Speeds", {"walk": walk, **swept})
    for ax in sheet.axes:
        rings = [line for line in ax.lines if line.get_marker() == "o"]
        assert [len(line.get_xdata()) for line in rings] == [3, 3, 3]
        assert len(ax.get_legend().get_texts()) == 3
