"""Back into the nominal layout, from random postures on level, forbidden and rough ground."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.planner.motion.posture_rules import (
    GROUNDS,
    POSTURES,
    ROUND,
    assert_sound,
    level_stance,
    places,
)
from tests.sweeps.postures import MACHINES, gait_of, ground_of, random_stance
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.postures import STILL
from walking_console.planner.motion.return_to_nominal import THERE, return_to_nominal
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.registry import initial_stance
from walking_console.planner.robot.model import load_machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.types import Blocked


@pytest.mark.parametrize("kind", GROUNDS)
@pytest.mark.parametrize("name", MACHINES)
def test_from_every_posture_the_feet_come_back_into_the_standard_layout(
    name: str, kind: str
) -> None:
    machine, rng, stuck, beside = (
        load_machine(name),
        np.random.default_rng([7, len(name), GROUNDS.index(kind)]),
        [],
        0,
    )
    crab = MACHINES[name] == "crab"
    for _ in range(POSTURES):
        gait = gait_of(machine, float(rng.uniform(0.75, 0.9)) if crab else None)
        terrain = ground_of(kind, machine, rng)
        stance = random_stance(machine, gait, terrain, rng)
        angle = float(rng.uniform(-math.pi, math.pi))
        goal = initial_stance(
            MACHINES[name],
            "",
            machine,
            gait,
            Placement((0.0, 0.0, stance.body[3]), terrain.height_at, angle),
        )
        plans = run_to_completion(return_to_nominal(stance, goal, terrain, machine, gait, angle))
        if isinstance(plans, Blocked):
            stuck.append(plans.text)
            continue
        assert_sound(plans, stance, terrain, machine)
        end = plans[-1].end
        assert (
            end.body[:2] == pytest.approx((0.0, 0.0), abs=STILL) and end.body[3] == stance.body[3]
        )
        assert (end.last_swing, end.quarter_turns, end.lifted) == (
            goal.last_swing,
            goal.quarter_turns,
            (),
        )
        assert polygon_margin(support_polygon(end.feet), 0.0, 0.0) > 0.0
        for leg, (foot, place) in enumerate(zip(end.feet, goal.feet, strict=True)):
            off = math.dist(foot[:2], place[:2])
            if off > THERE:
                assert not terrain.allows(*place[:2]) or kind == "rough"
                assert terrain.allows(*foot[:2])
                beside += off > min(places(machine, leg, goal, stance, terrain, gait)) + ROUND
    assert len(stuck) <= (1 if kind == "rough" else 0), stuck
    assert beside <= 0.01 * POSTURES * len(machine.legs), (
        "the nearest cell that may be stepped on, but for one foot in a hundred"
    )


@pytest.mark.parametrize("duty_factor", (0.75, 0.8, 0.9))
def test_from_the_standard_posture_of_every_course_to_that_of_every_other(
    duty_factor: float,
) -> None:
    """Feet at both ends of their reach leave the body a line to sway along, or nothing."""
    machine = load_machine("titan3")
    gait, terrain = (
        gait_of(machine, duty_factor),
        ground_of("level", machine, np.random.default_rng(1)),
    )
    layouts = [
        initial_stance(
            "crab",
            "",
            machine,
            gait,
            Placement((0.0, 0.0, 0.0), terrain.height_at, math.radians(d)),
        )
        for d in range(-180, 180, 30)
    ]
    for stance in layouts:
        for goal in layouts:
            plans = run_to_completion(return_to_nominal(stance, goal, terrain, machine, gait))
            assert not isinstance(plans, Blocked), plans.text
            assert_sound(plans, stance, terrain, machine)
            assert all(
                math.dist(foot, place) <= THERE
                for foot, place in zip(plans[-1].end.feet, goal.feet, strict=True)
            )


def test_feet_that_stand_in_their_places_stay_there() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    nudged = replace(
        stance,
        feet=((stance.feet[0][0] - 0.008, *stance.feet[0][1:]), *stance.feet[1:]),
        last_swing=-1,
    )
    plans = run_to_completion(return_to_nominal(nudged, stance, terrain, machine, gait))
    assert not isinstance(plans, Blocked)
    assert all(plan.swing == () for plan in plans) and plans[-1].end.feet == nudged.feet
    assert plans[-1].end.last_swing == stance.last_swing
    moved = replace(
        stance, feet=((stance.feet[0][0] - 0.05, *stance.feet[0][1:]), *stance.feet[1:])
    )
    plans = run_to_completion(return_to_nominal(moved, stance, terrain, machine, gait))
    assert not isinstance(plans, Blocked)
    assert [plan.swing for plan in plans if plan.swing] == [(0,)] and plans[
        -1
    ].end.feet == stance.feet


def test_where_nothing_may_be_stepped_on_it_says_of_which_leg() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    nowhere = replace(terrain, forbidden=np.ones_like(terrain.forbidden))
    there = replace(
        stance, body=(5.0, *stance.body[1:]), feet=tuple((x + 5.0, y, z) for x, y, z in stance.feet)
    )
    answer = run_to_completion(return_to_nominal(stance, there, nowhere, machine, gait))
    assert isinstance(answer, Blocked) and answer.leg == 0 and "no foothold" in answer.text


def test_the_search_is_the_same_every_time_and_pauses() -> None:
    machine, rng = load_machine("titan3"), np.random.default_rng(3)
    gait, terrain = gait_of(machine), ground_of("30 % forbidden", machine, rng)
    stance = random_stance(machine, gait, terrain, rng)
    goal = initial_stance(
        "crab", "", machine, gait, Placement((0.0, 0.0, stance.body[3]), terrain.height_at, 0.4)
    )

    def searched() -> tuple[int, list[list[float]]]:
        thinking, pauses = return_to_nominal(stance, goal, terrain, machine, gait), 0
        while True:
            try:
                next(thinking)
                pauses += 1
            except StopIteration as done:
                return pauses, [plan.feet.ravel().tolist() for plan in done.value]

    first = searched()
    assert first[0] > 5 and first == searched()
