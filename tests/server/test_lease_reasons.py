"""Every reason has its sentence."""

from string import Formatter

import pytest

from walking_console.server.lease_reasons import AGE_SAID, TEXTS, LeaseReason, refusal, stale


@pytest.mark.parametrize("reason", LeaseReason)
def test_every_reason_has_a_sentence_that_can_be_filled_in(reason: LeaseReason) -> None:
    names = [name for _, name, _, _ in Formatter().parse(TEXTS[reason]) if name]
    told = refusal(reason, **dict.fromkeys(names, 1))
    assert told.reason is reason and told.text and "{" not in told.text


def test_a_picture_that_is_older_than_anybody_knows_is_said_to_be_as_old_as_can_be() -> None:
    assert stale(7, float("inf")).text == f"stale: the picture of tick 7 is {AGE_SAID} s old"
