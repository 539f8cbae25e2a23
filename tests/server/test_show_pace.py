"""A page whose pictures come late is shown fewer, and more again as they come in time."""

import pytest

from walking_console.server.show_pace import SHOW_RATE, SLOWEST, ShowPace


def shown(pace: ShowPace, way: float, seconds: float, began: float) -> float:
    """Let a page say every 40 ms how old its picture is, which took ``way`` s; the time then."""
    now = began
    while now < began + seconds:
        now += 0.04
        pace.note(way + 1.0 / pace.rate, now)
    return now


def test_pictures_that_come_late_become_fewer_down_to_the_slowest() -> None:
    pace = ShowPace(0.0)
    assert not pace.is_thinned
    shown(pace, 0.3, 0.5, 0.0)
    assert SLOWEST < pace.rate < SHOW_RATE and pace.is_thinned
    shown(pace, 0.3, 10.0, 1.0)
    assert pace.rate == SLOWEST


def test_pictures_that_come_in_time_become_more_up_to_all() -> None:
    pace = ShowPace(0.0)
    now = shown(pace, 0.3, 10.0, 0.0)
    shown(pace, 0.02, 10.0, now)
    assert pace.rate == SHOW_RATE and not pace.is_thinned


@pytest.mark.parametrize("way", [0.06, 0.11])
def test_between_the_two_nothing_changes(way: float) -> None:
    pace = ShowPace(0.0)
    now = shown(pace, 0.3, 1.0, 0.0)
    before = pace.rate
    shown(pace, way, 5.0, now)
    assert pace.rate == before


def test_its_own_pauses_do_not_make_a_picture_late() -> None:
    pace = ShowPace(0.0)
    now = shown(pace, 0.3, 10.0, 0.0)
    pace.note(0.9 / pace.rate, now + 1.0)
    assert pace.rate > SLOWEST


def test_a_picture_nobody_has_shown_says_nothing() -> None:
    pace = ShowPace(0.0)
    pace.note(None, 5.0)
    assert pace.rate == SHOW_RATE
