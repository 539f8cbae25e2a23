"""Steps with the body swayed into its supports: same decisions, margin and acceleration kept."""

import math
from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner.control.load_schedule import body_frame_feet
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.crab.expected_supports import expected_supports
from walking_console.planner.crab.gait import standard_stance
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.geometry.polygons import Polygon
from walking_console.planner.geometry.transforms import Body, placed, seen
from walking_console.planner.initial_stance import Placement
from walking_console.planner.motion.body_bounds import BRISK, bounds_of
from walking_console.planner.motion.body_course import centre_over
from walking_console.planner.motion.body_path import SupportPhase
from walking_console.planner.motion.body_sway import swaying
from walking_console.planner.motion.body_tilt import Lean
from walking_console.planner.motion.step_builder import changed, holding_plan
from walking_console.planner.protocols import Announced, run_to_completion
from walking_console.planner.robot.collision import leg_in_the_way
from walking_console.planner.robot.model import load_machine
from walking_console.planner.stability import GRAVITY, polygon_margin, support_polygon
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import TICK, Command, Gait, Phase, Stance, StepPlan

TITAN = load_machine("titan3")
GAIT = Gait(0.8, TITAN.lift_up, TITAN.lift_down, TITAN.height, sways=True)
FLAT = TerrainMap.from_heights(np.zeros((400, 400)), 0.05, TITAN, (-10.0, -10.0))
ANGLES = range(0, 360, 45)


def swayed(*given) -> StepPlan:
    """The plan swayed, all at once."""
    return run_to_completion(swaying(*given))


def walked(
    angle: float, steps: int, gait: Gait = GAIT, speed: float = 0.08
) -> list[tuple[Stance, StepPlan, StepPlan]]:
    """So many steps over level ground: where each begins, as it was decided, and swayed."""
    command = Command(math.radians(angle), speed)
    stance = standard_stance(
        TITAN, gait, Placement((0.0, 0.0, 0.0), lambda x, y: 0.0, command.crab_angle)
    )
    out = []
    for _ in range(steps):
        decided = plan_step(StepRequest(stance, command, FLAT, TITAN, gait))
        assert isinstance(decided, StepPlan)
        ahead = expected_supports(decided, command, TITAN, gait)
        plan = swayed(decided, stance, ahead, gait, TITAN, FLAT)
        out.append((stance, decided, plan))
        stance = plan.end
    return out


def played(plans: list[StepPlan]) -> list[tuple[StepPlan, float, tuple[float, ...]]]:
    """Where the plans have the body, tick by tick: plan, time into it, x, y, z, yaw."""
    rows = []
    left = 0.0
    for plan in plans:
        tracker = TrajectoryTracker(plan)
        t = left
        while t <= tracker.duration:
            rows.append((plan, t, tracker.body_at(t)))
            t += TICK
        left = t - tracker.duration
    return rows


def carrying(plan: StepPlan, t: float) -> Polygon:
    """What the feet that carry at a time into the plan span."""
    phase = plan.phases[TrajectoryTracker(plan).stretch(t)]
    return support_polygon(
        foot
        for leg, foot in enumerate(plan.feet[0])
        if phase is Phase.SUPPORT or leg not in plan.swing
    )


def true_margin(plan: StepPlan, t: float, body: Body) -> float:
    """Polygon margin of the centre of gravity with its legs, m."""
    tracker = TrajectoryTracker(plan)
    dx, dy = centre_over(TITAN, body, [tracker.foot_at(leg, t) for leg in range(4)])
    return polygon_margin(carrying(plan, t), body[0] + dx, body[1] + dy)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_polygon_margin_is_kept_at_every_crab_angle(angle):
    steps = walked(angle, 12)
    for plan, t, (x, y, _, _) in played([plan for _, _, plan in steps[1:]]):
        assert polygon_margin(carrying(plan, t), x, y) >= 0.02 - 0.001


