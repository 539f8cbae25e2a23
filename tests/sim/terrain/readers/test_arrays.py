"""Arrays of numpy: checked from their headers, rows as they are."""

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from tests.sim.terrain.readers.files import HILL, ground
from walking_console.sim.terrain.generators import GroundError


def test_the_first_row_of_an_array_is_the_least_y(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", HILL)
    np.testing.assert_array_equal(ground(tmp_path / "h.npy", cell=0.5).heights, HILL)


def test_exact_heights_win_over_those_for_readers(tmp_path: Path) -> None:
    np.savez(tmp_path / "h.npz", heights=HILL.astype(np.float32), heights_exact=HILL, cell=0.5)
    made = ground(tmp_path / "h.npz")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.5


@pytest.mark.parametrize(
    "kind", [">f8", "<f4", "<f2", ">i2", "u1", "i8", "g"], ids=lambda kind: f"of {kind}"
)
def test_numbers_of_any_type_and_order_are_heights(tmp_path: Path, kind: str) -> None:
    heights = (HILL * 20.0).astype(kind)
    np.save(tmp_path / "h.npy", np.asfortranarray(heights))
    np.testing.assert_array_equal(ground(tmp_path / "h.npy", cell=0.5).heights, heights)


@pytest.mark.parametrize("axis", [0, 2])
def test_an_axis_of_one_place_is_none(tmp_path: Path, axis: int) -> None:
    np.save(tmp_path / "h.npy", np.expand_dims(HILL, axis))
    np.testing.assert_array_equal(ground(tmp_path / "h.npy", cell=0.5).heights, HILL)


@pytest.mark.parametrize(
    ("array", "says"),
    [
        (HILL.astype(complex), "numbers wanted, got complex128"),
        (np.array([[1, None], [2, 3]], dtype=object), "numbers wanted, got object"),
        (np.array([["a", "b"], ["c", "d"]]), "numbers wanted, got <U1"),
        (HILL > 0.1, "numbers wanted, got bool"),
        (np.zeros((3, 3), [("a", "f4")]), "numbers wanted"),
        (np.stack([HILL] * 3), r"got shape \(3, 12, 16\)"),
        (HILL.ravel(), r"got shape \(192,\)"),
    ],
)
def test_what_is_no_grid_of_numbers_is_refused_by_what_it_is(
    tmp_path: Path, array: np.ndarray, says: str
) -> None:
    np.save(tmp_path / "h.npy", array, allow_pickle=True)
    with pytest.raises(GroundError, match=says):
        ground(tmp_path / "h.npy")


@pytest.mark.parametrize("name", ["arr_0", "z", "elevation", "my_hill"])
def test_the_only_grid_of_an_archive_is_its_heights_whatever_its_name(
    tmp_path: Path, name: str
) -> None:
    np.savez_compressed(tmp_path / "h.npz", **{name: HILL, "resolution": 0.5, "when": "today"})
    made = ground(tmp_path / "h.npz")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.5


@pytest.mark.parametrize("indexing", ["xy", "ij"])
def test_places_of_every_cell_are_those_of_columns_and_rows(
    tmp_path: Path, indexing: Literal["xy", "ij"]
) -> None:
    x, y = np.meshgrid(np.arange(16) * 0.25, np.arange(12) * 0.25, indexing=indexing)
    heights = HILL if indexing == "xy" else HILL.T
    np.savez(tmp_path / "h.npz", X=x, Y=y, Z=heights)
    made = ground(tmp_path / "h.npz")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.25


@pytest.mark.parametrize("name", ["h.npy", "h.npz"])
def test_three_columns_of_many_rows_are_points(tmp_path: Path, name: str) -> None:
    y, x = np.mgrid[:12, :16] * 0.25
    points = np.stack([x.ravel(), y.ravel(), HILL.ravel()], axis=1)[::-1]
    save = np.save if name.endswith("npy") else np.savez
    save(tmp_path / name, points)
    made = ground(tmp_path / name)
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.25 and made.note.startswith("point list")


@pytest.mark.parametrize("down", [False, True])
def test_places_of_columns_and_rows_give_the_cell_and_the_way_up(
    tmp_path: Path, down: bool
) -> None:
    y = np.arange(12) * 0.25
    rows = slice(None, None, -1 if down else 1)
    np.savez(tmp_path / "h.npz", x=np.arange(16) * 0.25, y=y[rows], z=HILL[rows])
    made = ground(tmp_path / "h.npz")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.25


def test_an_archive_of_degrees_says_the_cell_in_metres(tmp_path: Path) -> None:
    step = dict(dx=1 / 1200, dy=1 / 1200, xmin=-84.4, ymin=36.6)
    np.savez(tmp_path / "h.npz", elevation=HILL, **step)
    with pytest.raises(GroundError, match=r"at latitude 36.6 that is cell = \[74.39, 92.66\]"):
        ground(tmp_path / "h.npz")


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"a": HILL, "b": HILL}, "several grids in it and no 'heights': a, b; name one of them so"),
        ({"a": np.arange(3)}, "no 'heights' in it, only a"),
        ({"z": HILL, "x": np.array([0.0, 1.0, 5.0]), "y": np.arange(12)}, "not evenly spaced"),
    ],
)
def test_an_archive_without_one_grid_names_what_it_has(
    tmp_path: Path, arrays: dict[str, np.ndarray], says: str
) -> None:
    np.savez(tmp_path / "h.npz", **arrays)
    with pytest.raises(GroundError, match=says):
        ground(tmp_path / "h.npz")
