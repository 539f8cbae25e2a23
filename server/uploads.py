"""Height files and robots that people bring over HTTP: kept in a folder of their own under plain
names, and read once before they are kept.
"""

from __future__ import annotations

import os
import re
import warnings
from pathlib import Path
from typing import Any

from walking_console.planner.robot.model import MachineError, load_machine
from walking_console.planner.robot.toml_files import FILE_BYTES_MAX, names_toml_file
from walking_console.sim.drive_files import DriveFileError, read_drive
from walking_console.sim.terrain.files import read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError
from walking_console.sim.terrain.readers import READERS

UPLOAD_MAX = 32 * 1024 * 1024  # bytes of one file
UPLOADS_KEPT = 100
UPLOADS_BYTES_MAX = 500_000_000  # of all that are kept
# letters, digits and what names need; never a path, and never a hidden file
UPLOAD_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$"
PART = ".part-"  # what a file is called until it has been read


class UploadRefused(ValueError):
    """A file that is not kept, with the HTTP status that says so and every fault of it."""

    def __init__(self, status: int, reason: str, faults: tuple[str, ...] = ()) -> None:
        super().__init__(reason)
        self.status = status
        self.faults = faults or (reason,)


class Uploads:
    """The folder; used from worker threads, one at a time."""

    def __init__(self, data: Path) -> None:
        self.folder = data.absolute() / "uploads"

    def names(self) -> list[str]:
        """Of all that are kept, sorted."""
        if not self.folder.is_dir():
            return []
        return sorted(entry.name for entry in self.folder.iterdir() if _is_name(entry.name))

    def holds(self, name: str) -> bool:
        """Whether a file of this plain name is kept."""
        return _is_name(name) and (self.folder / name).is_file()

    def store(self, name: str, body: bytes) -> dict[str, Any]:
        """Read a file and keep it under its name, in place of an older one; answers with what was
        understood. Raises ``UploadRefused``.
        """
        self._check(name, body)
        self.folder.mkdir(parents=True, exist_ok=True)
        part = self.folder / f"{PART}{name}"
        try:
            part.write_bytes(body)
            understood = _understood(part, name)
            os.replace(part, self.folder / name)
        finally:
            part.unlink(missing_ok=True)
        return {"name": name, "bytes": len(body), **understood}

    def remove(self, name: str) -> None:
        """Keep it no longer."""
        (self.folder / name).unlink(missing_ok=True)

    def _check(self, name: str, body: bytes) -> None:
        suffix = Path(name).suffix.lower()
        if not _is_name(name) or (suffix not in READERS and not names_toml_file(name)):
            kinds = ", ".join((*sorted(READERS), ".toml"))
            raise UploadRefused(422, f"a file must have a plain name that ends in one of: {kinds}")
        limit = FILE_BYTES_MAX if names_toml_file(name) else UPLOAD_MAX
        if len(body) > limit:
            raise UploadRefused(413, f"{name} has {len(body)} bytes; at most {limit} are taken")
        kept = [self.folder / other for other in self.names() if other != name]
        size = sum(path.stat().st_size for path in kept)
        if len(kept) >= UPLOADS_KEPT or size + len(body) > UPLOADS_BYTES_MAX:
            raise UploadRefused(
                507, f"{len(kept)} files of {size} bytes are kept; delete some of them first"
            )


def _is_name(name: str) -> bool:
    return re.fullmatch(UPLOAD_NAME, name) is not None


def _understood(path: Path, name: str) -> dict[str, Any]:
    """What a file was taken for. A ground that needs a key of [terrain] is kept and says which."""
    if names_toml_file(name):
        return {"kind": "robot", "note": _robot(path)}
    hand = _hand(path) if path.suffix.lower() == ".csv" else ""
    if hand:
        return {"kind": "hand", "note": hand}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            READERS[path.suffix.lower()](path)
    # broken files raise whatever the decoders underneath happen to: struct, zlib, tokenize ...
    except Exception as error:
        reason = " ".join(str(error).replace(path.name, name).split())[:200]
        raise UploadRefused(
            422, f"{name} cannot be read: {reason or type(error).__name__}"
        ) from None
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


def _robot(path: Path) -> str:
    try:
        machine = load_machine(str(path))
    except MachineError as error:
        faults = tuple(fault.replace(str(path), path.name[len(PART) :]) for fault in error.faults)
        raise UploadRefused(422, "; ".join(faults), faults) from None
    return f"{machine.name}: {machine.title} ({len(machine.legs)} legs)"