@pytest.mark.parametrize("angle", ANGLES)
def test_the_body_never_speeds_up_or_slows_down_more_than_its_margin_allows(angle):
    rows = played([plan for _, _, plan in walked(angle, 10)])
    places = np.array([place[:2] for _, _, place in rows])
    accelerations = np.hypot(*(np.diff(places, 2, axis=0) / TICK**2).T)
    margins = [true_margin(*row) for row in rows]
    for acceleration, *around in zip(
        accelerations, margins, margins[1:], margins[2:], strict=False
    ):
        # where a leg lifts or lands between two ticks, that of before or of after
        assert acceleration <= 1.05 * GRAVITY * max(around) / TITAN.height
    assert (
        1.2 * bounds_of(walked(angle, 1)[0][0], GAIT).acceleration
        < max(accelerations)
        <= 1.05 * BRISK
    )


@pytest.mark.parametrize("angle", [0, 16, 45, 74, 90, 200])
def test_the_decisions_are_those_of_the_straight_walk(angle):
    straight = replace(GAIT, sways=False)
    for (_, decided, plan), (_, other, _) in zip(
        walked(angle, 8), walked(angle, 8, straight), strict=True
    ):
        assert plan.swing == other.swing and plan.landing == pytest.approx(other.landing)
        assert (plan.support_shift, plan.shift) == pytest.approx((other.support_shift, other.shift))
        assert plan.end.body == pytest.approx(other.end.body)
        assert decided.end.feet == plan.end.feet


@pytest.mark.parametrize("angle", ANGLES)
def test_the_body_stays_within_five_centimetres_of_the_reference(angle):
    for _, decided, plan in walked(angle, 8):
        heading = plan.body[0, 3] + plan.crab_angle
        for x, y, _, _ in plan.body:
            _, across = seen((*decided.body[0, :2], heading), x, y)
            assert abs(across) <= 0.05 + 1e-9


@pytest.mark.parametrize("angle", [0, 45, 90])
def test_place_and_velocity_go_on_from_step_to_step(angle):
    steps = walked(angle, 8)
    for (_, _, plan), (_, _, after) in zip(steps, steps[1:], strict=False):
        assert after.body[0] == pytest.approx(plan.body[-1])
        assert after.rates[0, :2] == pytest.approx(plan.rates[-1, :2], abs=2e-3)


def test_a_straight_body_is_left_as_it_was_planned():
    straight = replace(GAIT, sways=False)
    assert all(plan is decided for _, decided, plan in walked(45, 4, straight))


def test_feet_keep_their_speed_limits():
    for _, _, plan in walked(45, 8, speed=0.5):
        rates = plan.rates
        for k in range(len(plan.times) - 1):
            for knot in (k, k + 1):
                against = abs(plan.foot_rates[knot] - rates[knot, :3]) / TITAN.speed
                assert against.max() <= 1.01


def test_a_body_that_is_beside_its_next_support_waits_before_the_leg_lifts():
    stance, decided, _ = walked(45, 3)[1]
    beside = replace(stance, sway=(-stance.sway[0], -stance.sway[1]), velocity=(0.0, 0.0))
    plan = swayed(decided, beside, (), GAIT, TITAN)
    lift = next(k for k, phase in enumerate(plan.phases) if phase is not Phase.SUPPORT)
    triangle = support_polygon(
        foot for leg, foot in enumerate(plan.feet[0]) if leg not in plan.swing
    )
    assert plan.times[lift] > 0.2
    assert polygon_margin(triangle, *plan.body[lift, :2]) >= 0.02 - 1e-3


def test_a_swaying_walk_loses_a_tenth_of_its_speed_on_average_and_a_quarter_at_most():
    """Ahead it loses none; the mean is over 24 angles."""
    lost = []
    for angle in range(0, 180, 15):
        steps = walked(angle, 16)[8:]
        way = sum(decided.shift for _, decided, _ in steps)
        seconds = sum(plan.times[-1] for _, _, plan in steps)
        lost.append(1.0 - way / seconds / 0.08)
    assert lost[0] <= 0.01
    assert np.mean(lost) <= 0.1 and max(lost) <= 0.25


