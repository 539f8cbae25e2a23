"""What every reader answers with: heights as the file has them, and what it says about itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..generators import GroundError
from ..wide_map import WHOLE_CELLS_MAX

CELLS_MAX = 36_000_000  # a text, a mesh or a coloured picture may hold: 6000 x 6000
FILE_BYTES_MAX = 512_000_000

Heights = NDArray[np.floating[Any]]  # m, of single precision where the map is large


@dataclass(frozen=True, eq=False)
class Raster:
    """Heights (ny, nx) with the row of least y first, before scale and offset.

    ``cell`` is the size of a cell along x and y, m, None where the file does not say. ``origin`` is
    x, y of the outer corner of cell [0, 0] where the file has a place of its own that means
    something to a walker. ``nodata`` are heights that stand for nothing. ``surface`` is a finer
    answer than the cells: heights rasterised from triangles at any cell size.
    """

    heights: Heights
    what: str  # for the one line that says what was understood, such as "16-bit grey picture"
    cell: tuple[float, float] | None = None
    origin: tuple[float, float] | None = None
    nodata: tuple[float, ...] = ()
    latitude: float | None = None  # where its cells are degrees of longitude and latitude; °
    scaled: bool = False  # heights are in metres already: scale has been applied to all axes
    surface: Callable[[float, float, str | None], Raster] | None = None  # scale, cell in m, up


def as_heights(values: NDArray[Any]) -> Heights:
    """Numbers as heights: of single precision where they are more than a map that is held whole
    has, as a wide map rounds them anyway.
    """
    if values.size > WHOLE_CELLS_MAX:
        return np.asarray(values, dtype=np.float32)
    return np.asarray(values, dtype=np.float64)


def check_size(ny: int, nx: int, most: int = CELLS_MAX) -> None:
    """Refuse a grid that is too large to be read at all, before it is read."""
    if ny * nx > most:
        raise GroundError(f"{nx} x {ny} cells; at most {most} can be read from a file")
    if min(ny, nx) < 1:
        raise GroundError(f"{nx} x {ny} cells; at least 2 x 2 are wanted")
