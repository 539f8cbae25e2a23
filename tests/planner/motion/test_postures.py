"""Sitting down and standing up, from random postures on level, forbidden and rough ground."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.motion.posture_rules import GROUNDS, POSTURES, ROUND, in_body, level_stance
from tests.sweeps.postures import MACHINES, gait_of, ground_of, random_stance
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.postures import GIVE, STILL, sit, stand
from walking_console.planner.motion.return_to_nominal import return_to_nominal
from walking_console.planner.motion.swing import CLEARANCE
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.registry import initial_stance
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked


@pytest.mark.parametrize("kind", GROUNDS)
@pytest.mark.parametrize("name", MACHINES)
def test_it_sits_down_on_its_feet_and_stands_up_again(name: str, kind: str) -> None:
    machine, rng = load_machine(name), np.random.default_rng([8, len(name), GROUNDS.index(kind)])
    gait = gait_of(machine)
    for _ in range(POSTURES):
        terrain = ground_of(kind, machine, rng)
        stance = random_stance(machine, gait, terrain, rng)
        down = sit(stance, terrain, machine, gait)
        assert not isinstance(down, Blocked), down.text
        low = down[-1].end if down else stance
        up = stand(low, terrain, machine, gait)
        assert not isinstance(up, Blocked)
        for plan in (*down, *up):
            speeds = np.abs(np.diff(in_body(plan), axis=0)) / np.diff(plan.times)[:, None, None]
            assert plan.swing == () and speeds.max() <= machine.speed[2]
            assert (plan.feet == plan.feet[0]).all() and (
                plan.body[:, [0, 1, 3]] == plan.body[0, [0, 1, 3]]
            ).all()
            for leg, heights in zip(machine.legs, in_body(plan)[..., 2].T, strict=True):
                assert (
                    heights.min() >= leg.z[0] - ROUND
                    and heights.max() <= leg.z[1] + machine.overreach[2] - GIVE + ROUND
                )
        assert low.body[2] < stance.body[2] and low.feet == stance.feet
        assert (up[-1].end if up else low).body == pytest.approx(stance.body, abs=STILL)


def raised(
    terrain: TerrainMap, x: tuple[float, float], y: tuple[float, float], height: float
) -> TerrainMap:
    heights = terrain.heights.copy()
    columns, rows = (
        slice(*(math.floor((v - origin) / terrain.cell) for v in span))
        for span, origin in zip((x, y), terrain.origin, strict=True)
    )
    heights[rows, columns] = height
    return replace(terrain, heights=heights)


def test_how_low_it_sits_is_what_the_legs_reach_or_what_the_torso_clears() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    plans = sit(stance, terrain, machine, gait)
    assert not isinstance(plans, Blocked)
    assert plans[-1].end.body[2] == pytest.approx(0.60 - 0.15 + GIVE)
    plans = sit(stance, raised(terrain, (-0.2, 0.2), (-0.2, 0.2), 0.4), machine, gait)
    assert not isinstance(plans, Blocked)
    assert plans[-1].end.body[2] == pytest.approx(0.4 + 0.125 + CLEARANCE)


def test_a_small_machine_lies_nearly_on_the_ground() -> None:
    machine = load_machine("phantomx")
    gait, terrain = gait_of(machine), ground_of("level", machine, np.random.default_rng(1))
    stance = initial_stance(
        "trace", "", machine, gait, Placement((0.0, 0.0, 0.0), terrain.height_at, 0.0)
    )
    plans = sit(stance, terrain, machine, gait)
    assert not isinstance(plans, Blocked)
    assert plans[-1].end.body[2] == pytest.approx(0.045, abs=0.006)


def test_it_does_not_sit_down_onto_a_pole_beside_its_leg() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    foot, (hip_x, hip_y) = stance.feet[0], machine.hips[0]
    x, y = (foot[0] + hip_x) / 2, (foot[1] + hip_y) / 2
    free = sit(stance, terrain, machine, gait)
    met = sit(
        stance, raised(terrain, (x - 0.03, x + 0.03), (y - 0.03, y + 0.03), 0.35), machine, gait
    )
    assert not isinstance(free, Blocked) and not isinstance(met, Blocked)
    assert free[-1].end.body[2] + 0.1 < met[-1].end.body[2] < stance.body[2]
    blocked = sit(
        stance, raised(terrain, (x - 0.03, x + 0.03), (y - 0.03, y + 0.03), 0.44), machine, gait
    )
    assert isinstance(blocked, Blocked) and "ground beside it" in blocked.text and blocked.leg == 0


def test_with_a_foot_in_the_air_no_posture_is_taken() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    hanging = replace(stance, lifted=(2,))
    for answer in (
        sit(hanging, terrain, machine, gait),
        stand(hanging, terrain, machine, gait),
        run_to_completion(return_to_nominal(hanging, stance, terrain, machine, gait)),
    ):
        assert isinstance(answer, Blocked) and answer.leg == 2 and "set down first" in answer.text
