"""Rate, pause, single ticks, lateness, and which tick was on the screen when."""

import math

import pytest

from walking_console.planner.types import TICK
from walking_console.server.pacing import (
    ADVANCE_PER_TICK,
    RATE_MAX,
    RATE_MIN,
    SHOWN_KEPT,
    Lateness,
    Pace,
    ShownTicks,
)


def test_while_it_walks_the_rate_is_due() -> None:
    pace = Pace()
    assert pace.ticks_due() == 1
    assert pace.set_rate(RATE_MAX) and not pace.set_rate(RATE_MAX)
    assert pace.ticks_due() == RATE_MAX


@pytest.mark.parametrize(("rate", "ticks"), [(0.25, 10), (0.1, 4), (1.5, 60), (3.0, 120)])
def test_below_and_between_whole_rates_the_ticks_come_out_over_time(
    rate: float, ticks: int
) -> None:
    pace = Pace()
    pace.set_rate(rate)
    due = [pace.ticks_due() for _ in range(40)]
    assert abs(sum(due) - ticks) <= 1 and max(due) - min(due) <= 1


@pytest.mark.parametrize("rate", [0.0, -1.0, RATE_MIN / 2, RATE_MAX + 1, math.nan])
def test_no_other_rate_is_taken(rate: float) -> None:
    pace = Pace()
    with pytest.raises(ValueError, match="rate must be 0.1 to 8"):
        pace.set_rate(rate)
    assert pace.rate == 1.0


def test_paused_it_owes_exactly_what_was_asked_for_and_pays_in_parts() -> None:
    pace = Pace()
    pace.paused = True
    pace.advance(ADVANCE_PER_TICK)
    pace.advance(30)
    assert pace.owed == ADVANCE_PER_TICK + 30
    assert [pace.ticks_due() for _ in range(3)] == [ADVANCE_PER_TICK, 30, 0]


def test_nothing_is_owed_after_the_walk_goes_on_or_stands_still() -> None:
    for end in (Pace.forgive, Pace.ticks_due):
        pace = Pace()
        pace.paused = True
        pace.advance(500)
        pace.ticks_due()
        pace.paused = False
        end(pace)
        assert pace.owed == 0


@pytest.mark.parametrize(
    ("late", "missed"), [(0.0, 0), (0.9 * TICK, 0), (1.1 * TICK, 1), (5.5 * TICK, 5)]
)
def test_only_whole_ticks_are_missed(late: float, missed: int) -> None:
    lateness = Lateness(0.0)
    assert lateness.note(late) == missed == lateness.skipped
    assert lateness.worst == lateness.last_second == late


def test_the_worst_of_the_last_second_is_forgotten_after_a_second_and_the_worst_never() -> None:
    lateness = Lateness(0.0)
    lateness.note(0.5)
    for _ in range(round(1 / TICK)):
        lateness.note(0.001)
    assert lateness.last_second == 0.001 and lateness.worst == 0.5


def test_a_picture_is_as_old_as_the_next_one_is_out() -> None:
    shown = ShownTicks(3, now=10.0)
    assert shown.age_of(3, now=99.0) == 0.0, "nothing newer has been shown"
    shown.note(4, now=11.0)
    shown.note(4, now=12.0)
    assert shown.age_of(3, now=12.5) == 1.5
    assert shown.age_of(5, now=12.5) is None


def test_what_is_older_than_is_remembered_is_infinitely_old() -> None:
    shown = ShownTicks(0, now=0.0)
    for tick in range(1, 2 * SHOWN_KEPT):
        shown.note(tick, now=float(tick))
    assert shown.age_of(0, now=500.0) == math.inf


def test_a_reset_begins_the_list_anew() -> None:
    shown = ShownTicks(500, now=0.0)
    shown.note(0, now=1.0)
    assert shown.age_of(0, now=9.0) == 0.0 and shown.age_of(500, now=9.0) is None
