"""Height files and robots that people bring over HTTP: kept in a folder of their own under plain
names, and read once before they are kept, by a child that may not take much.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from walking_console.planner.robot.toml_files import FILE_BYTES_MAX, names_toml_file
from walking_console.sim.terrain.readers import READERS

from .uploaded_file import PART, ReadUpload, Unreadable, understood

UPLOAD_MAX = 32 * 1024 * 1024  # bytes of one file
UPLOADS_KEPT = 100
UPLOADS_BYTES_MAX = 500_000_000  # of all that are kept
# letters, digits and what names need; never a path, and never a hidden file
UPLOAD_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$"


class UploadRefused(ValueError):
    """A file that is not kept, with the HTTP status that says so and every fault of it."""

    def __init__(self, status: int, reason: str, faults: tuple[str, ...] = ()) -> None:
        super().__init__(reason)
        self.status = status
        self.faults = faults or (reason,)


class Uploads:
    """The folder; used from worker threads, one at a time."""

    def __init__(self, data: Path, read: ReadUpload = understood) -> None:
        self.folder = data.absolute() / "uploads"
        self._read = read

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
            said = self._read(part, name)
            os.replace(part, self.folder / name)
        except Unreadable as error:
            raise UploadRefused(422, str(error), error.faults) from None
        finally:
            part.unlink(missing_ok=True)
        return {"name": name, "bytes": len(body), **said}

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
