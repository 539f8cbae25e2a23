"""What the console does unasked is what the command line says it does."""

import dataclasses

from walking_console.server.control_lease import ControlLease
from walking_console.server.listening import is_loopback
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.serve_options import ServeOptions


def test_unasked_only_this_computer_is_let_in_and_no_token_is_needed() -> None:
    assert is_loopback(ServeOptions().host) and ServeOptions().token is None


def test_unasked_a_silent_stick_sits_down_as_by_default(loop: RealtimeLoop) -> None:
    assert ControlLease(loop)._sit_after == ServeOptions().sit_after > 0.0


def test_the_command_line_leaves_every_option_as_it_is_unasked(monkeypatch) -> None:
    from tests.server.command_line import called

    asked: list[ServeOptions] = []
    monkeypatch.setattr("walking_console.server.launch.serve", asked.append)
    for field in dataclasses.fields(ServeOptions):
        monkeypatch.delenv(f"WALKING_CONSOLE_{field.name.upper()}", raising=False)
    assert called().exit_code == 0
    assert asked == [ServeOptions()]
