"""A leaning body: the sheared frame, the way back, and Level C that turns the body to the lean of
the plan.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner.config import Gains
from walking_console.planner.control.foot_controller import (
    ReflexState,
    reflex,
)
from walking_console.planner.control.tracking import TrajectoryTracker
from walking_console.planner.geometry.transforms import attitude_of, rotation
from walking_console.planner.motion.body_tilt import (
    LEAN_STEP,
    LEVEL,
    FrameCache,
    approached,
    leaned,
    leaning,
    reaches,
    sheared,
    unleaned,
)
from walking_console.planner.motion.foot_placement import place_foot
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import TICK, Gait, Phase, Sensing, Stance, StepPlan

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)
LEAN = (0.12, -0.05)
FEET = ((0.5, 0.5, 0.02), (-0.4, 0.45, -0.05), (-0.45, -0.5, 0.0), (0.4, -0.45, 0.04))
STANCE = Stance((0.0, 0.0, 0.85, 0.3), FEET, lean=LEAN)


def inclined(gx: float, gy: float, span: float = 16.0, cell: float = 0.05) -> TerrainMap:
    n = round(span / cell)
    at = (np.arange(n) + 0.5) * cell - span / 2
    heights = gx * at[None, :] + gy * at[:, None]
    return TerrainMap(heights, np.zeros((n, n), dtype=bool), cell, (-span / 2, -span / 2))


def seen(stance: Stance, roll: float, pitch: float, tick: int = 0) -> Sensing:
    """What the monitors say of a machine that stands like this."""
    x, y, z, yaw = stance.body
    r = np.array(rotation(roll, pitch, yaw)).reshape(3, 3)
    feet = tuple(tuple(r.T @ (np.array(foot) - (x, y, z))) for foot in stance.feet)
    none = (0,) * 4
    return Sensing(tick, (x, y, z, roll, pitch, yaw), feet, (True,) * 4, none, (False,) * 4)


@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.5, -1.2])
def test_roll_and_pitch_are_those_of_a_floor_with_that_gradient(yaw: float) -> None:
    up = np.array(rotation(*attitude_of(LEAN, yaw), yaw)).reshape(3, 3)[:, 2]
    assert up[0] / up[2] == pytest.approx(-LEAN[0]) and up[1] / up[2] == pytest.approx(-LEAN[1])


def test_a_foots_height_in_body_axes_is_its_sheared_height_times_the_cosine_everywhere() -> None:
    roll, pitch = attitude_of(LEAN, STANCE.body[3])
    flat = unleaned(STANCE)
    for foot_b, foot in zip(seen(STANCE, roll, pitch).feet_b, flat.feet, strict=True):
        assert foot_b[2] == pytest.approx(
            (foot[2] - flat.body[2]) * math.cos(roll) * math.cos(pitch)
        )


def test_ground_with_the_gradient_of_the_lean_is_level_in_its_frame() -> None:
    flat = sheared(inclined(*LEAN), LEAN, (1.0, 0.0))
    assert np.ptp(flat.heights) < 1e-12 and flat.rows == 200
    assert flat.height_at(1.0, 0.0) == pytest.approx(inclined(*LEAN).height_at(1.0, 0.0), abs=0.01)


def test_the_window_keeps_what_is_forbidden_and_known_in_its_place() -> None:
    terrain = inclined(0.1, 0.0)
    terrain = replace(
        terrain.forbid([(200, 250)]), known=np.indices(terrain.heights.shape)[1] > 160
    )
    x, y = terrain.centre(200, 250)
    window = sheared(terrain, (0.1, 0.0), (3.0, 2.0))
    assert not window.allows(x, y) and window.allows(x + 0.05, y)
    assert window.known is not None and window.known.mean() == pytest.approx(
        terrain.known[:, 100:].mean(), abs=0.2
    )  # type: ignore[index]


@pytest.mark.parametrize("lean", [(0.1, 0.0), (-0.08, 0.12), (0.0, -0.15)])
def test_every_point_of_what_a_leaning_leg_reaches_is_in_its_box(lean: tuple[float, float]) -> None:
    roll, pitch = attitude_of(lean, 0.0)
    r = np.array(rotation(roll, pitch, 0.0)).reshape(3, 3)
    cosine, boxes = reaches(TITAN, [lean], *TITAN.z_range)
    for spec, (x1, x2, y1, y2) in zip(TITAN.legs, boxes, strict=True):
        for x in (x1, x2):
            for y in (y1, y2):
                for z in TITAN.z_range:
                    bx, by, bz = r.T @ (x, y, z / cosine + lean[0] * x + lean[1] * y)
                    assert (
                        spec.x[0] - 1e-9 <= bx <= spec.x[1] + 1e-9
                        and spec.y[0] - 1e-9 <= by <= spec.y[1] + 1e-9
                    )
                    assert bz == pytest.approx(z)


def test_a_plan_comes_back_from_the_frame_with_standing_feet_untouched() -> None:
    frame = leaning(STANCE, inclined(0.1, 0.0), TITAN)
    lifted = replace(frame.stance, feet=(*frame.stance.feet[:3], (0.4, -0.45, 0.2)))
    before = replace(
        STANCE, feet=(*STANCE.feet[:3], (0.4, -0.45, 0.2 + LEAN[0] * 0.4 + LEAN[1] * -0.45))
    )
    plan = place_foot(lifted, 3, frame.terrain, frame.machine, GAIT)
    assert isinstance(plan, StepPlan)
    back = frame.restored(plan, before)
    assert back.end.lean == back.lean == LEAN and back.end.feet[:3] == STANCE.feet[:3]
    assert np.array_equal(
        back.feet[:, :3], np.broadcast_to(np.array(FEET[:3]), back.feet[:, :3].shape)
    )
    assert back.end.feet[3][2] == inclined(0.1, 0.0).height_at(*back.end.feet[3][:2])
    assert np.allclose(back.body[:, 2], 0.85)


def test_a_level_frame_hands_everything_on_as_it_is() -> None:
    stance, terrain = replace(STANCE, lean=LEVEL), inclined(0.1, 0.0)
    frame = FrameCache().frame(stance, terrain, TITAN, LEVEL)
    assert (
        frame.stance is stance
        and frame.terrain is terrain
        and leaning(stance, terrain, TITAN).machine is TITAN
    )


def test_a_lean_changes_by_one_step_at_a_time_and_arrives_exactly() -> None:
    lean, steps = LEVEL, 0
    while lean != LEAN:
        after = approached(lean, LEAN)
        assert math.dist(lean, after) <= LEAN_STEP + 1e-12
        lean, steps = after, steps + 1
    assert steps == math.ceil(math.hypot(*LEAN) / LEAN_STEP)


def test_it_does_not_lean_over_beyond_what_its_legs_reach() -> None:
    assert leaned(STANCE, LEVEL, TITAN) is not None
    assert leaned(STANCE, (0.6, 0.0), TITAN) is None


# Level C


def rocking() -> StepPlan:
    """The body goes and leans over while leg 0 swings."""
    end = (0.1, 0.02, 0.87, 0.3)
    feet = np.array([FEET, ((0.6, 0.52, 0.1), *FEET[1:])])
    body = np.array([STANCE.body, end])
    after = Stance(end, ((0.6, 0.52, 0.1), *FEET[1:]), lean=(0.14, -0.02))
    return StepPlan((0,), np.array([0.0, 1.0]), body, feet, (Phase.RETURN,), after, lean=LEAN)


def test_every_foot_is_brought_to_where_the_plan_has_it_exactly() -> None:
    playback = TrajectoryTracker(rocking())
    sensing = seen(STANCE, *attitude_of(LEAN, 0.3))
    velocities, _ = reflex(playback, TICK, sensing, ReflexState.begin(4), Gains())
    body, lean = playback.body_at(TICK), playback.lean_at(TICK)
    r = np.array(rotation(*attitude_of(lean, body[3]), body[3])).reshape(3, 3)
    for leg in range(4):
        wanted = r.T @ (np.array(playback.foot_at(leg, TICK)) - body[:3])
        assert np.allclose(
            np.array(sensing.feet_b[leg]) + np.array(velocities[leg]) * TICK, wanted, atol=1e-12
        )


def test_a_body_that_leans_otherwise_is_turned_back_by_its_share() -> None:
    plan = StepPlan(
        (),
        np.array([0.0, 1.0]),
        np.array([STANCE.body] * 2),
        np.array([FEET] * 2),
        (Phase.SHIFT,),
        STANCE,
    )
    roll, pitch = attitude_of(LEAN, 0.3)
    gains, sensing = Gains(), seen(STANCE, roll + 0.01, pitch)
    velocities, _ = reflex(TrajectoryTracker(plan), TICK, sensing, ReflexState.begin(4), gains)
    r = np.array(rotation(roll + 0.01 * (1.0 - gains.posture), pitch, 0.3)).reshape(3, 3)
    reached = [
        np.array(foot) + np.array(v) * TICK
        for foot, v in zip(sensing.feet_b, velocities, strict=True)
    ]
    at = np.array([r @ foot for foot in reached])
    # the feet stand; only the body has turned
    assert np.allclose(at - at[0], np.array(FEET) - np.array(FEET[0]), atol=1e-12)


def test_a_leg_that_carries_nothing_reaches_for_the_ground() -> None:
    plan = StepPlan(
        (),
        np.array([0.0, 1.0]),
        np.array([STANCE.body] * 2),
        np.array([FEET] * 2),
        (Phase.SHIFT,),
        STANCE,
    )
    sensing = seen(STANCE, *attitude_of(LEAN, 0.3))._replace(soles=(True, True, False, True))
    velocities, _ = reflex(TrajectoryTracker(plan), TICK, sensing, ReflexState.begin(4), Gains())
    assert (
        velocities[2][2] == pytest.approx(-Gains().pliancy / TICK) and abs(velocities[0][2]) < 1e-9
    )
