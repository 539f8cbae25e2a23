"""No client fills a disk with our log."""

import io
import logging

from tests.server.stopwatch import Watch
from walking_console.server.bounded_log import BoundedHandler, LogBudget, is_of_others
from walking_console.server.limits import LOG_LETTERS, LOG_WINDOW


def record(text: str, name: str = "walking_console.server") -> logging.LogRecord:
    return logging.LogRecord(name, logging.WARNING, "", 0, text, (), None)


def test_a_minute_of_the_log_is_bounded_whatever_happens(watch: Watch) -> None:
    said = io.StringIO()
    handler = BoundedHandler(said, LogBudget(watch))
    for _ in range(20_000):
        handler.emit(record("socket.accept() out of system resource" * 10))
        watch.wait(LOG_WINDOW / 25_000)
    assert 0.9 * LOG_LETTERS < len(said.getvalue()) <= LOG_LETTERS < 1_000_000


def test_what_was_left_unsaid_is_counted_when_it_may_speak_again(watch: Watch) -> None:
    said = io.StringIO()
    handler = BoundedHandler(said, LogBudget(watch))
    long = "a" * (LOG_LETTERS - 1)
    for text in (long, "unsaid", "unsaid too"):
        handler.emit(record(text))
    watch.wait(LOG_WINDOW)
    handler.emit(record("heard again"))
    assert said.getvalue().splitlines()[1:] == [
        "2 more lines of the last 60 s are left unsaid",
        "heard again",
    ]


def test_handlers_of_one_console_share_what_may_be_said(watch: Watch) -> None:
    said, budget = io.StringIO(), LogBudget(watch)
    BoundedHandler(said, budget).emit(record("a" * (LOG_LETTERS - 1)))
    BoundedHandler(said, budget).emit(record("b"))
    assert "b" not in said.getvalue()


def test_our_own_words_are_told_from_those_of_libraries() -> None:
    assert is_of_others(record("x", "asyncio")) and is_of_others(record("x", "uvicorn.error"))
    assert not is_of_others(record("x", "walking_console.sim")) and not is_of_others(record("x"))
