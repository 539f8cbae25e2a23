"""One height file of every kind that people bring, each tried with nothing but its name.

Run: python -m tests.sweeps.height_files FOLDER. The files are left in FOLDER; each is walked on by
``walking-console run`` and what came of it is printed as the table in docs/height-files.md. A file
that needs a key more must name it in its refusal, and is walked on with that key.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import png
import tifffile
import trimesh
from PIL import Image
from typer.testing import CliRunner

from walking_console.server.cli import app
from walking_console.sim.terrain.files import FileGround, read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError

CELL = 0.05  # m
ROWS = 100
COLUMNS = 120
KEY = re.compile(r'nan = "hole"|cell = \[[^\]]*\]')

Heights = np.ndarray[Any, np.dtype[np.float64]]

# steps of a pixel's level up to the north and the east: what pictures can hold, first row lowest
LEVELS = np.add.outer(np.arange(ROWS) // 16, np.arange(COLUMNS) // 12).astype(np.int64)
HILL = LEVELS / 255.0  # m
# level ground and a block in its north-east corner: what whole metres, and black and white, can
BLOCK = np.zeros((ROWS, COLUMNS))
BLOCK[90:, 100:] = 1.0
PLANE = np.broadcast_to(0.03 * (np.arange(COLUMNS) + 0.5) * CELL, (ROWS, COLUMNS))
HOLED = HILL.copy()
HOLED[:4, :6] = np.nan


@dataclass(frozen=True)
class HeightFile:
    """A kind of file: how one is written, and the heights (m, first row lowest) it then holds."""

    what: str
    name: str
    write: Callable[[Path], None]
    heights: Heights
    cell: float = CELL  # m, as the file says or as is taken without


def _north_up(heights: Heights) -> Heights:
    return np.ascontiguousarray(heights[::-1])


# -- pictures


def _picture(mode: str) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        grey = Image.fromarray(_north_up(LEVELS).astype(np.uint8))
        grey.convert(mode).save(path)

    return write


def _black_and_white(path: Path) -> None:
    Image.fromarray(_north_up(BLOCK) > 0.5).save(path)


def _deep(channels: int) -> Callable[[Path], None]:
    """16 bits a channel; with 2 or 4 channels the last is opaque."""

    def write(path: Path) -> None:
        planes = np.repeat((_north_up(LEVELS) * 257)[..., None], channels, axis=2)
        if channels in (2, 4):
            planes[..., -1] = 65535
        writer = png.Writer(
            COLUMNS, ROWS, greyscale=channels < 3, alpha=channels in (2, 4), bitdepth=16
        )
        with path.open("wb") as file:
            writer.write(file, planes.reshape(ROWS, -1).tolist())

    return write


# -- TIFF and GeoTIFF

PIXEL = (33550, 12, 3, (CELL, CELL, 0.0), False)
TIE = (33922, 12, 6, (0.0, 0.0, 0.0, 641_000.0, 5_812_000.0, 0.0), False)
BERLIN = (33922, 12, 6, (0.0, 0.0, 0.0, 13.4, 52.5, 0.0), False)
METRES = (34735, 3, 8, (1, 1, 0, 1, 1024, 0, 1, 1), False)
DEGREES = (34735, 3, 8, (1, 1, 0, 1, 1024, 0, 1, 2), False)
NODATA = (42113, 2, 0, "-9999", False)


def _tiff(
    kind: str, heights: Heights, tags: Iterable[Any] = (PIXEL, TIE, METRES), **layout: Any
) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        values = np.nan_to_num(_north_up(heights), nan=-9999.0).astype(kind)
        tifffile.imwrite(path, values, extratags=list(tags), **layout)

    return write


def _lzw(path: Path) -> None:
    Image.fromarray(_north_up(HILL).astype(np.float32)).save(path, compression="tiff_lzw")


# -- text


def _words(heights: Heights, separator: str = " ", point: str = ".") -> list[str]:
    return [
        separator.join(f"{value:.6f}".replace(".", point) for value in row)
        for row in _north_up(np.nan_to_num(heights, nan=-9999.0))
    ]


def _text(lines: Callable[[], list[str]], newline: str = "\n", **how: Any) -> Callable[..., None]:
    def write(path: Path) -> None:
        path.write_text("\n".join(lines()) + "\n", newline=newline, **{"encoding": "utf-8", **how})

    return write


ESRI = ["ncols 120", "nrows 100", "xllcorner 641000", "yllcorner 5812000", "cellsize 0.05"]
MIXED = ["CELLSIZE 0.05", "NROWS 100", "XLLCENTER 641000", "NCOLS 120", "YLLCENTER 5812000"]
GRASS = ["north: 5.0", "south: 0.0", "east: 6.0", "west: 0.0", "rows: 100", "cols: 120"]


def _wrapped() -> list[str]:
    words = " ".join(_words(HILL)).split()
    return ESRI + [" ".join(words[k : k + 7]) for k in range(0, len(words), 7)]


def _points(separator: str) -> list[str]:
    return [
        separator.join(f"{v:.6f}" for v in ((c + 0.5) * CELL, (r + 0.5) * CELL, HILL[r, c]))
        for r in range(ROWS)
        for c in range(COLUMNS)
    ]


# -- arrays and meshes


def _npy(kind: str, heights: Heights) -> Callable[[Path], None]:
    return lambda path: np.save(path, heights.astype(kind))


def _npz(**more: Any) -> Callable[[Path], None]:
    return lambda path: np.savez(path, **{"heights": HILL.astype(np.float32), **more})


def _mesh(path: Path) -> None:
    """The plane as two triangles, in a corner of space of its own."""
    width = COLUMNS * CELL
    depth = ROWS * CELL
    corners = [[0, 0, 0], [width, 0, 0.03 * width], [width, depth, 0.03 * width], [0, depth, 0]]
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False).export(path)


def _ascii_stl(path: Path) -> None:
    plain = path.with_suffix(".obj")
    _mesh(plain)
    path.write_text(trimesh.load(plain).export(file_type="stl_ascii"), "utf-8")
    plain.unlink()


FILES = (
    HeightFile("PNG, 8-bit grey", "grey.png", _picture("L"), HILL),
    HeightFile("PNG, black and white", "one-bit.png", _black_and_white, BLOCK),
    HeightFile("PNG, grey with alpha", "grey-alpha.png", _picture("LA"), HILL),
    HeightFile("PNG, palette", "palette.png", _picture("P"), HILL),
    HeightFile("PNG, equal RGB", "rgb.png", _picture("RGB"), HILL),
    HeightFile("PNG, equal RGBA", "rgba.png", _picture("RGBA"), HILL),
    HeightFile("PNG, 16-bit grey", "grey-16.png", _deep(1), HILL),
    HeightFile("PNG, 16-bit grey with alpha", "grey-alpha-16.png", _deep(2), HILL),
    HeightFile("PNG, 16-bit equal RGB", "rgb-16.png", _deep(3), HILL),
    HeightFile("PNG, 16-bit equal RGBA", "rgba-16.png", _deep(4), HILL),
    HeightFile("TIFF without tags", "plain.tif", _tiff("f4", HILL, ()), HILL),
    HeightFile("GeoTIFF, float32", "f4.tif", _tiff("f4", HILL), HILL),
    HeightFile("GeoTIFF, float64, big-endian", "f8.tif", _tiff(">f8", HILL), HILL),
    HeightFile("GeoTIFF, int16", "i2.tif", _tiff("i2", BLOCK), BLOCK),
    HeightFile("GeoTIFF, uint16", "u2.tif", _tiff("u2", BLOCK), BLOCK),
    HeightFile(
        "GeoTIFF, deflated tiles",
        "tiles.tif",
        _tiff("f4", HILL, tile=(32, 32), compression="zlib"),
        HILL,
    ),
    HeightFile("TIFF, LZW", "lzw.tif", _lzw, HILL),
    HeightFile(
        "GeoTIFF, unequal pixels",
        "unequal.tif",
        _tiff("f4", HILL[::2], [(33550, 12, 3, (CELL, 2 * CELL, 0.0), False), TIE, METRES]),
        np.empty(0),
    ),
    HeightFile("GeoTIFF above the sea", "sea.tif", _tiff("f4", HILL + 437.2), HILL),
    HeightFile("GeoTIFF with NODATA", "nodata.tif", _tiff("f4", HOLED, [PIXEL, NODATA]), HOLED),
    HeightFile(
        "GeoTIFF in degrees",
        "degrees.tif",
        _tiff("f4", HILL, [(33550, 12, 3, (2.8e-4, 2.8e-4, 0.0), False), BERLIN, DEGREES]),
        np.empty(0),
    ),
    HeightFile("ESRI ASCII", "esri.asc", _text(lambda: ESRI + _words(HILL)), HILL),
    HeightFile(
        "ESRI ASCII, any order and case, centre, CRLF",
        "mixed.ASC",
        _text(lambda: MIXED + _words(HILL), newline="\r\n"),
        HILL,
    ),
    HeightFile("ESRI ASCII, wrapped rows", "wrapped.asc", _text(_wrapped), HILL),
    HeightFile(
        "ESRI ASCII with NODATA",
        "nodata.asc",
        _text(lambda: [*ESRI, "NODATA_value -9999", *_words(HOLED)]),
        HOLED,
    ),
    HeightFile("GRASS ASCII", "grass.txt", _text(lambda: GRASS + _words(HILL)), HILL),
    HeightFile("CSV matrix", "comma.csv", _text(lambda: _words(HILL, ",")), HILL),
    HeightFile(
        "CSV matrix, semicolons and decimal commas, UTF-8 with a mark",
        "excel.csv",
        _text(lambda: _words(HILL, ";", ","), newline="\r\n", encoding="utf-8-sig"),
        HILL,
    ),
    HeightFile("TSV matrix", "tabs.tsv", _text(lambda: _words(HILL, "\t")), HILL),
    HeightFile(
        "CSV points with a heading", "named.csv", _text(lambda: ["x,y,z", *_points(",")]), HILL
    ),
    HeightFile("XYZ points", "points.xyz", _text(lambda: _points(" ")), HILL),
    HeightFile("NPY, float64", "f8.npy", _npy("f8", HILL), HILL),
    HeightFile("NPY, float32, big-endian", "f4.npy", _npy(">f4", HILL), HILL),
    HeightFile("NPY, float16", "f2.npy", _npy("f2", HILL), HILL),
    HeightFile("NPY, int16", "i2.npy", _npy("i2", BLOCK), BLOCK),
    HeightFile("NPZ, heights alone", "alone.npz", _npz(), HILL),
    HeightFile(
        "NPZ with cell and origin", "placed.npz", _npz(cell=0.04, origin=[-2, -2]), HILL, 0.04
    ),
    HeightFile("STL, binary", "plane.stl", _mesh, PLANE),
    HeightFile("STL, ASCII", "plane-ascii.stl", _ascii_stl, PLANE),
    HeightFile("PLY", "plane.ply", _mesh, PLANE),
    HeightFile("OBJ", "plane.obj", _mesh, PLANE),
)


@dataclass(frozen=True)
class Answer:
    """What a file came to: the ground, and the key it needed, "" for none."""

    ground: FileGround | None
    key: str
    said: str


def asked(file: HeightFile, folder: Path) -> Answer:
    """The file written and read: with nothing but its name, else with the key its refusal names."""
    file.write(folder / file.name)
    try:
        return _read(file, folder, "")
    except GroundError as error:
        said = str(error)
    named = KEY.search(said)
    if named is None:
        return Answer(None, "", said)
    return _read(file, folder, named[0])


def _read(file: HeightFile, folder: Path, key: str) -> Answer:
    keys = _keys(key)
    ground = read_heights(FileTerrain(kind="file", file=file.name, **keys), folder)
    return Answer(ground, key, ground.note)


def _keys(key: str) -> dict[str, Any]:
    """A key as a refusal writes it, ``nan = "hole"``, as a value."""
    if not key:
        return {}
    name, value = (part.strip() for part in key.split("=", 1))
    return {name: json.loads(value)}


def table(folder: Path) -> str:
    """What came of every file, as Markdown."""
    rows = ["| file | loads with | understood as |", "|---|---|---|"]
    answers = [(file, asked(file, folder)) for file in FILES]
    for file, answer in answers:
        needs = f"`{answer.key}`" if answer.key else "its name"
        rows.append(f"| {file.what} | {needs if answer.ground else 'refused'} | {answer.said} |")
    alone = sum(answer.ground is not None and not answer.key for _, answer in answers)
    return "\n".join((*rows, "", f"{alone} of {len(FILES)} load with nothing but their name.\n"))


def walked(file: HeightFile, key: str, folder: Path) -> int:
    """The exit code of ``walking-console run`` on a file, three seconds long."""
    scenario = folder / f"{file.name}.toml"
    more = f"{key}\n" if key else ""
    scenario.write_text(
        f'planner = "crab"\n[terrain]\nkind = "file"\nfile = "{file.name}"\n{more}'
        "[[drive]]\nspeed = 0.1\n[end]\ntime = 3.0\n",
        "utf-8",
    )
    out = str(folder / "out")
    result = CliRunner().invoke(app, ["run", str(scenario), "--out", out, "--force"])
    return result.exit_code


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    print(table(folder))
    for file in FILES:
        code = walked(file, asked(file, folder).key, folder)
        if code:
            print(f"{file.name}: walking-console run ended with {code}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
