"""Refusals are data: a reason that can be compared, with the text that is shown beside it."""

import re
from pathlib import Path

import pytest

import walking_console.planner
from walking_console.planner.types import Blocked, Reason

PLANNER = Path(walking_console.planner.__file__).parent


@pytest.mark.parametrize("reason", Reason)
def test_every_text_is_filled_in_from_its_facts(reason):
    names = re.findall(r"{(\w+)", reason.value)
    facts = {name: 1.0 if f"{{{name}:" in reason.value else "so" for name in names}
    text = Blocked(reason, facts=facts).text
    assert text and "{" not in text


@pytest.mark.parametrize("reason", Reason)
def test_every_reason_is_given_somewhere(reason):
    sources = "".join(path.read_text("utf-8") for path in PLANNER.rglob("*.py"))
    assert f"Reason.{reason.name}" in sources


def test_the_same_refusal_is_equal_and_another_leg_is_not():
    one = Blocked(Reason.NO_PLACE, 2)
    assert one == Blocked(Reason.NO_PLACE, 2) and one != Blocked(Reason.NO_PLACE, 1)


def test_a_planner_of_ones_own_says_its_own_reason():
    refusal = Blocked.saying("it does not want to", 3)
    assert refusal.reason is Reason.OF_ITS_OWN and refusal.leg == 3
    assert refusal.text == "it does not want to"


def test_a_missing_fact_is_an_error_and_not_a_half_sentence():
    with pytest.raises(KeyError, match="needs"):
        assert Blocked(Reason.TORSO_TOUCHES).text
