"""Readers of height files: one module a family of formats, each answering with a ``Raster``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .arrays import read_npy, read_npz
from .meshes import read_mesh
from .pictures import read_png
from .raster import Raster
from .text import read_ascii_grid, read_csv
from .tiff import read_tiff

READERS: dict[str, Callable[[Path], Raster]] = {
    ".npy": read_npy,
    ".npz": read_npz,
    ".png": read_png,
    ".tif": read_tiff,
    ".tiff": read_tiff,
    ".asc": read_ascii_grid,
    ".csv": read_csv,
    ".txt": read_csv,
    ".xyz": read_csv,
    ".stl": read_mesh,
    ".ply": read_mesh,
    ".obj": read_mesh,
}

__all__ = ["READERS", "Raster"]
