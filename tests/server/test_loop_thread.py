"""A thread with a loop in it begins once and ends when it is told to."""

import threading

from walking_console.server.loop_thread import LoopThread


def test_it_runs_until_it_is_stopped() -> None:
    begun = threading.Event()

    def run(stopping: threading.Event) -> None:
        begun.set()
        stopping.wait(10.0)

    thread = LoopThread("here", run)
    assert not thread.running
    thread.start()
    assert begun.wait(5.0) and thread.running
    thread.stop()
    assert not thread.running


def test_stopping_what_never_began_is_harmless() -> None:
    thread = LoopThread("never", lambda stopping: None)
    thread.stop()
    assert not thread.running


def test_it_does_not_keep_the_program_alive() -> None:
    daemons: list[bool] = []
    thread = LoopThread("d", lambda stopping: daemons.append(threading.current_thread().daemon))
    thread.start()
    thread.stop()
    assert daemons == [True]
