"""Turning: exits and crossings on arcs, the standard walk on them, and every promise of a plan
whose body turns.
"""

import math

import numpy as np
import pytest

from tests.planner.crab.crab_walks import TITAN, gait, holes, random_stance
from walking_console.planner.config import configured
from walking_console.planner.crab.gait import nominal_gait_on, standard_stance, turns
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.geometry.paths import ArcPath, arc_exit, arc_of_command
from walking_console.planner.initial_stance import Placement
from walking_console.planner.stability import (
    MARGIN_SLACK,
    polygon_margin,
    stable_on_arc,
    support_polygon,
)
from walking_console.planner.types import Blocked, Command, Phase, Stance

YAW_LENGTH = TITAN.yaw_length
LEVEL = holes()
SLOW = 1.002  # of a speed limit: straight lines between knots in axes that turn


def on_circle(radius, degrees=0.0, pace=0.08, left=True):
    """The command that goes round a circle; radius 0 is a turn on the spot."""
    turn_rate = (1 if left else -1) * pace / math.hypot(radius, YAW_LENGTH)
    return Command(math.radians(degrees), abs(turn_rate) * radius, turn_rate)


def walk(command, turned, terrain=LEVEL, duty_factor=0.8, stance=None, steps=600):
    """Plans until the torso has turned so far (rad), each looked at; ends early with a
    ``Blocked``.
    """
    settings = gait(duty_factor)
    stance = stance or standard_stance(
        TITAN, settings, Placement((0.0, 0.0, 0.0), terrain.height_at, command.crab_angle)
    )
    plans, yaw = [], stance.body[3]
    for _ in range(steps):
        plan = plan_step(StepRequest(stance, command, terrain, TITAN, settings))
        plans.append(plan)
        if isinstance(plan, Blocked):
            break
        look_at(plan, stance, terrain)
        stance = plan.end
        if abs(stance.body[3] - yaw) >= turned:
            break
    return plans


def seen(plan):
    """Feet in body axes at every knot."""
    relative, yaw = plan.feet - plan.body[:, None, :3], plan.body[:, 3][:, None]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack(
        [
            c * relative[..., 0] + s * relative[..., 1],
            c * relative[..., 1] - s * relative[..., 0],
            relative[..., 2],
        ],
        -1,
    )


def look_at(plan, stance, terrain):
    """Standing feet stand, no foot is too fast or out of reach, the landing is allowed, the centre
    of gravity stays inside.
    """
    times = plan.times
    assert times[0] == 0.0 and np.all(np.diff(times) > 0.0) and len(plan.phases) == len(times) - 1
    np.testing.assert_allclose(plan.body[0], stance.body, atol=1e-9)
    np.testing.assert_allclose(plan.body[-1], plan.end.body, atol=1e-9)
    standing = [i for i in range(4) if i not in plan.swing]
    assert np.array_equal(
        plan.feet[:, standing],
        np.broadcast_to(plan.feet[0, standing], plan.feet[:, standing].shape),
    )
    feet = seen(plan)
    speeds = np.abs(np.diff(feet, axis=0)) / np.diff(times)[:, None, None]
    assert np.all(speeds <= np.array(TITAN.speed) * SLOW), speeds.max(axis=(0, 1))
    for i, leg in enumerate(TITAN.legs):
        over = TITAN.overreach if i in plan.swing else (1e-6, 1e-6, 1e-6)
        for axis, (low, high) in enumerate((leg.x, leg.y, leg.z)):
            assert np.all(
                (feet[:, i, axis] >= low - over[axis] - 1e-6)
                & (feet[:, i, axis] <= high + over[axis] + 1e-6)
            )
    for k, phase in enumerate(plan.phases):
        carrying = [
            stance.feet[i] for i in range(4) if i not in plan.swing or phase is Phase.SUPPORT
        ]
        polygon = support_polygon(carrying)
        for x, y in (plan.body[k, :2], plan.body[k + 1, :2]):
            assert polygon_margin(polygon, x, y) >= -MARGIN_SLACK
    if plan.swing:
        assert terrain.allows(*plan.landing[:2]) and plan.end.feet[plan.swing[0]] == plan.landing


def swung(plan):
    """Way of the body along the arc, shifts on four legs not counted, m."""
    return plan.shift if plan.swing else 0.0


def turned_by(plans):
    assert not isinstance(plans[-1], Blocked), plans[-1]
    return plans[-1].end.body[3] - plans[0].body[0, 3]


