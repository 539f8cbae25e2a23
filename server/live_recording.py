"""The last minutes of what is walked live, so that nothing anybody walked is lost: snapshots in
memory, bounded in time and in bytes, written out as a replay page by a child.
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import replace

from walking_console.planner.types import TICK
from walking_console.sim.snapshot import Snapshot, TerrainView

EVERY = 3  # ticks between two snapshots that are kept: 60 ms
KEPT_SECONDS = 300.0
KEPT_MAX = round(KEPT_SECONDS / (EVERY * TICK))
GROUND_BYTES_MAX = 200_000_000  # of all grounds that are kept; older snapshots go with theirs
GROUND_EVERY = 1.0  # s between two grounds that are kept while an eye sees more with every look


class LiveRecording:
    """Kept in the walking thread by ``note``; read by any other."""

    def __init__(self) -> None:
        self._kept: deque[Snapshot] = deque(maxlen=KEPT_MAX)
        self._lock = threading.Lock()

    def note(self, snapshot: Snapshot) -> None:
        """Keep a snapshot, unless nothing went on since the last one."""
        last = self._kept[-1] if self._kept else None
        if last is not None and last.tick <= snapshot.tick < last.tick + EVERY:
            return
        ground = snapshot.terrain
        if last is not None and _is_alike(last, snapshot):
            ground = last.terrain
        with self._lock:
            self._kept.append(replace(snapshot, terrain=ground, ready=None, decision=None))
            if last is not None and ground is not last.terrain:
                self._forget_grounds()

    def _forget_grounds(self) -> None:
        grounds: dict[int, TerrainView] = {id(each.terrain): each.terrain for each in self._kept}
        size = sum(ground.heights.nbytes + ground.forbidden.nbytes for ground in grounds.values())
        while size > GROUND_BYTES_MAX and len(self._kept) > 1:
            gone = self._kept.popleft().terrain
            if gone is not self._kept[0].terrain:
                size -= gone.heights.nbytes + gone.forbidden.nbytes

    def last(self, seconds: float) -> tuple[Snapshot, ...]:
        """The snapshots of the last seconds that were walked, over resets and worlds; oldest
        first.
        """
        with self._lock:
            kept = tuple(self._kept)
        return kept[max(0, len(kept) - max(1, round(seconds / (EVERY * TICK)))) :]

    @property
    def seconds(self) -> float:
        """How much is kept, s."""
        return len(self._kept) * EVERY * TICK


def _is_alike(last: Snapshot, snapshot: Snapshot) -> bool:
    """True while an eye goes on looking at the ground that is kept, and it was kept a moment
    ago.
    """
    kept, now = last.terrain, snapshot.terrain
    if kept is now:
        return True
    same = kept.heights.shape == now.heights.shape and kept.cell == now.cell
    whole = int(last.time / GROUND_EVERY) == int(snapshot.time / GROUND_EVERY)
    return same and whole and last.time <= snapshot.time and last.scenario == snapshot.scenario
