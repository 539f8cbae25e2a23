"""Writes come to the disk in their order, and one that fails keeps none from following."""

import threading

import pytest

from walking_console.server.disk_thread import DiskThread


def test_writes_are_done_in_their_order() -> None:
    disk = DiskThread()
    done: list[int] = []
    events = [disk.write(lambda n=n: done.append(n), "") for n in range(20)]  # type: ignore[misc]
    assert events[-1].wait(10.0) and done == list(range(20))


def test_a_write_that_fails_is_said_and_the_next_is_done(caplog: pytest.LogCaptureFixture) -> None:
    def fails() -> None:
        raise OSError("dead")

    disk = DiskThread()
    failed = disk.write(fails, "not kept")
    assert disk.write(lambda: None, "").wait(10.0)
    assert not failed.is_set() and "not kept: dead" in caplog.text


def test_nobody_waits_for_a_write_that_hangs() -> None:
    disk = DiskThread()
    lives = threading.Event()
    hanging = disk.write(lambda: lives.wait(10.0) and None, "")
    behind = disk.write(lambda: None, "")
    assert not hanging.is_set() and not behind.is_set()
    lives.set()
    assert behind.wait(10.0)
