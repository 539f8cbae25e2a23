"""Tokens: what each is good for, and what becomes of an address that guesses."""

from tests.server.stopwatch import Watch
from walking_console.server.limits import ADDRESSES_KEPT, GUESSES_MAX, GUESSES_WITHIN
from walking_console.server.tokens import Guesses, Role, Tokens

DRIVER, VIEWER = "d" * 40, "v" * 40
HERE, THERE = "192.0.2.7", "192.0.2.8"


def test_each_token_is_good_for_its_own_and_any_other_for_nothing() -> None:
    tokens = Tokens(DRIVER, VIEWER)
    assert tokens.role_of(DRIVER) is Role.DRIVER and tokens.role_of(VIEWER) is Role.VIEWER
    for wrong in ("", "d" * 39, "d" * 41, "ü", "\ud800"):
        assert tokens.role_of(wrong) is None
    assert Tokens(DRIVER).role_of("") is None and Tokens().role_of("") is None


def test_who_guesses_too_often_waits_and_nobody_else(watch: Watch) -> None:
    guesses = Guesses(watch)
    for _ in range(GUESSES_MAX):
        assert guesses.wait(HERE) == 0.0
        guesses.note(HERE, None)
    assert guesses.wait(HERE) == GUESSES_WITHIN and guesses.wait(THERE) == 0.0
    watch.wait(GUESSES_WITHIN - 1.0)
    assert 0.0 < guesses.wait(HERE) <= 1.0
    watch.wait(1.5)
    assert guesses.wait(HERE) == 0.0


def test_wrong_tokens_now_and_then_lock_nobody_out(watch: Watch) -> None:
    guesses = Guesses(watch)
    for _ in range(5 * GUESSES_MAX):
        guesses.note(HERE, None)
        watch.wait(2.0 * GUESSES_WITHIN / GUESSES_MAX)
        assert guesses.wait(HERE) == 0.0


def test_an_address_that_has_shown_a_right_one_is_never_locked_out(watch: Watch) -> None:
    guesses = Guesses(watch)
    guesses.note(HERE, Role.DRIVER)
    for _ in range(3 * GUESSES_MAX):
        guesses.note(HERE, None)
    assert guesses.wait(HERE) == 0.0


def test_only_so_many_addresses_are_remembered(watch: Watch) -> None:
    guesses = Guesses(watch)
    for number in range(3 * ADDRESSES_KEPT):
        guesses.note(f"address {number}", None)
        guesses.note(f"friend {number}", Role.VIEWER)
    assert len(guesses._wrong) == len(guesses._known) == ADDRESSES_KEPT
