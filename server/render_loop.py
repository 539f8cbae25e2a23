"""The render loop: hands the newest snapshot to the scene; a slow draw skips snapshots."""

from __future__ import annotations

import logging
import threading
import time
import traceback
from collections.abc import Callable

from walking_console.sim.snapshot import Snapshot

from .loop_thread import LoopThread
from .realtime_loop import RealtimeLoop
from .scheduling import raise_priority

DRAW_RATE = 25.0  # Hz
DRAW_RATE_UNWATCHED = 2.0  # Hz while no canvas is open: enough for the next one to start from

log = logging.getLogger(__name__)


class RenderLoop:
    """Draws the newest snapshot in a thread of its own; a draw that fails is logged once and tried
    again.
    """

    def __init__(
        self, loop: RealtimeLoop, draw: Callable[[Snapshot], None], watched: Callable[[], bool]
    ) -> None:
        self.fault = ""
        self.draws = 0
        self._loop = loop
        self._draw = draw
        self._watched = watched
        self._thread = LoopThread("rendering", self._run)
        self.start = self._thread.start
        self.stop = self._thread.stop

    def _run(self, stopping: threading.Event) -> None:
        raise_priority()
        drawn: Snapshot | None = None
        wait = 0.0
        while not stopping.wait(wait):
            begun = time.monotonic()
            newest = self._loop.newest
            if newest is not drawn:
                self.show(newest)
                drawn = newest
            wait = max(0.0, begun + self._period() - time.monotonic())

    def _period(self) -> float:
        """Seconds from one draw to the next."""
        return 1.0 / (DRAW_RATE if self._watched() else DRAW_RATE_UNWATCHED)

    def show(self, snapshot: Snapshot) -> None:
        """Draw one snapshot; a failure is kept in ``fault``."""
        try:
            self._draw(snapshot)
        except Exception:
            if not self.fault:
                log.exception("the scene could not be drawn")
            self.fault = traceback.format_exc()
        else:
            self.draws += 1
            self.fault = ""
