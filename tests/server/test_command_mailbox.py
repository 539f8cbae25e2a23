"""The newest command wins, lapses once, and the machine sits down once."""

import math

from walking_console.planner.types import Command
from walking_console.server.command_mailbox import CommandMailbox, SitDownTimer

AHEAD, ASIDE = Command(0.0, 0.08, 0.0), Command(1.0, 0.05, 0.0)


def test_the_newest_command_is_taken_and_only_once() -> None:
    box = CommandMailbox()
    assert box.take() is None
    box.put(AHEAD, 0.5, now=10.0)
    box.put(ASIDE, 0.5, now=10.1)
    taken = box.take()
    assert taken is not None and taken.command == ASIDE and taken.deadline == 10.6
    assert box.take() is None


def test_the_same_command_put_again_is_another_one() -> None:
    box = CommandMailbox()
    box.put(AHEAD, 0.5, now=1.0)
    first = box.take()
    box.put(AHEAD, 0.5, now=1.0)
    assert box.take() == first


def test_a_command_lapses_once_and_only_after_its_deadline() -> None:
    box = CommandMailbox()
    box.put(AHEAD, 0.5, now=1.0)
    assert not box.lapses(9.0), "nobody has taken it"
    box.take()
    assert not box.lapses(1.5)
    assert box.lapses(1.51) and not box.lapses(2.0)


def test_a_command_without_end_never_lapses() -> None:
    box = CommandMailbox()
    box.put(AHEAD, math.inf, now=1.0)
    box.take()
    assert not box.lapses(1e9)


def test_the_timer_falls_due_once_for_every_time_that_is_set() -> None:
    timer = SitDownTimer()
    assert not timer.falls_due(1e9)
    for _ in range(2):
        timer.set(5.0)
        assert not timer.falls_due(5.0)
        assert timer.falls_due(5.1) and not timer.falls_due(6.0)


def test_a_later_time_replaces_an_earlier_one() -> None:
    timer = SitDownTimer()
    timer.set(5.0)
    timer.set(math.inf)
    assert not timer.falls_due(100.0)
