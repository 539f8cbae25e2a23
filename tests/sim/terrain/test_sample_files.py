"""Files that other packages bring with them, as a stranger would try them: loaded, answered with
the one key they need, or refused by what they are.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest

from walking_console.sim.terrain.files import FileGround, read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError

DATA = Path(matplotlib.__file__).parent / "mpl-data"
SAMPLES = DATA / "sample_data"
NUMPY = Path(np.__file__).parent / "lib" / "tests" / "data"


def read(path: Path, **keys: Any) -> FileGround:
    if not path.is_file():
        pytest.skip(f"this installation has no {path.name}")
    return read_heights(FileTerrain(kind="file", file=str(path), **keys), None)


def test_a_surface_of_matplotlib_loads_with_nothing_but_its_name() -> None:
    path = SAMPLES / "axes_grid" / "bivariate_normal.npy"
    ground = read(path)
    np.testing.assert_array_equal(ground.heights, np.load(path))
    assert ground.note == "float64 array, 15 x 15 of 0.05 m"


@pytest.mark.parametrize(
    ("name", "shape"), [("jacksboro_fault_dem.npz", (344, 403)), ("topobathy.npz", None)]
)
def test_elevation_in_degrees_names_the_cell_and_loads_with_it(
    name: str, shape: tuple[int, int] | None
) -> None:
    with pytest.raises(
        GroundError, match=r"degrees .* at latitude [-\d.]+ that is cell = "
    ) as said:
        read(SAMPLES / name)
    cell = [float(word) for word in str(said.value).split("cell = [")[1].rstrip("]").split(",")]
    ground = read(SAMPLES / name, cell=cell, scale=0.01)
    assert "interpolated to 0.05 m" in ground.note
    if shape is not None:
        assert f"{shape[1]} x {shape[0]} of" in ground.note


@pytest.mark.parametrize(
    "name", ["back", "filesave_large", "help", "home_large", "move", "subplots"]
)
def test_icons_say_that_they_have_holes_and_load_with_them(name: str) -> None:
    path = DATA / "images" / f"{name}.png"
    with pytest.raises(GroundError, match='set nan = "hole"'):
        read(path)
    ground = read(path, nan="hole", scale=0.1)
    assert 0.0 < np.isnan(ground.heights).mean() < 1.0
    assert "8-bit picture of mode" in ground.note


@pytest.mark.parametrize(
    ("path", "says"),
    [
        (SAMPLES / "grace_hopper.jpg", "this one is coloured"),
        (SAMPLES / "logo2.png", "this one is coloured"),
        (SAMPLES / "Minduka_Present_Blue_Pack.png", "this one is coloured"),
        (SAMPLES / "msft.csv", "holds what is no number: '19-Sep-03'"),
        (SAMPLES / "Stocks.csv", "holds what is no number: '1990-01-01'"),
        (SAMPLES / "eeg.dat", "text is wanted, and it is binary: it begins with"),
        (SAMPLES / "goog.npz", "no 'heights' in it, only price_data"),
        (SAMPLES / "s1045.ima.gz", "must end in one of"),
        (NUMPY / "py3-objarr.npy", "numbers wanted, got object"),
        (NUMPY / "py2-objarr.npz", "no 'heights' in it, only x"),
        (NUMPY / "python3.npy", r"got shape \(2,\)"),
        (NUMPY / "win64python2.npy", r"got shape \(2,\)"),
    ],
    ids=lambda value: value.name if isinstance(value, Path) else "",
)
def test_what_is_no_ground_is_refused_by_what_it_is(path: Path, says: str) -> None:
    with pytest.raises(GroundError, match=says) as said:
        read(path)
    assert "\n" not in str(said.value)
