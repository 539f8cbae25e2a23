"""The swing: its speed profiles, its corners, and what it clears."""

import numpy as np
import pytest

from walking_console.planner.motion.swing import (
    CLEARANCE,
    EASED,
    EVEN,
    aim_of,
    carry_height,
    lift,
    peak,
    profile_of,
    stairs,
    swing_speeds,
    waiting_place,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Gait

TITAN = load_machine("titan3")
HEXAPOD = load_machine("hexapod")
GAIT = Gait(0.8, 0.1, 0.2, 0.85)


def rates(profile) -> np.ndarray:
    taus, ways = np.array([(0.0, 0.0), *profile]).T
    return np.diff(ways) / np.diff(taus)


def ground(height: float) -> TerrainMap:
    """Level ground with one ridge across x = 0."""
    heights = np.zeros((40, 40))
    heights[:, 19:21] = height
    return TerrainMap(heights, np.zeros(heights.shape, bool), 0.05, (-1.0, -1.0), 0.02)


def test_the_eased_profile_speeds_up_and_slows_down_in_stairs_to_a_peak_of_1_25() -> None:
    speeds = rates(EASED)
    assert EASED[-1] == (1.0, 1.0)
    assert speeds.max() == pytest.approx(1.25)
    assert list(speeds[:3]) == sorted(speeds[:3])
    assert list(speeds[2:]) == sorted(speeds[2:], reverse=True)


def test_the_peak_of_a_profile_is_its_largest_speed_over_its_mean() -> None:
    assert peak(EASED) == 1.25
    assert peak(EVEN) == 1.0
    assert peak(((0.5, 0.25), (1.0, 1.0))) == 1.5


def test_a_gait_that_is_not_smooth_runs_at_even_speed() -> None:
    assert profile_of(GAIT) == EASED
    assert profile_of(Gait(0.8, 0.1, 0.2, 0.85, smooth=False)) == EVEN


def test_swing_speeds_leave_room_for_the_peak() -> None:
    assert swing_speeds(TITAN, GAIT) == pytest.approx([v / 1.25 for v in TITAN.speed])
    assert swing_speeds(TITAN, GAIT, 0.5) == pytest.approx([v / 2.5 for v in TITAN.speed])


@pytest.mark.parametrize("profile", [EVEN, EASED])
@pytest.mark.parametrize("pieces", [1, 3, 8])
def test_stairs_are_cut_into_at_least_so_many_pieces_of_the_same_speeds(profile, pieces) -> None:
    cut = list(stairs(profile, pieces))
    assert len(cut) >= pieces
    assert cut[-1] == (1.0, 1.0)
    shares, ways = np.array([(0.0, 0.0), *profile]).T
    for tau, eased in cut:
        assert eased == pytest.approx(np.interp(tau, shares, ways))


def test_a_lift_goes_straight_up_over_and_straight_down_past_the_ground() -> None:
    stand, top, over, aim = lift((0.5, 0.4, 0.0), (0.8, 0.4, 0.05), 0.05, 1.0, 0.85, TITAN, GAIT)
    assert top[:2] == stand[:2]
    assert over[:2] == aim[:2] == (0.8, 0.4)
    assert top[2] == pytest.approx(0.1)
    assert over[2] == pytest.approx(0.15)
    assert aim[2] == pytest.approx(0.05 + GAIT.lift_up - GAIT.lift_down)


def test_a_lift_clears_the_crest_but_is_cut_at_the_ceiling() -> None:
    corners = lift((0.5, 0.4, 0.0), (0.8, 0.4, 0.0), 0.3, 1.0, 0.85, TITAN, GAIT)
    assert corners.top[2] == corners.over[2] == pytest.approx(0.3 + CLEARANCE)
    cut = lift((0.5, 0.4, 0.0), (0.8, 0.4, 0.0), 0.3, 0.2, 0.85, TITAN, GAIT)
    assert cut.top[2] == cut.over[2] == 0.2


def test_an_aim_ends_where_the_leg_reaches_no_lower() -> None:
    landing = (0.6, 0.5, 0.0)
    assert aim_of(landing, 0.85, 0, TITAN, GAIT)[2] == pytest.approx(-GAIT.lift_up)
    high = TITAN.overreach[2] - TITAN.legs[0].z[0] - 0.04
    assert aim_of(landing, high, 0, TITAN, GAIT)[2] == pytest.approx(-0.04)


def test_a_carried_foot_clears_the_highest_ground_on_its_way() -> None:
    start, end = (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)
    assert carry_height(start, end, ground(0.0), GAIT) == pytest.approx(GAIT.lift_up)
    assert carry_height(start, end, ground(0.3), GAIT) == pytest.approx(0.3 + CLEARANCE)


def test_a_lifted_leg_waits_over_the_middle_of_its_rectangle_drawn_up_where_ground_may_rise() -> (
    None
):
    level = waiting_place(HEXAPOD, 2, GAIT, ground(0.0))
    assert level[:2] == HEXAPOD.legs[2].centre
    drawn_up = HEXAPOD.legs[2].z[1] + HEXAPOD.overreach[2]
    assert level[2] == pytest.approx(min(-GAIT.height + GAIT.lift_up, drawn_up))
    assert waiting_place(HEXAPOD, 2, GAIT, ground(0.3))[2] == pytest.approx(drawn_up)
