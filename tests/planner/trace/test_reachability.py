"""Which feet carry the machine where, sample by sample, against plain geometry."""

import math

import numpy as np
import pytest

from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.geometry.transforms import point_seen
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.footholds import AIR
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.reachability import Reachability
from walking_console.planner.trace.stability_table import MARGIN

HEXAPOD = load_machine("hexapod")
HEIGHT = gait_of(HEXAPOD).height
COUNT = 120
NEAR = 1e-6


def along(kind: str, terrain: TerrainMap, rows: tuple[float, ...] = (0.0,)) -> Reachability:
    course = trace_for({"kind": kind}, HEXAPOD)
    x, y, yaw = course.x[:COUNT], course.y[:COUNT], course.yaw[:COUNT]
    lane = Lane(
        np.stack([x for _ in rows]),
        np.stack([y + row for row in rows]),
        yaw,
        np.full(len(x), HEIGHT),
    )
    return Reachability(lane, terrain, HEXAPOD).find_all()


def body_at(reachable: Reachability, row: int, k: int) -> tuple[float, float, float, float]:
    lane = reachable.lane
    return float(lane.x[row, k]), float(lane.y[row, k]), float(lane.z[k]), float(lane.yaw[k])


@pytest.mark.parametrize("kind", ["line", "sine", "circle", "turn"])
def test_a_foothold_exists_where_it_is_in_its_legs_rectangle(kind: str) -> None:
    reachable = along(kind, field_of(0.02, 4, HEXAPOD), (0.0, 0.05))
    assert reachable.footholds
    for number, hold in enumerate(reachable.footholds):
        x1, x2, y1, y2 = HEXAPOD.boxes[hold.leg]
        for row in (0, 1):
            exists = reachable.samples.row_of(reachable.existence[number], row)
            for k in range(0, reachable.samples.count, 7):
                bx, by, _ = point_seen(body_at(reachable, row, k), (hold.x, hold.y, hold.z))
                depth = min(bx - x1, x2 - bx, by - y1, y2 - by)
                if abs(depth) > NEAR:
                    assert bool(exists >> k & 1) is (depth > 0.0)


def start(reachable: Reachability) -> tuple[int, ...]:
    return tuple(
        reachable.foothold_of(leg, (*description.centre, 0.0), 0)
        for leg, description in enumerate(HEXAPOD.legs)
    )


@pytest.mark.parametrize("kind", ["line", "circle"])
@pytest.mark.parametrize("lifted", [(), (1,), (0, 3), (0, 2, 4)])
def test_feet_carry_where_all_are_in_reach_and_the_margin_is_kept(
    kind: str, lifted: tuple[int, ...]
) -> None:
    reachable = along(kind, field_of(1.0, 0, HEXAPOD))
    feet = tuple(AIR if leg in lifted else f for leg, f in enumerate(start(reachable)))
    carries = reachable.carries(feet)
    holds = [reachable.footholds[f] for f in feet if f >= 0]
    polygon = support_polygon([(hold.x, hold.y) for hold in holds])
    for k in range(reachable.samples.count):
        x, y, _, _ = body_at(reachable, 0, k)
        margin = polygon_margin(polygon, x, y) - MARGIN
        if abs(margin) > NEAR:
            in_reach = all(reachable.existence[f] >> k & 1 for f in feet if f >= 0)
            assert bool(carries >> k & 1) is (in_reach and margin > 0.0)


def test_a_foot_out_of_reach_stands_where_it_is_and_may_only_come_nearer() -> None:
    reachable = along("line", field_of(1.0, 0, HEXAPOD))
    x1, x2, y1, y2 = HEXAPOD.boxes[0]
    foot = (x2 + 0.05, (y1 + y2) / 2, 0.0)
    number = reachable.foothold_of(0, foot, 0)
    assert reachable.existence[number] & 1
    last = reachable.footholds[number].last
    assert last == round((foot[0] - x1) / 0.01)


def test_a_posture_less_stable_than_the_margin_is_accepted_and_one_that_falls_is_not() -> None:
    reachable = along("line", field_of(1.0, 0, HEXAPOD))
    feet = start(reachable)
    near_an_edge = tuple(AIR if leg in (3, 4, 5) else f for leg, f in enumerate(feet))
    assert not reachable.accept(near_an_edge, 0)
    assert reachable.accept(feet, 0)


def test_between_two_states_only_feet_that_differ_are_in_the_air() -> None:
    reachable = along("line", field_of(1.0, 0, HEXAPOD))
    feet = start(reachable)
    other = next(f for f in reachable.by_leg[2] if f != feet[2])
    after = (*feet[:2], other, *feet[3:])
    assert reachable.between(feet, after) == reachable.carries((*feet[:2], AIR, *feet[3:]))


def sloping(machine: Machine, angle: float) -> Reachability:
    """A level body of a machine that stands on a slope, rising along x."""
    x = (np.arange(80) + 0.5) * 0.025 - 1.0
    heights = np.tile(math.tan(angle) * x, (80, 1))
    terrain = TerrainMap(heights, np.zeros((80, 80), bool), 0.025, (-1.0, -1.0))
    here = np.zeros((1, 4))
    return Reachability(Lane(here, here, here[0], here[0] + machine.height), terrain, machine)


@pytest.mark.parametrize("robot", ["phantomx", "hexapod"])
def test_a_leg_too_short_for_the_slope_in_front_of_it_is_named_with_the_heights(robot: str) -> None:
    machine = load_machine(robot)
    assert sloping(machine, 0.0).out_of_height(0) is None
    low, high = machine.legs[0].z
    x = machine.legs[0].centre[0]
    fits = math.atan2(high + machine.height, x)
    assert sloping(machine, 0.8 * fits).out_of_height(0) is None
    found = sloping(machine, 1.3 * fits).out_of_height(0)
    assert found is not None and found.leg in (0, 5) and found.share < 0.5
    assert found.ground[1] > high
    assert f"reaches {-1e3 * high:.0f} to {-1e3 * low:.0f} mm below the body" in found.said(machine)


def test_a_banned_place_is_no_foothold_of_that_leg_and_of_no_other_concern() -> None:
    reachable = along("line", field_of(0.1, 3, HEXAPOD))
    leg = 0
    hold = reachable.footholds[reachable.by_leg[leg][5]]
    before = list(reachable.existence)
    reachable.ban(leg, (hold.x, hold.y, hold.z), 0.1)
    for number, other in enumerate(reachable.footholds):
        near = math.hypot(other.x - hold.x, other.y - hold.y) <= 0.1
        gone = other.leg == leg and near
        assert reachable.existence[number] == (0 if gone else before[number])
