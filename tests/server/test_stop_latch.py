"""A stop outlives the console, whatever the disk does."""

import asyncio
import os
from pathlib import Path

import pytest

from walking_console.server.stop_latch import StopLatch


def set_and_kept(latch: StopLatch, stopped: bool) -> None:
    latch.set(stopped)
    assert asyncio.run(latch.wait(10.0))


def test_a_stop_is_found_again_until_it_is_released(tmp_path: Path) -> None:
    file = tmp_path / "data" / "stopped"
    first = StopLatch(file)
    assert not first.is_set
    set_and_kept(first, True)
    second = StopLatch(file)
    assert second.is_set
    set_and_kept(second, False)
    assert not second.is_set and not StopLatch(file).is_set


def test_the_last_of_many_is_what_is_kept(tmp_path: Path) -> None:
    latch = StopLatch(tmp_path / "stopped")
    for number in range(51):
        assert latch.set(number % 2 == 0)
    assert not latch.set(True)
    assert asyncio.run(latch.wait(10.0))
    assert StopLatch(tmp_path / "stopped").is_set


def test_without_a_file_it_stops_as_well(tmp_path: Path) -> None:
    latch = StopLatch()
    latch.set(True)
    assert latch.is_set


def test_a_disk_that_cannot_be_written_stops_and_is_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "data").write_text("no folder")
    latch = StopLatch(tmp_path / "data" / "stopped")
    latch.set(True)
    latch.set(False)
    assert not asyncio.run(latch.wait(0.5)) and not latch.is_set
    assert "a restart will not know of the stop" in caplog.text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_its_place_counts_as_a_stop_and_holds_nobody_up(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "stopped")
    latch = StopLatch(tmp_path / "stopped")
    assert latch.is_set
    set_and_kept(latch, False)
    os.mkfifo(tmp_path / "stopped")
    latch.set(True)  # nobody reads the pipe
    set_and_kept(latch, False)
    assert not StopLatch(tmp_path / "stopped").is_set
