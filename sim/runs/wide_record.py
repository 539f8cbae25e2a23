"""The ground of a run on a wide map: the part that the walk has depended on, and where it lies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.terrain.grid import Window, common, within
from walking_console.planner.types import Array
from walking_console.sim.perception import Perception
from walking_console.sim.surroundings import Surroundings
from walking_console.sim.terrain.ground import Ground, GroundError, window_at
from walking_console.sim.terrain.wide_map import TILE, WIDE_CELLS_MAX, WideMap

Arrays = dict[str, np.ndarray[Any, Any]]

BAND_CELLS = 1_000_000  # worked out at once
PLACE_NUMBERS = 4  # row, column, rows, columns


def wide_arrays(begun_on: WideMap, perception: Perception, wide: Surroundings) -> Arrays:
    """What is kept of a wide map: ``heights``, ``forbidden``, ``believed_heights`` and
    ``believed_forbidden`` of the cells that the walk has depended on, as in any run; ``place`` says
    where those begin in the whole map and how large that is, ``whole_origin`` where it lies,
    ``relief`` what ground it is. ``start_heights`` are there only where ``heights`` were changed.
    """
    window = wide.recorded()
    shape = tuple(side.stop - side.start for side in window)
    heights = np.empty(shape, dtype=np.float32)
    believed = np.empty(shape, dtype=np.float32)
    forbidden = np.empty(shape, dtype=bool)
    closed = np.empty(shape, dtype=bool)
    whole = wide.tiles.whole
    for band in _bands(window):
        here = within(band, window)
        heights[here] = whole.read(*band)
        forbidden[here] = wide.truly_forbidden(band)
        believed[here], closed[here] = wide.believed(band, forbidden[here], perception.mapper)
    at_hand = within(perception.ground.cells, window)
    forbidden[at_hand] = perception.true_forbidden
    believed[at_hand] = perception.belief.heights
    closed[at_hand] = perception.belief.forbidden
    arrays: Arrays = {
        "heights": heights,
        "forbidden": forbidden,
        "believed_heights": believed,
        "believed_forbidden": closed,
        "cell": np.array(whole.cell),
        "origin": np.array(whole.corner(window)),
        "place": np.array([window[0].start, window[1].start, *whole.shape]),
        "whole_origin": np.array(whole.origin),
        "relief": np.array(bool(perception.ground.relief)),
    }
    if begun_on.changed is not whole.changed:
        arrays["start_heights"] = begun_on.read(*window).astype(np.float32)
    return arrays


def _bands(window: Window) -> Iterator[Window]:
    """A window, some rows of tiles at a time."""
    rows, columns = window
    tall = max(1, BAND_CELLS // (columns.stop - columns.start) // TILE) * TILE
    for first in range(rows.start, rows.stop, tall):
        yield slice(first, min(first + tall, rows.stop)), columns


@dataclass(frozen=True, eq=False)
class _Part:
    """Heights of a part of a map, from row and column ``corner`` on; NaN where it has none."""

    heights: NDArray[np.float32]
    corner: tuple[int, int]

    def __call__(self, rows: slice, columns: slice) -> NDArray[np.float32]:
        wanted = slice(rows.start, rows.stop), slice(columns.start, columns.stop)
        shape = [side.stop - side.start for side in wanted]
        ny, nx = self.heights.shape
        row, column = self.corner
        mine = slice(row, row + ny), slice(column, column + nx)
        shared = common(wanted, mine)
        found = np.full(shape, np.nan, dtype=np.float32)
        found[within(shared, wanted)] = self.heights[within(shared, mine)]
        return found[:: rows.step, :: columns.step]


def wide_ground(arrays: Arrays, heights: Array, kind: str, final: bool) -> Ground:
    """The ground a walk on a wide map was begun on, from what was kept; raises ``GroundError`` for
    arrays that are none.
    """
    place, origin = arrays["place"], arrays.get("whole_origin")
    if place.shape != (PLACE_NUMBERS,) or place.dtype.kind not in "iu":
        raise GroundError(f"place must be {PLACE_NUMBERS} whole numbers, got {place!r:.80}")
    row, column, rows, columns = place.tolist()
    ny, nx = heights.shape
    fits = 0 <= row <= rows - ny and 0 <= column <= columns - nx
    if not fits or rows * columns > WIDE_CELLS_MAX:
        raise GroundError(f"{nx} x {ny} cells cannot lie as place says, {place!r:.80}")
    if "relief" not in arrays:
        raise GroundError("there is no 'relief' beside 'place'")
    if origin is None or origin.shape != (2,) or not np.isfinite(origin).all():
        raise GroundError(f"whole_origin must be x and y, got {origin!r:.60}")
    x, y = float(origin[0]), float(origin[1])
    part = _Part(heights.astype(np.float32), (row, column))
    whole = WideMap((rows, columns), float(arrays["cell"]), (x, y), part)
    middle = whole.corner((slice(row + ny // 2, None), slice(column + nx // 2, None)))
    return window_at(whole, middle, kind, final, relief=bool(arrays["relief"].any()))
