"""Reach worked out from the chain of joints, and exact exits on it."""

import math
import random
from itertools import islice

import pytest

from walking_console.planner.geometry.paths import ArcPath, arc_of_command
from walking_console.planner.robot.chains import Drives, insect_chain, slides_chain
from walking_console.planner.robot.kinematics import inverse
from walking_console.planner.robot.model import load_machine
from walking_console.planner.robot.workspace import (
    ReachRegion,
    convex_inside,
    fitted_box,
    out_of_reach,
    reach_at,
    reaches,
)

BOX = (0.2, 0.7, 0.3, 0.65)
HEXAGON = ReachRegion(((0.3, 0.2), (0.6, 0.1), (0.8, 0.4), (0.7, 0.7), (0.4, 0.75), (0.2, 0.5)))
# a slice of an insect's reach: the near side turns inwards
KIDNEY = ReachRegion(
    ((0.3, 0.0), (0.6, -0.3), (0.8, 0.0), (0.8, 0.4), (0.6, 0.7), (0.3, 0.4), (0.45, 0.2))
)
REGIONS = pytest.mark.parametrize("region", [ReachRegion.of_box(BOX), HEXAGON, KIDNEY])


def some_paths(chance: random.Random, count: int) -> list[ArcPath]:
    return [
        arc_of_command(
            chance.uniform(-math.pi, math.pi),
            chance.choice([0.1, 0.1, 0.0]),
            chance.choice([0.0, chance.uniform(-0.5, 0.5)]) or 0.0,
            0.65,
        )[0]
        for _ in range(count)
    ]


@REGIONS
def test_the_existence_segment_is_the_one_that_dense_sampling_finds(region):
    chance = random.Random(7)
    for path in some_paths(chance, 150):
        x, y = chance.uniform(0.1, 0.9), chance.uniform(-0.3, 0.8)
        if not region.contains(x, y):
            continue
        exact = region.segment(x, y, path)
        assert exact[0] <= 1e-9 and exact[1] >= -1e-9
        step, s = 1e-3, 0.0
        while s < 3.0 and region.contains(*path.seen(x, y, s)):
            s += step
        assert (exact[1] >= 3.0 - step) if s >= 3.0 else (s - step <= exact[1] + 1e-6 <= s + 2e-6)


@REGIONS
def test_a_foothold_ahead_is_met_where_dense_sampling_meets_it(region):
    chance = random.Random(8)
    met = 0
    for path in some_paths(chance, 200):
        x, y = chance.uniform(-1.0, 2.0), chance.uniform(-1.0, 2.0)
        if region.contains(x, y):
            continue
        s1, s2 = region.segment(x, y, path)
        places = (k * 1e-3 for k in range(3000))
        inside = list(islice((s for s in places if region.contains(*path.seen(x, y, s))), 2))
        if s1 > s2 or s1 > 2.9:
            assert len(inside) <= 1 or s1 > 2.9
            continue
        met += 1
        if s2 - max(s1, 0.0) > 2e-3:
            assert inside and inside[0] == pytest.approx(max(s1, 0.0), abs=1.1e-3)
    assert met > 20


def test_a_rectangle_as_a_region_answers_as_the_rectangle_does():
    chance, region = random.Random(9), ReachRegion.of_box(BOX)
    for path in some_paths(chance, 300):
        x, y = chance.uniform(0.2, 0.7), chance.uniform(0.3, 0.65)
        assert region.segment(x, y, path) == pytest.approx(path.segment(x, y, BOX), abs=1e-9)
        assert region.exit(x, y, path) == pytest.approx(path.exit(x, y, BOX), abs=1e-9)


def test_a_foot_that_is_never_in_reach_has_no_segment():
    assert HEXAGON.segment(5.0, 5.0, ArcPath(1.0, 0.0)) == (math.inf, -math.inf)


def test_a_region_is_refused_when_its_corners_run_the_wrong_way_round():
    with pytest.raises(ValueError, match="counter-clockwise"):
        ReachRegion(HEXAGON.corners[::-1])
    with pytest.raises(ValueError, match="at least 3 corners, got 2"):
        ReachRegion(((0.0, 0.0), (1.0, 0.0)))


def test_the_convex_part_of_a_star_lies_in_the_star_and_holds_its_centre():
    inner = convex_inside(KIDNEY, (0.6, 0.2))
    assert inner.convex and inner.contains(0.6, 0.2)
    chance = random.Random(10)
    for _ in range(500):
        x, y = chance.uniform(0.0, 1.0), chance.uniform(-0.5, 1.0)
        if inner.contains(x, y):
            assert KIDNEY.contains(x, y, slack=1e-9)


def test_the_reach_of_slides_is_the_box_of_their_limits():
    drives = Drives(((-0.3, 0.3), (-0.05, 0.4), (-1.25, -0.45)), (1, 1, 1), (1, 1, 1))
    slides = slides_chain((0.45, 0.3, 0.0), 0.0, drives)
    region = reach_at(slides, -0.85, (0.45, 0.475))
    assert region is not None
    x0, x1, y0, y1 = region.box
    assert (x0, x1, y0, y1) == pytest.approx((0.15, 0.75, 0.25, 0.7), abs=1e-2)
    assert all(reaches(slides, (x, y, -0.85)) for x, y in region.corners)
    assert reach_at(slides, -0.3, (0.45, 0.475)) is None


def test_every_place_of_a_slice_of_an_insects_reach_is_reached_and_its_rim_is_the_limit():
    machine = load_machine("phantomx")
    chain, leg = machine.chains[0], machine.legs[0]
    region = reach_at(chain, -0.095, leg.centre)
    assert region is not None
    hip_x, hip_y, _ = chain.hip
    for x, y in region.corners:
        assert reaches(chain, (x, y, -0.095))
    # the far side is the leg stretched out: 0.054 m, then 0.066 and 0.133 m down to the ground
    far = max(math.hypot(x - hip_x, y - hip_y) for x, y in region.corners)
    assert far == pytest.approx(0.054 + math.sqrt(0.199**2 - 0.095**2), abs=1e-3)


@pytest.mark.parametrize("name", ["titan3", "hexapod", "phantomx"])
def test_every_control_box_shipped_is_within_reach(name):
    machine = load_machine(name)
    for leg, chain in zip(machine.legs, machine.chains, strict=True):
        assert out_of_reach(chain, (leg.x, leg.y, leg.z)) is None


def test_a_fitted_box_is_all_within_reach():
    drives = Drives(((-1.3, 1.3), (-1.2, 1.8), (-2.95, 0.0)), (1, 1, 1), (1, 1, 1))
    leg = insect_chain((0.1, 0.1, 0.0), 0.8, (0.05, 0.07, 0.13), drives)
    spans = fitted_box(leg)
    chance = random.Random(11)
    assert all(high - low > 0.02 for low, high in spans)
    for _ in range(300):
        x, y, z = (chance.uniform(low, high) for low, high in spans)
        assert inverse(leg, (x, y, z)) is not None
