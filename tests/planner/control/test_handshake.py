"""F1, F2 and F3 of H §9.3, and their six transitions."""

import pytest

from walking_console.planner.control.handshake import (
    ASKED,
    IDLE,
    READY,
    WANTED,
    FlagChange,
    Handshake,
)


def bits(*changes):
    return sum(1 << change for change in changes)


def test_in_normal_motion_the_step_is_called_for_completed_notified_wanted_and_received():
    shake = Handshake()
    assert shake.flags == IDLE
    shake.call()
    assert shake.flags == ASKED and shake.changes == bits(FlagChange.CALLED)
    shake.begin_tick()
    shake.complete()
    assert shake.flags == READY
    assert shake.changes == bits(FlagChange.COMPLETED, FlagChange.NOTIFIED)
    shake.begin_tick()
    shake.receive()
    assert shake.flags == IDLE
    assert shake.changes == bits(FlagChange.WANTED, FlagChange.TAKEN, FlagChange.SUPPLIED)


def test_level_c_that_waits_shows_f1_and_f3_and_is_supplied_when_level_b_is_done():
    shake = Handshake()
    shake.call()
    shake.want()
    assert shake.flags == WANTED
    shake.complete()
    assert shake.flags == (False, True, True)
    shake.receive()
    assert shake.flags == IDLE
    assert shake.changes == bits(*FlagChange)


def test_what_was_ready_for_another_question_is_taken_back():
    shake = Handshake()
    shake.call()
    shake.complete()
    shake.call()
    assert shake.flags == ASKED


def test_a_flag_that_is_as_it_should_be_does_not_change():
    shake = Handshake()
    shake.call()
    shake.begin_tick()
    shake.call()
    assert shake.changes == 0
    shake.dismiss()
    assert shake.flags == IDLE and shake.changes == bits(FlagChange.COMPLETED)


def test_what_was_not_notified_cannot_be_received():
    shake = Handshake()
    shake.call()
    with pytest.raises(RuntimeError, match="F2 is not set"):
        shake.receive()
