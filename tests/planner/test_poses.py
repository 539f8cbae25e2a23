"""Sitting down, standing up and back into the standard layout, from random postures on level,
forbidden and rough ground.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.sweeps.postures import MACHINES, gait_of, ground_of, random_stance
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.postures import GIVE, STILL, THERE, Poses, regroup, sit, stand
from walking_console.planner.motion.swing import CLEARANCE
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.registry import initial_stance
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Gait, Phase, Stance, StepPlan

GROUNDS = ("level", "30 % forbidden", "80 % forbidden", "rough")
POSTURES = 40  # of each machine on each ground
ROUND = 1e-6  # m, and m/s


def in_body(plan: StepPlan) -> np.ndarray:
    """Foot tips of every knot as the body sees them, (m, n, 3)."""
    relative = plan.feet - plan.body[:, None, :3]
    c, s = np.cos(plan.body[:, 3])[:, None], np.sin(plan.body[:, 3])[:, None]
    return np.stack(
        [
            c * relative[..., 0] + s * relative[..., 1],
            c * relative[..., 1] - s * relative[..., 0],
            relative[..., 2],
        ],
        axis=-1,
    )


def assert_sound(plans: Poses, start: Stance, terrain: TerrainMap, machine: Machine) -> None:
    """What holds for every posture being taken: one story without jumps, on feet that carry, in
    reach, within speed, over the ground.
    """
    body, feet = start.body, start.feet
    for plan in plans:
        assert plan.body[0] == pytest.approx(body) and plan.feet[0].ravel() == pytest.approx(
            np.array(feet).ravel()
        )
        assert (
            len(plan.swing) <= 1
            and len(plan.phases) == len(plan.times) - 1
            and (np.diff(plan.times) > 0.0).all()
        )
        seen = in_body(plan)
        speeds = np.abs(np.diff(seen, axis=0)) / np.diff(plan.times)[:, None, None]
        assert (speeds.max(axis=(0, 1)) <= np.array(machine.speed) + ROUND).all()
        standing = [leg for leg in range(len(feet)) if leg not in plan.swing]
        assert (plan.feet[:, standing] == plan.feet[0, standing]).all(), (
            "feet that stand stay where they are"
        )
        polygon = support_polygon([feet[leg] for leg in standing])
        assert min(polygon_margin(polygon, x, y) for x, y in plan.body[:, :2]) >= -ROUND
        for index, leg in enumerate(machine.legs):
            for axis, (low, high) in enumerate((leg.x, leg.y, leg.z)):
                over = (
                    machine.overreach[axis] + ROUND
                    if index in plan.swing and axis == 2
                    else STILL + ROUND
                )
                assert (
                    seen[:, index, axis].min() >= low - over
                    and seen[:, index, axis].max() <= high + over
                ), (leg.name, "xyz"[axis])
        if plan.swing:
            assert (plan.body == plan.body[0]).all(), "the body waits while a foot is in the air"
            assert_swings_clear(plan, terrain)
        body, feet = plan.end.body, plan.end.feet


def assert_swings_clear(plan: StepPlan, terrain: TerrainMap) -> None:
    u, landing = plan.swing[0], plan.landing
    assert landing is not None and terrain.allows(landing[0], landing[1])
    k = plan.phases.index(Phase.RETURN) if Phase.RETURN in plan.phases else None
    if k is not None:
        a, b = plan.feet[k, u], plan.feet[k + 1, u]
        for w in np.linspace(0.0, 1.0, 40):
            x, y, z = a + w * (b - a)
            assert z >= terrain.height_at(x, y) + CLEARANCE - ROUND


def places(
    machine: Machine, leg: int, goal: Stance, stance: Stance, terrain: TerrainMap, gait: Gait
) -> list[float]:
    """Distances from a foot's place of every cell centre it could have taken instead, by looking at
    them all.
    """
    (gx, gy, _), (x1, x2, y1, y2), (low, high) = (
        goal.feet[leg],
        machine.boxes[leg],
        machine.legs[leg].z,
    )
    bx, by, _, yaw = goal.body
    level = sum(foot[2] for foot in stance.feet) / len(stance.feet) + gait.height
    c, s = math.cos(yaw), math.sin(yaw)
    found = []
    for row, column in zip(*np.nonzero(~terrain.forbidden), strict=True):
        px, py = terrain.centre(int(row), int(column))
        u, v = c * (px - bx) + s * (py - by), c * (py - by) - s * (px - bx)
        if x1 <= u <= x2 and y1 <= v <= y2 and low <= terrain.height_at(px, py) - level <= high:
            found.append(math.hypot(px - gx, py - gy))
    return found


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
        plans = run_to_completion(regroup(stance, goal, terrain, machine, gait, angle))
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
            plans = run_to_completion(regroup(stance, goal, terrain, machine, gait))
            assert not isinstance(plans, Blocked), plans.text
            assert_sound(plans, stance, terrain, machine)
            assert all(
                math.dist(foot, place) <= THERE
                for foot, place in zip(plans[-1].end.feet, goal.feet, strict=True)
            )


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


def level_stance(machine: Machine) -> tuple[Stance, Gait, TerrainMap]:
    gait, terrain = gait_of(machine), ground_of("level", machine, np.random.default_rng(1))
    return (
        initial_stance(
            "crab", "", machine, gait, Placement((0.0, 0.0, 0.0), terrain.height_at, 0.0)
        ),
        gait,
        terrain,
    )


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
        run_to_completion(regroup(hanging, stance, terrain, machine, gait)),
    ):
        assert isinstance(answer, Blocked) and answer.leg == 2 and "set down first" in answer.text


def test_feet_that_stand_in_their_places_stay_there() -> None:
    machine = load_machine("titan3")
    stance, gait, terrain = level_stance(machine)
    nudged = replace(
        stance,
        feet=((stance.feet[0][0] - 0.008, *stance.feet[0][1:]), *stance.feet[1:]),
        last_swing=-1,
    )
    plans = run_to_completion(regroup(nudged, stance, terrain, machine, gait))
    assert not isinstance(plans, Blocked)
    assert all(plan.swing == () for plan in plans) and plans[-1].end.feet == nudged.feet
    assert plans[-1].end.last_swing == stance.last_swing
    moved = replace(
        stance, feet=((stance.feet[0][0] - 0.05, *stance.feet[0][1:]), *stance.feet[1:])
    )
    plans = run_to_completion(regroup(moved, stance, terrain, machine, gait))
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
    answer = run_to_completion(regroup(stance, there, nowhere, machine, gait))
    assert isinstance(answer, Blocked) and answer.leg == 0 and "no foothold" in answer.text


def test_the_search_is_the_same_every_time_and_pauses() -> None:
    machine, rng = load_machine("titan3"), np.random.default_rng(3)
    gait, terrain = gait_of(machine), ground_of("30 % forbidden", machine, rng)
    stance = random_stance(machine, gait, terrain, rng)
    goal = initial_stance(
        "crab", "", machine, gait, Placement((0.0, 0.0, stance.body[3]), terrain.height_at, 0.4)
    )

    def searched() -> tuple[int, list[list[float]]]:
        thinking, pauses = regroup(stance, goal, terrain, machine, gait), 0
        while True:
            try:
                next(thinking)
                pauses += 1
            except StopIteration as done:
                return pauses, [plan.feet.ravel().tolist() for plan in done.value]

    first = searched()
    assert first[0] > 5 and first == searched()
