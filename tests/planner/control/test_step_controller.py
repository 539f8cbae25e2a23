"""One step after the other."""

import pytest

from tests.planner.control.plans import (
    AHEAD,
    FEET,
    HEIGHT,
    Scripted,
    flat,
    now,
    state_with,
    swing_plan,
)
from walking_console.planner.config import configured
from walking_console.planner.control.activities import Activity
from walking_console.planner.control.step_controller import StepController
from walking_console.planner.types import Blocked, Command, Reason

GROUND = flat()


def walker(*answers, slices=0, config=None):
    state = state_with(Scripted(*answers, slices=slices), config)
    return state, StepController(state)


def test_from_a_standstill_it_walks_as_soon_as_the_step_is_there():
    state, steps = walker(swing_plan())
    steps.start(now(terrain=GROUND))
    assert state.steps and state.steps_begun == 1 and state.run.pace == 1.0
    assert state.crab_angle == AHEAD.crab_angle and state.posture == "stand"


def test_what_was_refused_is_not_asked_again_until_command_or_map_changes():
    refusal = Blocked(Reason.NO_DIRECTION)
    state, steps = walker(refusal)
    planner = state.job.planner
    for _ in range(3):
        steps.start(now(terrain=GROUND))
    assert state.stands and state.blocked is refusal and len(planner.asked) == 1
    steps.start(now(Command(1.0, 0.1), GROUND))
    steps.start(now(Command(1.0, 0.1), flat()))
    assert len(planner.asked) == 3


WALLED = GROUND.told((), {GROUND.cell_at(1.0, 0.0): 2.0})


@pytest.mark.parametrize(
    ("terrain", "bar"),
    [
        (GROUND, "as if something that no foot has felt were in its way"),
        (WALLED, "what no leg can be lifted over stands 1.0 m before its middle, from"),
    ],
)
def test_a_body_held_back_again_and_again_says_so_and_what_bars_its_way(terrain, bar):
    state, steps = walker(swing_plan(), config=configured({"tracking": {"held_max": 2}}))
    for _ in range(2):
        steps.count_held_back(now(terrain=terrain, body=(-0.03, 0.0, HEIGHT, 0.0, 0.0, 0.0)))
    steps.start(now(Command(0.0, 0.1), terrain))
    assert state.blocked is not None and state.blocked.reason is Reason.HELD_BACK
    said = f"the body is 30 mm behind its legs, again and again: {bar}"
    assert state.blocked.text.startswith(said)
    assert not state.job.planner.asked


def test_steps_and_encounters_that_lead_nowhere_say_what_bars_the_way():
    state, steps = walker(swing_plan())
    for too_many in (Reason.MARKING_TIME, Reason.NO_PROGRESS):
        facts = {"steps": 8, "times": 6, "bar": ""}
        state.setbacks.why = Blocked(too_many, facts=facts)
        state.setbacks.heed = lambda command: None
        steps.start(now(Command(0.0, 0.1), WALLED))
        assert state.blocked is not None and state.blocked.reason is too_many
        assert "and got no farther: what no leg can be lifted over" in state.blocked.text
        state.blocked = None


def over(state):
    """The step has come to its end as planned."""
    end = state.run.plan.end
    state.run.t = 1.0
    return now(terrain=GROUND, body=(end.body[0], 0.0, HEIGHT, 0.0, 0.0, 0.0), feet=end.feet)


def test_at_the_switch_the_next_step_begins_with_what_is_left_of_the_tick():
    state, steps = walker(swing_plan())
    steps.start(now(terrain=GROUND))
    assert steps.switch(over(state), 0.01) == 0.01
    assert state.steps and state.steps_begun == 2 and state.executed is not None


def test_a_step_that_is_not_planned_yet_is_waited_for_on_standing_feet():
    state, steps = walker(swing_plan())
    steps.start(now(terrain=GROUND))
    state.job.planner.slices = 10**6
    assert steps.switch(over(state), 0.01) == 0.0
    assert state.activity is Activity.STAND and state.job.asked is not None
    assert state.run.plan.swing == () and state.run.stance.feet == FEET
