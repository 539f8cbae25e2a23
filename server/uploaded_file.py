"""What a file that somebody brought is: a ground, a robot, or a recorded hand.

Files of strangers are read by a child process (``read_by_child``) that may take so much memory and
time and no more; what it answers is plain data.
"""

from __future__ import annotations

import json
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from subprocess import PIPE, TimeoutExpired
from typing import Any

from walking_console.planner.robot.model import MachineError, load_machine
from walking_console.planner.robot.toml_files import names_toml_file
from walking_console.sim.drive_files import DriveFileError, read_drive
from walking_console.sim.terrain.files import read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError
from walking_console.sim.terrain.readers import READERS

from .child_process import start_child

PART = ".part-"  # what a file is called until it has been read
COMMAND = "understand"  # the hidden one of the command line that a child runs
MEMORY_MAX = 4_000_000_000  # bytes a child may map; a picture of 6000 x 6000 takes a quarter
SECONDS_MAX = 60  # of processor time, and a bit more on the clock

ReadUpload = Callable[[Path, str], dict[str, Any]]


class Unreadable(ValueError):
    """A file that is nothing of ours, with every fault of it."""

    def __init__(self, reason: str, faults: tuple[str, ...] = ()) -> None:
        super().__init__(reason)
        self.faults = faults or (reason,)


def read_by_child(path: Path, name: str) -> dict[str, Any]:
    """As ``understood``, by a child with limits of its own."""
    with tempfile.TemporaryDirectory() as folder:
        child = start_child([COMMAND, str(path.absolute()), name], Path(folder), output=PIPE)
        try:
            said, _ = child.communicate(timeout=2 * SECONDS_MAX)
        except TimeoutExpired:
            child.kill()
            child.communicate()
            said = b""
    try:
        answer: dict[str, Any] = json.loads(said)
    except ValueError:
        raise Unreadable(f"{name} takes too much memory or time to read") from None
    if "faults" in answer:
        raise Unreadable(answer["reason"], tuple(answer["faults"]))
    return answer


def answer_of_child(path: Path, name: str) -> str:
    """What the child prints: what was understood, or every fault, as JSON."""
    _limit()
    try:
        return json.dumps(understood(path, name))
    except Unreadable as error:
        return json.dumps({"reason": str(error), "faults": error.faults})


def _limit() -> None:
    """Take no more memory and time than that, where the system knows such limits."""
    if sys.platform == "win32":
        return
    import resource

    for what, most in ((resource.RLIMIT_AS, MEMORY_MAX), (resource.RLIMIT_CPU, SECONDS_MAX)):
        _, hard = resource.getrlimit(what)
        ceiling = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (ceiling, ceiling))


def understood(path: Path, name: str) -> dict[str, Any]:
    """What a file was taken for; a ground that needs a key of [terrain] says which. Raises
    ``Unreadable``.
    """
    if names_toml_file(name):
        return {"kind": "robot", **_robot(path)}
    hand = _hand(path) if path.suffix.lower() == ".csv" else ""
    if hand:
        return {"kind": "hand", "note": hand}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            READERS[path.suffix.lower()](path)
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        reason = " ".join(str(error).replace(str(path), name).replace(path.name, name).split())[
            :200
        ]
        raise Unreadable(f"{name} cannot be read: {reason or type(error).__name__}") from None
    try:
        read = read_heights(FileTerrain(kind="file", file=str(path)), None)
    except GroundError as error:
        return {"kind": "ground", "note": "", "needs": str(error).replace(str(path), name)}
    return {"kind": "ground", "note": read.note}


def _hand(path: Path) -> str:
    """What a recorded hand is; '' for a file that is none."""
    try:
        entries = read_drive(path, path.name)
    except DriveFileError:
        return ""
    return f"{len(entries)} commands in {entries[-1]['t'] - entries[0]['t']:g} s"


def _robot(path: Path) -> dict[str, Any]:
    """The robot of a description in a line, and how many legs it has."""
    try:
        machine = load_machine(str(path))
    except MachineError as error:
        faults = tuple(fault.replace(str(path), path.name[len(PART) :]) for fault in error.faults)
        raise Unreadable("; ".join(faults), faults) from None
    legs = len(machine.legs)
    return {"note": f"{machine.name}: {machine.title} ({legs} legs)", "legs": legs}
