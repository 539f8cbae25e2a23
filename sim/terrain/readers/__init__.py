"""Readers of height files: one module a family of formats, each answering with a ``Raster``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .arrays import read_npy, read_npz
from .meshes import read_mesh
from .pictures import read_picture
from .raster import Raster
from .text import read_text
from .tiff import read_tiff

READERS: dict[str, Callable[[Path], Raster]] = {
    ".npy": read_npy,
    ".npz": read_npz,
    **dict.fromkeys((".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm"), read_picture),
    **dict.fromkeys((".tif", ".tiff"), read_tiff),
    **dict.fromkeys((".asc", ".grd", ".csv", ".tsv", ".txt", ".dat", ".xyz"), read_text),
    **dict.fromkeys((".stl", ".ply", ".obj"), read_mesh),
}

__all__ = ["READERS", "Raster"]
