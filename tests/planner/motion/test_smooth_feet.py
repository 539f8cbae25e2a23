"""What the profile promises of every plan in which a foot swings, whoever planned it: no foot
changes its speed by more than a stair of the profile at once, and none exceeds its limit.
"""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import holes
from tests.planner.crab.crab_walks import walk as crab_walk
from tests.planner.trace.rollout import field_of, gait_of
from tests.planner.trace.rollout import walk as trace_walk
from walking_console.planner.geometry.transforms import point_seen
from walking_console.planner.motion.foot_placement import place_feet, place_foot
from walking_console.planner.motion.swing import EASED, peak
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.types import Command, Stance, StepPlan

TITAN = load_machine("titan3")
HEXAPOD = load_machine("hexapod")
RATES = np.diff([0.0, *(w for _, w in EASED)]) / np.diff([0.0, *(t for t, _ in EASED)])
STAIR = np.abs(np.diff(np.array([0.0, *RATES, 0.0]))).max() / peak(EASED)  # share of the limit
OPEN = TerrainMap(np.zeros((400, 400)), np.zeros((400, 400), bool), 0.05, (-10.0, -10.0))


def speeds_b(plan: StepPlan, leg: int) -> np.ndarray:
    """Mean velocities of a foot seen from the body, one per stretch, m/s."""
    seen = np.array(
        [point_seen(tuple(b), tuple(f)) for b, f in zip(plan.body, plan.feet[:, leg], strict=True)]
    )
    return np.diff(seen, axis=0) / np.diff(plan.times)[:, None]


def carried(plan: StepPlan, machine: Machine) -> np.ndarray:
    """How fast the body's own motion moves a standing foot at most, seen from it, m/s per axis: a
    foot gains or loses as much when it leaves the ground.
    """
    rates = np.abs(np.diff(plan.body, axis=0) / np.diff(plan.times)[:, None]).max(axis=0)
    reach = max(math.hypot(*leg.centre) for leg in machine.legs) + 0.5
    across = math.hypot(rates[0], rates[1]) + rates[3] * reach
    return np.array([across, across, rates[2]])


def worst(plan: StepPlan, machine: Machine) -> float:
    """The largest sudden change of a swing foot's speed over what is allowed; the last stretch ends
    on the ground.
    """
    limits = STAIR * np.array(machine.speed) + carried(plan, machine)
    most = 0.0
    for leg in plan.swing:
        velocities = speeds_b(plan, leg)
        ends = np.vstack([velocities, np.zeros(3)])
        jumps = np.abs(np.diff(ends, axis=0, prepend=np.zeros((1, 3))))
        most = max(most, float((jumps / limits).max()))
    return most


def fastest(plan: StepPlan, machine: Machine) -> float:
    """The largest speed of a swing foot over its limit."""
    return max(
        float((np.abs(speeds_b(plan, leg)) / np.array(machine.speed)).max()) for leg in plan.swing
    )


@pytest.mark.parametrize("crab_deg", [0, 50, 90, -130])
def test_no_foot_of_the_crab_walk_changes_its_speed_by_more_than_a_stair(crab_deg: int) -> None:
    plans = crab_walk(Command(math.radians(crab_deg), 0.1), 12, terrain=holes(0.1, 2))
    swings = [plan for plan in plans if plan.swing]
    assert max(worst(plan, TITAN) for plan in swings) <= 1.0 + 1e-6
    assert max(fastest(plan, TITAN) for plan in swings) <= 1.0 + 1e-6


@pytest.mark.parametrize("fraction", [1.0, 0.2])
@pytest.mark.parametrize("kind", ["line", "sine"])
def test_no_foot_of_the_trace_walk_changes_its_speed_by_more_than_a_stair(
    kind: str, fraction: float
) -> None:
    trace = trace_for({"kind": kind}, HEXAPOD)
    walked = trace_walk(
        HEXAPOD, field_of(fraction, 3, HEXAPOD), Command(speed=0.15), trace, steps=20
    )
    swings = [plan for plan in walked.steps if plan.swing]
    assert len(swings) > 10
    assert max(worst(plan, HEXAPOD) for plan in swings) <= 1.0 + 1e-6
    assert max(fastest(plan, HEXAPOD) for plan in swings) <= 1.0 + 1e-6


def lifted(legs: tuple[int, ...]) -> Stance:
    """A standing hexapod with these feet 0.15 m up."""
    feet = tuple(
        (*leg.centre, 0.15 if number in legs else 0.0) for number, leg in enumerate(HEXAPOD.legs)
    )
    return Stance((0.0, 0.0, HEXAPOD.height, 0.0), feet, lifted=legs)


@pytest.mark.parametrize("legs", [(1,), (0, 3)])
def test_no_foot_that_is_set_down_changes_its_speed_by_more_than_a_stair(
    legs: tuple[int, ...],
) -> None:
    terrain = field_of(0.05, 5, HEXAPOD)
    plan = place_feet(lifted(legs), legs, terrain, HEXAPOD, gait_of(HEXAPOD))
    assert isinstance(plan, StepPlan)
    assert plan.swing == legs
    assert worst(plan, HEXAPOD) <= 1.0 + 1e-6
    assert fastest(plan, HEXAPOD) <= 1.0 + 1e-6


def test_a_foot_straight_above_good_ground_comes_straight_down() -> None:
    plan = place_foot(lifted((1,)), 1, OPEN, HEXAPOD, gait_of(HEXAPOD))
    assert isinstance(plan, StepPlan)
    assert len(set(map(tuple, plan.feet[:, 1, :2].tolist()))) == 1
    assert plan.end.feet[1] == (*HEXAPOD.legs[1].centre, 0.0)
