"""The words all rooms share: frozen, and what they say of themselves."""

import dataclasses

import numpy as np
import pytest

from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.types import Blocked, Command, Stance

FEET = ((0.5, 0.4, 0.0), (-0.5, 0.4, 0.0), (-0.5, -0.4, 0.0), (0.5, -0.4, 0.0))
STANCE = Stance((0.0, 0.0, 0.85, 0.0), FEET)


@pytest.mark.parametrize(
    ("command", "holds"),
    [
        (Command(), True),
        (Command(crab_angle=1.0), True),
        (Command(speed=0.1), False),
        (Command(turn_rate=-0.1), False),
    ],
)
def test_a_command_holds_when_it_neither_travels_nor_turns(command, holds):
    assert command.holds is holds


@pytest.mark.parametrize("word", [Command(), STANCE, Blocked("why"), holding_plan(STANCE)])
def test_a_word_cannot_be_changed(word):
    field = dataclasses.fields(word)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(word, field, None)


def test_the_tables_of_a_plan_are_write_protected():
    plan = holding_plan(STANCE)
    for table in (plan.times, plan.body, plan.feet):
        assert isinstance(table, np.ndarray)
        with pytest.raises(ValueError, match="read-only"):
            table[0] = 1.0