def test_the_exit_on_an_arc_is_the_end_of_the_existence_segment():
    rng = np.random.default_rng(5)
    box = TITAN.boxes[0]
    for _ in range(500):
        arc, _ = arc_of_command(
            rng.uniform(-3.1, 3.1),
            rng.uniform(0.0, 0.1),
            rng.choice([-1, 1]) * rng.uniform(0.01, 0.2),
            YAW_LENGTH,
        )
        x, y = rng.uniform(box[0], box[1]), rng.uniform(box[2], box[3])
        assert arc_exit(x, y, box, arc) == pytest.approx(arc.segment(x, y, box)[1], abs=1e-7)
    assert arc_exit(0.1, 0.5, box, ArcPath(1.0, 0.0, 0.1)) == 0.0
    assert arc_exit(0.71, 0.5, box, ArcPath(0.9, 0.0, 0.1)) == 0.0
    assert arc_exit(0.71, 0.5, box, ArcPath(0.9, 0.0, 0.1), 0.02) > 0.4, (
        "a foot that comes in is not out of reach"
    )
    assert arc_exit(0.19, 0.5, box, ArcPath(0.9, 0.0, 0.1), 0.02) == 0.0, "one that goes out is"


def test_along_an_arc_the_centre_of_gravity_is_inside_on_the_interval_and_on_the_edge_at_its_end():
    rng = np.random.default_rng(6)
    for _ in range(500):
        arc, _ = arc_of_command(
            rng.uniform(-3.1, 3.1),
            rng.uniform(0.02, 0.1),
            rng.choice([-1, 1]) * rng.uniform(0.01, 0.2),
            YAW_LENGTH,
        )
        inset = rng.choice([0.0, 0.02])
        triangle = support_polygon(rng.uniform(-0.7, 0.7, (3, 2)).tolist())
        low, high = stable_on_arc(triangle, *arc, inset)
        if low > min(high, 1.0) or high == math.inf:
            continue
        for s in np.linspace(max(low, -1.0), min(high, 1.0), 7):
            assert polygon_margin(triangle, *arc.pose(s)[:2]) >= inset - 1e-6
        assert polygon_margin(triangle, *arc.pose(high)[:2]) == pytest.approx(inset, abs=1e-6)


def test_on_the_spot_the_legs_go_round_one_after_the_other():
    """Each triangle is entered far: the leg before has just landed, the leg after is about to
    go.
    """
    for left, after in ((True, (1, 2, 3, 0)), (False, (3, 0, 1, 2))):
        command = on_circle(0.0, left=left)
        arc, _ = arc_of_command(0.0, 0.0, command.turn_rate, YAW_LENGTH)
        nominal = nominal_gait_on(TITAN, gait(), arc)
        assert nominal.order.successor == after
        assert nominal.margin > 0.15


def test_on_a_wide_circle_the_legs_go_as_on_a_straight_course():
    arc, _ = arc_of_command(0.0, 0.1, 0.1 / 20.0, YAW_LENGTH)
    assert nominal_gait_on(TITAN, gait(), arc).order.successor == (
        2,
        0,
        3,
        1,
    )  # 1-3-4-2 in H's numbers


def test_a_course_of_a_kilometres_radius_is_straight():
    assert not turns(Command(0.3, 0.1, 0.1 / 2000.0), TITAN)
    assert turns(Command(0.3, 0.1, 0.1 / 500.0), TITAN)
    assert turns(Command(0.0, 0.0, -1e-4), TITAN)


@pytest.mark.parametrize("left", [True, False])
def test_it_turns_right_round_on_the_spot_and_stays_there(left):
    plans = walk(on_circle(0.0, left=left), 2 * math.pi)
    assert abs(turned_by(plans)) >= 2 * math.pi
    assert math.hypot(*plans[-1].end.body[:2]) < 0.25
    assert len(plans) < 40


