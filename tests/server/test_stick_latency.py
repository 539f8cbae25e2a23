"""The stick that ``bench`` pushes, on a server of its own: what is measured, not how much it is."""

from walking_console.server import stick_latency


def test_every_push_is_timed_until_the_body_has_moved() -> None:
    waits = stick_latency.stick_to_motion(3)
    assert len(waits) == 3
    assert all(0.0 < wait < stick_latency.PATIENCE for wait in waits)


def test_a_secret_and_a_host_meant_for_another_console_are_not_this_ones(monkeypatch) -> None:
    monkeypatch.setenv("WALKING_CONSOLE_TOKEN", "of-a-console-on-the-network")
    monkeypatch.setenv("WALKING_CONSOLE_HOST", "0.0.0.0")
    assert len(stick_latency.stick_to_motion(1)) == 1


def test_the_figures_are_of_all_pushes(monkeypatch) -> None:
    waits = [0.03, *(0.001 * k for k in range(99))]
    monkeypatch.setattr(stick_latency, "stick_to_motion", lambda presses: waits)
    seen, last = stick_latency.figures().values()
    assert (seen["value"], last["value"]) == (48.5, 97.0)
