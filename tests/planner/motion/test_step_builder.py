"""Step plans from knots: the tables of every way to give them."""

import re
from pathlib import Path

import numpy as np
import pytest

from walking_console.planner.motion.step_builder import (
    FootWay,
    body_still_plan,
    changed,
    holding_plan,
    plan_from_knots,
    plan_of_one_foot,
    plan_on_all_feet,
    with_feet,
)
from walking_console.planner.motion.swing import EASED, EVEN
from walking_console.planner.types import TICK, Phase, Stance

FEET = ((0.5, 0.4, 0.0), (-0.5, 0.4, 0.1), (-0.5, -0.4, 0.0), (0.5, -0.4, 0.0))
BODY = (0.0, 0.0, 0.7, 0.2)
STANCE = Stance(BODY, FEET, last_swing=3)
AHEAD = (0.1, 0.0, 0.7, 0.2)
PHASES = (Phase.UP, Phase.RETURN, Phase.DOWN)
TOP, OVER, LANDING = (-0.5, 0.4, 0.3), (-0.3, 0.4, 0.3), (-0.3, 0.4, 0.05)


def test_only_the_step_builder_calls_the_constructor() -> None:
    planner = Path(__file__).parents[3] / "planner"
    calls = [
        path.name
        for path in planner.rglob("*.py")
        if re.search(r"\bStepPlan\(", path.read_text(encoding="utf-8"))
    ]
    assert calls == ["step_builder.py"]


def test_a_plan_from_knots_has_their_tables_and_nobody_may_write_into_them() -> None:
    plan = plan_from_knots(
        (1,), (0.0, 1.0), (BODY, AHEAD), (FEET, FEET), (Phase.RETURN,), STANCE, margin_min=0.1
    )
    assert plan.times.shape == (2,)
    assert plan.body.tolist() == [list(BODY), list(AHEAD)]
    assert plan.feet.shape == (2, 4, 3)
    assert plan.margin_min == 0.1
    for table in (plan.times, plan.body, plan.feet):
        with pytest.raises(ValueError, match="read-only"):
            table[0] = 1.0


def test_whole_numbers_become_floats() -> None:
    plan = holding_plan(Stance((0, 0, 1, 0), ((1, 1, 0),) * 4))
    assert plan.body.dtype == plan.feet.dtype == np.float64


def test_in_a_plan_of_one_foot_all_others_stay() -> None:
    knots = [(0.0, *BODY, *FEET[1]), (0.5, *AHEAD, *TOP)]
    plan = plan_of_one_foot(STANCE, 1, knots, [Phase.UP], STANCE)
    assert plan.swing == (1,)
    assert plan.feet[:, 1].tolist() == [list(FEET[1]), list(TOP)]
    for leg in (0, 2, 3):
        assert (plan.feet[:, leg] == FEET[leg]).all()
    assert plan.body[1].tolist() == list(AHEAD)


def test_in_a_body_still_plan_the_body_stays_and_the_foot_ends_at_its_landing_point() -> None:
    corners = [FEET[1], TOP, OVER, LANDING]
    plan = body_still_plan(STANCE, {1: FootWay(corners, LANDING)}, (0.4, 0.5, 0.6), PHASES, EVEN)
    assert plan.times.tolist() == pytest.approx([0.0, 0.4, 0.9, 1.5])
    assert plan.phases == PHASES
    assert (plan.body == BODY).all()
    assert plan.feet[:, 1].tolist() == [list(corner) for corner in corners]
    assert plan.landing == plan.end.feet[1] == LANDING


def test_in_a_body_still_plan_every_stretch_has_the_speeds_of_the_profile() -> None:
    ways = {1: FootWay([FEET[1], TOP, OVER, LANDING], LANDING)}
    plan = body_still_plan(STANCE, ways, (0.4, 0.5, 0.6), PHASES, EASED)
    assert plan.phases == tuple(phase for phase in PHASES for _ in EASED)
    shares = (plan.feet[1:6, 1, 2] - FEET[1][2]) / (TOP[2] - FEET[1][2])
    assert shares.tolist() == pytest.approx([share for _, share in EASED])
    assert plan.times[1:6].tolist() == pytest.approx([0.4 * tau for tau, _ in EASED])


def test_feet_that_swing_together_reach_their_corners_at_the_same_time() -> None:
    here = FEET[2]
    other = [here, (*here[:2], 0.2), (-0.4, -0.4, 0.2), (-0.4, -0.4, 0.0)]
    ways = {
        1: FootWay([FEET[1], TOP, OVER, LANDING], LANDING),
        2: FootWay(other, other[3]),
    }
    plan = body_still_plan(STANCE, ways, (0.4, 0.5, 0.6), PHASES, EVEN)
    assert plan.swing == (1, 2)
    assert plan.feet[2, [1, 2]].tolist() == [list(OVER), list(other[2])]
    assert plan.end.feet == (FEET[0], LANDING, other[3], FEET[3])


def test_a_stretch_of_no_time_is_left_out() -> None:
    corners = [FEET[1], FEET[1], OVER, LANDING]
    plan = body_still_plan(STANCE, {1: FootWay(corners, LANDING)}, (0.0, 0.5, 0.6), PHASES, EVEN)
    assert plan.phases == (Phase.RETURN, Phase.DOWN)
    assert plan.times.tolist() == pytest.approx([0.0, 0.5, 1.1])


def test_where_no_stretch_is_left_the_plan_is_one_tick_of_staying() -> None:
    plan = body_still_plan(STANCE, {1: FootWay([FEET[1]] * 4, FEET[1])}, (0.0,) * 3, PHASES, EASED)
    assert plan.times.tolist() == [0.0, TICK]
    assert (plan.feet == np.array(FEET)).all()


def test_on_all_feet_only_the_body_moves_and_legs_in_the_air_stay_there() -> None:
    plan = plan_on_all_feet(
        Stance(BODY, FEET, lifted=(2,)), (0.0, 1.0), (BODY, AHEAD), STANCE, support_shift=0.1
    )
    assert plan.swing == (2,)
    assert plan.phases == (Phase.SHIFT,)
    assert (plan.feet == np.array(FEET)).all()
    assert plan.support_shift == 0.1


def test_a_holding_plan_stays_for_one_tick() -> None:
    plan = holding_plan(STANCE)
    assert plan.times.tolist() == [0.0, TICK]
    assert (plan.body == BODY).all()
    assert plan.end == STANCE


def test_a_changed_copy_keeps_what_is_not_named() -> None:
    plan = holding_plan(STANCE, crab_angle=0.3)
    end = Stance(AHEAD, FEET)
    copy = changed(plan, end=end, margin_min=0.2)
    assert (copy.end, copy.margin_min, copy.crab_angle) == (end, 0.2, 0.3)
    assert copy.body is plan.body
    assert plan.end == STANCE


def test_with_feet_moves_the_feet_that_are_named() -> None:
    assert with_feet(FEET, {1: LANDING}) == (FEET[0], LANDING, FEET[2], FEET[3])
