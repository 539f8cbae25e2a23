"""A pipe or a dead disk in the data folder keeps nobody waiting."""

import asyncio
import os
import threading
import time
from pathlib import Path

import pytest

from walking_console.server.disk_reads import DeadDisk, DiskReads, plain_text
from walking_console.server.limits import DISK_LOOKS_AT_ONCE


def test_a_look_answers_and_what_it_raises_is_raised() -> None:
    disk = DiskReads()
    assert asyncio.run(disk.ask(len, "abc")) == 3
    with pytest.raises(ValueError, match="invalid literal"):
        asyncio.run(disk.ask(int, "abc"))


def test_looks_that_hang_are_given_up_and_so_are_those_behind_them() -> None:
    disk = DiskReads(seconds=0.05)
    lives = threading.Event()

    async def look_again_and_again() -> float:
        begun = time.monotonic()
        for _ in range(DISK_LOOKS_AT_ONCE + 2):
            with pytest.raises(DeadDisk, match="has not answered"):
                await disk.ask(lives.wait, 20.0)
        return time.monotonic() - begun

    assert asyncio.run(look_again_and_again()) < 10.0
    lives.set()


def test_the_end_of_a_plain_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "said.txt"
    file.write_bytes(b"first\nlast \xff")
    assert plain_text(file) == "first\nlast \N{REPLACEMENT CHARACTER}"
    assert plain_text(file, most=6) == "last \N{REPLACEMENT CHARACTER}"
    assert plain_text(tmp_path / "none") == "" == plain_text(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_a_pipe_that_nobody_writes_to_says_nothing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert plain_text(tmp_path / "pipe") == ""
