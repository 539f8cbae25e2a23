"""Ground from files: what loads, and what is refused."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image

from tests.sim.terrain.grounds import TITAN, Canary, _matplotlib_sample, from_file, ground, hills
from walking_console.planner.terrain.traversability import classify
from walking_console.sim.terrain.ground import GroundError


def test_the_elevation_model_is_matplotlibs_at_walking_scale() -> None:
    """H has no such ground; the contract says 344 x 403 heights, 13 degrees median and 36 at most
    in nature.
    """
    sample = np.load(_matplotlib_sample())
    elevation = sample["elevation"][::-1].astype(float)
    made = ground(
        "dem", scale=1000.0, relief=1000.0, offset=[10.0, 10.0], span=(0.0, 15.0, -5.0, 5.0)
    )
    east, north = 0.074266, 0.092667
    column, row = 200, 120
    here = made.height_at(column * east - 10.0, row * north - 10.0) - made.height_at(
        150 * east - 10.0, row * north - 10.0
    )
    assert here == pytest.approx((elevation[row, column] - elevation[row, 150]) / 1000.0, abs=0.02)
    slope = np.degrees(np.arctan(np.hypot(*np.gradient(elevation, 92.667, 74.266))))
    assert np.median(slope) == pytest.approx(13.0, abs=0.5) and slope.max() == pytest.approx(
        36.0, abs=0.5
    )


def test_the_elevation_model_has_hills_to_walk_and_no_walls() -> None:
    made = ground("dem", span=(0.0, 16.0, -3.0, 3.0))
    assert abs(made.height_at(0.0, 0.0)) < 0.005
    assert np.ptp([made.height_at(x, 0.0) for x in np.arange(0.0, 16.0, 0.1)]) > 0.15
    assert classify(made.heights, made.cell, TITAN).mean() < 0.01


def test_the_elevation_model_goes_on_mirrored_beyond_its_edges() -> None:
    made = ground("dem", offset=[1.0, 16.0], span=4.0)
    for depth in (0.25, 1.0, 2.0):
        assert made.height_at(-1.0 - depth, 0.5) == pytest.approx(
            made.height_at(-1.0 + depth, 0.5), abs=0.02
        )


def test_the_elevation_model_can_be_turned() -> None:
    east, north = ground("dem", span=3.0), ground("dem", span=3.0, heading_deg=90.0)
    askew = ground("dem", span=3.0, heading_deg=30.0)
    assert north.height_at(0.0, -2.0) == pytest.approx(east.height_at(2.0, 0.0), abs=0.01)
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    assert askew.height_at(c * 2.0, -s * 2.0) == pytest.approx(east.height_at(2.0, 0.0), abs=0.01)


def test_an_array_is_the_ground_cell_by_cell(tmp_path: Path) -> None:
    heights = hills()
    np.save(tmp_path / "h.npy", heights)
    made = from_file(tmp_path / "h.npy", cell=0.05)
    assert made.cell == 0.05 and np.array_equal(made.heights, heights)
    assert made.origin == pytest.approx((-1.5, -1.0))
    assert (
        made.height_at(-1.49, -0.99) == heights[0, 0]
        and made.height_at(1.49, -0.99) == heights[0, 59]
    )


@pytest.mark.parametrize("dtype", ["f2", "f4", ">f8", "i2", "u1"])
def test_arrays_of_any_kind_of_number_load(tmp_path: Path, dtype: str) -> None:
    np.save(tmp_path / "h.npy", np.asfortranarray(np.ones((4, 5))).astype(dtype))
    assert from_file(tmp_path / "h.npy").level == 1.0


def test_smooth_files_are_resampled_to_25_millimetres(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.outer(np.ones(30), np.arange(30) * 0.01))
    made = from_file(tmp_path / "h.npy", cell=0.1, smooth=True)
    assert made.cell == pytest.approx(0.025) and made.heights.shape == (120, 120)
    assert np.diff(made.heights[5, 2:-2]) == pytest.approx(0.0025)


@pytest.mark.parametrize("mask", [np.savez, np.savez_compressed])
def test_a_runs_own_terrain_loads_with_its_cell_and_origin(tmp_path: Path, mask: Any) -> None:
    made = ground("holes")
    forbidden = np.isnan(made.heights)
    mask(
        tmp_path / "terrain.npz",
        heights=made.heights.astype(np.float32),
        cell=made.cell,
        origin=made.origin,
        forbidden=forbidden,
        believed_heights=made.heights.astype(np.float32),
        believed_forbidden=forbidden,
    )
    again = from_file(tmp_path / "terrain.npz", nan="hole")
    assert again.cell == made.cell and again.origin == made.origin
    np.testing.assert_array_equal(again.heights, made.heights)
    with pytest.raises(GroundError, match=r"cell \[0, \d+\] is NaN"):
        from_file(tmp_path / "terrain.npz")


@pytest.mark.parametrize(("kind", "white"), [(np.uint8, 255), (np.uint16, 65535)])
def test_grey_pictures_are_heights_up_to_white(tmp_path: Path, kind: Any, white: int) -> None:
    levels = np.zeros((20, 30), dtype=kind)
    levels[3, 7] = white
    Image.fromarray(levels).save(tmp_path / "h.png")
    made = from_file(tmp_path / "h.png", cell=0.1, scale=0.25)
    assert made.heights[20 - 1 - 3, 7] == 0.25 and np.count_nonzero(made.heights) == 1  # north up


@given(
    heights=arrays.arrays(
        np.float64,
        arrays.array_shapes(min_dims=0, max_dims=3, max_side=5),
        elements=st.floats(width=64),
    )
)
@settings(max_examples=80, deadline=None)
def test_an_array_either_is_ground_or_is_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, heights: Any
) -> None:
    path = tmp_path_factory.mktemp("h") / "h.npy"
    np.save(path, heights)
    try:
        made = from_file(path, nan="hole", origin=[-0.1, -0.1])
    except GroundError as refusal:
        assert "\n" not in str(refusal)
    else:
        grid = heights.squeeze() if heights.ndim > 2 else heights
        assert min(grid.shape) >= 2 and grid.ndim == 2
        assert not np.isinf(made.heights).any() and np.nanmax(abs(made.heights)) <= 100.0


@pytest.mark.parametrize(
    ("heights", "says"),
    [
        (np.zeros((1, 1)), "at least 2 x 2"),
        (np.zeros(9), "at least 2 x 2"),
        (np.zeros((2, 2, 2)), "must be"),
        (np.zeros((0, 4)), "must be"),
        (np.zeros((8193, 8192), dtype=np.int8), "at most 67108864 cells"),
        (np.array([[0.0, 0.0], [np.inf, 0.0]]), r"cell \[1, 0\] is infinite"),
        (np.array([[0.0, np.nan], [0.0, 0.0]]), r"cell \[0, 1\] is NaN"),
        (np.array([[0.0, 250.0], [0.0, 0.0]]), r"cell \[0, 1\] is more than 100 m"),
        (np.array([["a", "b"], ["c", "d"]]), "numbers wanted"),
        (np.zeros((3, 3), dtype=complex), "numbers wanted"),
        (np.zeros((3, 3), dtype=bool), "numbers wanted"),
    ],
)
def test_arrays_that_are_no_ground_are_refused_with_the_cell(
    tmp_path: Path, heights: Any, says: str
) -> None:
    np.save(tmp_path / "h.npy", heights)
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / "h.npy")


def test_infinite_heights_are_refused_even_where_nan_is_a_hole(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.array([[0.0, -np.inf], [np.nan, 0.0]]))
    with pytest.raises(GroundError, match=r"\[0, 1\] is infinite"):
        from_file(tmp_path / "h.npy", nan="hole")


@pytest.mark.parametrize("save", ["npy", "npz"])
def test_pickles_are_not_opened(tmp_path: Path, save: str) -> None:
    evil = np.array([[Canary(), 1], [2, 3]], dtype=object)
    path = tmp_path / f"h.{save}"
    np.save(path, evil, allow_pickle=True) if save == "npy" else np.savez(path, heights=evil)
    with pytest.raises(GroundError, match="numbers wanted"):
        from_file(path)
    path.write_bytes(__import__("pickle").dumps(Canary()))
    with pytest.raises(GroundError):
        from_file(path)
    assert not Canary.sang


def test_a_header_that_promises_more_than_the_file_holds_is_refused_before_reading(
    tmp_path: Path,
) -> None:
    whole = io.BytesIO()
    np.save(whole, np.zeros((500, 500)))
    (tmp_path / "h.npy").write_bytes(whole.getvalue()[:1000])
    with pytest.raises(GroundError, match="ends before"):
        from_file(tmp_path / "h.npy")


def test_a_zip_bomb_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "h.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("heights.npy", bytes(600_000_000))
    assert path.stat().st_size < 800_000
    with pytest.raises(GroundError, match="unpacks to 600000000 bytes"):
        from_file(path)


@pytest.mark.parametrize(
    ("members", "says"),
    [
        ({"other": np.zeros(3)}, "no 'heights' in it, only other"),
        ({"heights": np.zeros((3, 3)), "cell": -7.0}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "cell": np.nan}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "cell": [0.1, 0.2]}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "origin": [0.0, np.inf]}, "origin must be"),
        ({"heights": np.zeros((3, 3)), **{f"m{i}": 0 for i in range(20)}}, "members"),
    ],
)
def test_archives_that_are_no_ground_are_refused(
    tmp_path: Path, members: dict[str, Any], says: str
) -> None:
    np.savez(tmp_path / "h.npz", **members)
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / "h.npz")


def test_coloured_pictures_are_refused_with_the_pixel(tmp_path: Path) -> None:
    picture = Image.new("RGB", (8, 8))
    picture.putpixel((5, 2), (255, 0, 0))
    picture.save(tmp_path / "h.png")
    with pytest.raises(GroundError, match=r"coloured: pixel \[2, 5\] is red 1.00000, green 0."):
        from_file(tmp_path / "h.png")


def test_a_picture_too_large_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    whole = io.BytesIO()
    Image.new("L", (8193, 8192)).save(whole, "PNG")
    (tmp_path / "h.png").write_bytes(whole.getvalue()[:60])  # the header alone
    with pytest.raises(GroundError, match="8193 x 8192 cells"):
        from_file(tmp_path / "h.png")


@pytest.mark.parametrize("suffix", ["npy", "npz", "png"])
@given(junk=st.binary(max_size=300))
@settings(max_examples=25, deadline=None)
def test_junk_is_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, junk: bytes
) -> None:
    head = {"npy": b"\x93NUMPY\x01\x00", "npz": b"PK\x03\x04", "png": b"\x89PNG\r\n\x1a\n"}[suffix]
    path = tmp_path_factory.mktemp("junk") / f"h.{suffix}"
    for content in (junk, head + junk):
        path.write_bytes(content)
        with pytest.raises(GroundError) as refusal:
            from_file(path)
        assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("suffix", ["npy", "npz", "png"])
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_flipped_bytes_never_raise_anything_else(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("flip") / f"h.{suffix}"
    heights = np.zeros((6, 6), dtype=np.uint8)
    if suffix == "png":
        Image.fromarray(heights).save(path)
    else:
        np.save(path, heights) if suffix == "npy" else np.savez_compressed(
            path, heights=heights, cell=0.05, origin=[-0.15, -0.15]
        )
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(
        bytes(
            content[: data.draw(st.integers(0, len(content)))]
            if data.draw(st.booleans())
            else content
        )
    )
    try:
        from_file(path)
    except GroundError as refusal:
        assert "\n" not in str(refusal)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("none.npy", "does not exist"),
        ("none.doc", r"must end in one of: \.asc, .*\.npy, \.npz, \.obj"),
    ],
)
def test_missing_and_unknown_files_are_refused_in_words(
    tmp_path: Path, name: str, says: str
) -> None:
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / name)


def test_a_start_outside_the_file_is_refused_in_words(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.zeros((4, 4)))
    with pytest.raises(GroundError, match="outside the map"):
        from_file(tmp_path / "h.npy", origin=[5.0, 5.0])
