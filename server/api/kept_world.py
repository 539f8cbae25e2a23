"""The world last loaded, kept in the data folder: a console that is started again stands in it."""

from __future__ import annotations

import asyncio
import logging
import os
from pathlib import Path

from pydantic import ValidationError

from walking_console.sim.world import World

from ..disk_thread import DiskThread
from ..limits import BODY_MAX, LOADS_AT_ONCE
from ..schemas import ScenarioBody
from ..uploads import Uploads
from .errors import HTTPProblem
from .scenario_choice import world_of

log = logging.getLogger(__name__)


class KeptWorld:
    """The body by which a world was loaded, in ``file``."""

    def __init__(self, file: Path, disk: DiskThread | None = None) -> None:
        self._file = file
        self._disk = disk or DiskThread()
        self.turn = asyncio.Semaphore(LOADS_AT_ONCE)  # to make another world

    def keep(self, body: ScenarioBody) -> None:
        """Another world is shown; the disk follows."""
        text = body.model_dump_json(exclude_none=True)
        self._disk.write(lambda: self._write(text), "a restart will not know of this world")

    def _write(self, text: str) -> None:
        self._file.parent.mkdir(parents=True, exist_ok=True)
        part = self._file.with_suffix(".part")
        part.write_text(text, "utf-8")
        os.replace(part, self._file)

    def made(self, uploads: Uploads) -> World | None:
        """The world that was kept, at its start; None where there is none any more."""
        # no pipe, and nothing that nobody has sent
        if not self._file.is_file() or self._file.stat().st_size > BODY_MAX:
            return None
        try:
            return world_of(ScenarioBody.model_validate_json(self._file.read_bytes()), uploads)
        except (OSError, ValidationError, HTTPProblem) as error:
            log.warning("the world of before the restart cannot be made again: %s", error)
            return None