@pytest.mark.parametrize("radius", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("degrees", [0, 45, 90, 135, 180])
def test_it_goes_round_circles_at_any_crab_angle(radius, degrees):
    plans = walk(on_circle(radius, degrees, left=degrees % 90 == 0), 1.5)
    assert abs(turned_by(plans)) >= 1.5
    way, seconds = sum(map(swung, plans)), sum(plan.times[-1] for plan in plans)
    assert way / seconds > 0.55 * 0.08


@pytest.mark.parametrize("radius", [0.0, 1.0, 3.0])
def test_it_turns_on_foothold_map_which_three_cells_in_ten_are_forbidden(radius):
    plans = walk(on_circle(radius, 30.0), 2.0, holes(0.3, 11))
    assert abs(turned_by(plans)) >= 2.0


def test_it_turns_from_any_posture():
    rng = np.random.default_rng(12)
    for _ in range(20):
        stance = random_stance(rng)
        plans = walk(
            on_circle(rng.choice([0.0, 1.0, 4.0]), rng.uniform(-180, 180), left=rng.random() < 0.5),
            0.8,
            stance=stance,
        )
        assert abs(turned_by(plans)) >= 0.8


def stance_at_the_edges(rng):
    """Any standing posture whose feet are, every other coordinate, at an edge of their reach: where
    a turn of mind finds them.
    """

    def somewhere(low, high):
        return float(rng.choice([low, high, rng.uniform(low, high), rng.uniform(low, high)]))

    while True:
        feet = tuple((somewhere(*leg.x), somewhere(*leg.y), 0.0) for leg in TITAN.legs)
        if polygon_margin(support_polygon(feet), 0.0, 0.0) >= 0.0:
            return Stance((0.0, 0.0, TITAN.height, 0.0), feet, int(rng.integers(-1, 4)))


@pytest.mark.parametrize("fraction", [0.0, 0.3])
def test_with_feet_at_the_edges_of_their_reach_it_gets_on_within_seven_steps(fraction):
    for seed in (3, 13, 20, 21, 22, 23):  # the first two stood for good
        rng, ways = np.random.default_rng([seed, 5]), []
        stance, command = (
            stance_at_the_edges(rng),
            on_circle(rng.choice([0.0, 1.0, 4.0]), rng.uniform(-180, 180), left=rng.random() < 0.5),
        )
        for plan in walk(command, math.inf, holes(fraction, seed), stance=stance, steps=14):
            assert not isinstance(plan, Blocked), (seed, plan.text)
            ways.append(swung(plan))
        assert sum(ways[:7]) > 0.02 and sum(ways[7:]) > 0.02, (seed, ways)


def test_it_answers_alike_every_time_and_says_why_when_asked():
    settings, command = gait(), on_circle(1.0, 20.0)
    stance = standard_stance(TITAN, settings, Placement((0.0, 0.0, 0.0), LEVEL.height_at))
    request = StepRequest(stance, command, LEVEL, TITAN, settings, explain=True)
    one, two = (plan_step(request) for _ in range(2))
    assert np.array_equal(one.feet, two.feet) and one.decision == two.decision
    candidates = one.decision["lookahead"]["candidates"]
    assert candidates[0]["score"] >= candidates[-1]["score"]


@pytest.mark.parametrize("radius", [0.0, 1.0])
def test_a_step_of_a_turn_says_of_every_leg_what_came_of_it(radius):
    settings, terrain, command = gait(), holes(0.5, seed=4), on_circle(radius, 20.0)
    stance = standard_stance(TITAN, settings, Placement((0.0, 0.0, 0.0), terrain.height_at))
    reasons, cells = set(), 0
    for _ in range(30):
        plan = plan_step(StepRequest(stance, command, terrain, TITAN, settings, explain=True))
        silent = plan_step(StepRequest(stance, command, terrain, TITAN, settings))
        assert np.array_equal(plan.feet, silent.feet) and silent.decision is None, (
            "explaining changed the plan"
        )
        legs = plan.decision["legs"]
        assert sorted(trial["leg"] for trial in legs) == [1, 2, 3, 4]
        reasons |= {trial.get("reason", "") for trial in legs}
        if plan.swing:
            (taken,) = [trial for trial in legs if trial["leg"] == plan.swing[0] + 1]
            assert (
                "reason" not in taken
                and taken["g0"] == plan.support_shift
                and taken["g"] == plan.shift
            )
            assert all(not terrain.allows(cell["x"], cell["y"]) for cell in taken["refused"])
            cells += len(taken["refused"])
            corners = np.array(plan.decision["domain"])
            assert (
                support_polygon(corners.tolist())
                and polygon_margin(support_polygon(corners.tolist()), *plan.landing[:2]) >= -1e-6
            )
        stance = plan.end
    assert cells > 0 and any("triangle" in reason for reason in reasons)


def test_where_no_foot_may_land_it_says_so():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), LEVEL.height_at))
    command, plans = on_circle(0.0), []
    for _ in range(12):
        plan = plan_step(StepRequest(stance, command, holes(1.0), TITAN, gait()))
        plans.append(plan)
        if isinstance(plan, Blocked):
            break
        stance = plan.end
    assert isinstance(plans[-1], Blocked) and "arc" in plans[-1].text


def test_how_far_inside_the_triangle_it_stays_can_be_set():
    stance = standard_stance(TITAN, gait(), Placement((0.0, 0.0, 0.0), LEVEL.height_at, 0.0))
    kept = []
    for inset in (0.0045, 0.006):
        config = configured({"turning": {"inset": inset}})
        plan = plan_step(StepRequest(stance, on_circle(2.0), LEVEL, TITAN, gait(), config=config))
        kept.append(plan.margin_min)
    assert 0.0 < kept[0] < kept[1]