def test_a_shift_on_all_feet_sways_no_farther_to_the_next_support_than_the_legs_reach():
    stance = standard_stance(TITAN, GAIT, Placement((0.0, 0.0, 0.0), lambda x, y: 0.0, 0.0))
    x, y, z, yaw = stance.body
    lowest = [leg.y[0] - TITAN.overreach[1] for leg in TITAN.legs]
    feet = zip(stance.feet, lowest, strict=True)
    near = min(foot[1] - y - low for foot, low in feet) - 0.015  # 15 mm to the left are left
    stance = replace(stance, body=(x, y + near, z, yaw))
    shift = changed(holding_plan(stance), times=np.array((0.0, 2.0)), speed=0.08)
    beside = [(x + dx, y + near + dy) for dx, dy in ((-0.5, 0.0), (0.5, 0.0), (0.5, 0.4))]
    support = SupportPhase(0.5, 1.5, tuple(beside), *2 * (stance.body[:2],))
    swayed_to = swayed(shift, stance, (support,), GAIT, TITAN).end.sway[1]
    assert 0.005 <= swayed_to <= 0.015


def leaning(
    stance: Stance, decided: StepPlan, before: Lean, after: Lean
) -> tuple[Stance, StepPlan]:
    """The same on a slope along ``after``, under a body that leans over from ``before`` to it."""
    feet = decided.feet.copy()
    body = decided.body.copy()
    for rows in (feet, body):
        rows[..., 2] += after[0] * rows[..., 0] + after[1] * rows[..., 1]
    x, y, z, yaw = stance.body
    raised = (x, y, z + after[0] * x + after[1] * y, yaw)
    stands = replace(stance, body=raised, feet=tuple(map(tuple, feet[0].tolist())), lean=before)
    ends = tuple((a, b, c + after[0] * a + after[1] * b) for a, b, c in decided.end.feet)
    end = replace(decided.end, body=tuple(body[-1].tolist()), feet=ends, lean=after)
    return stands, changed(decided, body=body, feet=feet, end=end, lean=before)


@pytest.mark.parametrize("before", [(0.1, 0.05), (0.09, 0.04)])
@pytest.mark.parametrize("angle", [45, 90])
def test_a_body_that_leans_sways_along_its_floor(angle, before):
    after = (0.1, 0.05)
    stance, decided, _ = walked(angle, 3)[-1]
    stance, decided = leaning(stance, decided, before, after)
    ahead = expected_supports(decided, Command(math.radians(angle), 0.08), TITAN, GAIT)
    plan = swayed(decided, stance, ahead, GAIT, TITAN, FLAT)
    tracker = TrajectoryTracker(plan)
    assert plan.end.place == pytest.approx(plan.body[-1].tolist())
    assert np.hypot(*plan.end.sway) > 0.01 and plan.polygon_margin_min >= 0.02
    for t in np.arange(0.0, tracker.duration, TICK).tolist():
        x, y, z, _ = tracker.body_at(t)
        # where the reference is then, its height is that of the floor it leans by
        k = np.argmin(np.hypot(*(decided.body[:, :2] - (x, y)).T))
        rx, ry, rz, _ = decided.body[k]
        lean = tracker.lean_at(t)
        floor = rz + after[0] * (x - rx) + after[1] * (y - ry)
        assert z == pytest.approx(floor, abs=0.05 * math.dist(lean, after) + 1e-6)


def test_the_legs_of_a_body_that_leans_reach_their_feet_and_keep_their_speed():
    after = (0.03, -0.02)
    stance, decided, level = walked(45, 3)[-1]
    stance, decided = leaning(stance, decided, after, after)
    plan = swayed(decided, stance, (), GAIT, TITAN, FLAT)
    tracker = TrajectoryTracker(plan)
    before: list[tuple[float, ...]] | None = None
    for t in np.arange(0.0, tracker.duration, TICK).tolist():
        feet = body_frame_feet(tracker, t)
        for leg, foot in enumerate(feet):
            spec = TITAN.legs[leg]
            for value, (low, high), over in zip(
                foot[:2], (spec.x, spec.y), TITAN.overreach, strict=False
            ):
                assert leg in plan.swing or low - over <= value <= high + over
        if before is not None:
            moved = np.abs(np.array(feet) - before) / TICK
            assert (moved <= np.array(TITAN.speed) * 1.01).all()
        before = feet
    assert tracker.duration < 1.5 * float(level.times[-1])


def test_a_step_is_swayed_piece_by_piece_and_what_a_piece_weighs_is_said_before_it_is_done():
    stance, decided, plan = walked(90, 3)[-1]
    ahead = expected_supports(decided, Command(math.radians(90), 0.08), TITAN, GAIT)
    heights = np.zeros((400, 400))
    heights[sorted(cells_beside(plan, decided))[0]] = 1.5
    poles = TerrainMap(heights, heights > 0.0, 0.05, (-10.0, -10.0), TITAN.foot_radius)
    weighed = {}
    for terrain in (FLAT, poles):
        job = swaying(decided, stance, ahead, GAIT, TITAN, terrain)
        weights = []
        while True:
            try:
                weights.append(next(job))
            except StopIteration as done:
                way = done.value
                break
        assert np.array_equal(way.body, swayed(decided, stance, ahead, GAIT, TITAN, terrain).body)
        assert all(isinstance(weight, Announced) and weight > 0 for weight in weights)
        weighed[terrain] = weights
    assert len(weighed[FLAT]) >= 3 and len(weighed[poles]) > len(weighed[FLAT])
    assert max(weighed[poles]) > max(weighed[FLAT])


def test_a_body_that_would_lead_a_leg_into_a_pole_goes_nearer_to_its_reference():
    """Twenty poles, each on the line of a leg of the swayed body and not of one as decided."""
    stance, decided, plan = walked(90, 3)[-1]
    ahead = expected_supports(decided, Command(math.radians(90), 0.08), TITAN, GAIT)
    before = after = 0
    for cell in sorted(cells_beside(plan, decided)):
        heights = np.zeros((400, 400))
        heights[cell] = 1.5
        terrain = TerrainMap(heights, heights > 0.0, 0.05, (-10.0, -10.0), TITAN.foot_radius)
        way = swayed(decided, stance, ahead, GAIT, TITAN, terrain)
        before += met(plan, terrain)
        after += met(way, terrain)
        assert met(way, terrain) <= met(plan, terrain)
    assert 0 < after < 0.4 * before


def met(plan: StepPlan, terrain: TerrainMap) -> int:
    """Ticks of a plan in which a leg's line is in something tall."""
    tracker = TrajectoryTracker(plan)
    times = np.arange(0.0, tracker.duration, TICK).tolist()
    feet = ([tracker.foot_at(leg, t) for leg in range(4)] for t in times)
    rows = zip(times, feet, strict=True)
    return sum(leg_in_the_way(terrain, TITAN, tracker.body_at(t), at) is not None for t, at in rows)


def cells_beside(plan: StepPlan, decided: StepPlan) -> set[tuple[int, int]]:
    """Cells that lines of legs go through with the body swayed, and not with it on its way as
    decided.
    """
    lines = []
    for way in (plan, decided):
        tracker = TrajectoryTracker(way)
        cells = set()
        for t in np.arange(0.0, tracker.duration, TICK).tolist():
            x, y, _, yaw = tracker.body_at(t)
            for leg in range(4):
                foot = tracker.foot_at(leg, t)
                hip = placed((x, y, yaw), *TITAN.hips[leg])
                for share in np.linspace(0.0, 0.8, 40).tolist():
                    px, py = (a + share * (b - a) for a, b in zip(hip, foot[:2], strict=True))
                    cells.add((math.floor((py + 10.0) / 0.05), math.floor((px + 10.0) / 0.05)))
        lines.append(cells)
    return lines[0] - lines[1]
