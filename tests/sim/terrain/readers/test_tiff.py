"""TIFF and GeoTIFF: any number type, and what the tags say."""

from pathlib import Path

import numpy as np
import pytest
import tifffile

from tests.sim.terrain.readers.files import FIXTURES, HILL, ground, of_fixture
from walking_console.sim.terrain.generators import GroundError


def test_a_geotiff_brings_its_pixel_size_and_its_nodata() -> None:
    made = of_fixture("geotiff-float32")
    values = tifffile.imread(FIXTURES / "geotiff-float32" / "ground.tif").astype(np.float64)
    assert made.cell == pytest.approx(0.05)
    holes = values[::-1] == -9999.0
    assert holes.any() and (np.isnan(made.heights) == holes).all()
    np.testing.assert_array_equal(made.heights[~holes], values[::-1][~holes])
    with pytest.raises(GroundError, match=r"has no height \(NODATA -9999; \d+ such\); set nan"):
        of_fixture("geotiff-float32", 'terrain={kind="file", file="ground.tif"}')


@pytest.mark.parametrize("kind", ["u1", "i2", "u2", "i4", "f4", "f8"])
@pytest.mark.parametrize("compression", [None, "zlib"])
def test_tiffs_of_any_number_type_load_north_up(
    tmp_path: Path, kind: str, compression: str | None
) -> None:
    values = (np.arange(192).reshape(12, 16) % 9).astype(kind)
    tifffile.imwrite(tmp_path / "h.tif", values, compression=compression)
    made = ground(tmp_path / "h.tif", cell=0.2)
    np.testing.assert_array_equal(made.heights, values[::-1].astype(np.float64))


def geotiff(path: Path, scale: tuple[float, float], model: int) -> None:
    keys = (1, 1, 0, 1, 1024, 0, 1, model)
    tifffile.imwrite(path, HILL[::-1].astype(np.float32), extratags=[
        (33550, 12, 3, (*scale, 0.0), False), (34735, 3, len(keys), keys, False),
    ])  # fmt: skip


def test_pixels_in_degrees_are_answered_and_a_cell_in_metres_is_taken(tmp_path: Path) -> None:
    geotiff(tmp_path / "h.tif", (0.000278, 0.000278), 2)
    with pytest.raises(
        GroundError, match="degrees of longitude and latitude .* set cell in metres"
    ):
        ground(tmp_path / "h.tif")
    assert ground(tmp_path / "h.tif", cell=0.2).cell == 0.2


def test_unequal_pixels_are_interpolated_to_square_ones_and_that_is_told(tmp_path: Path) -> None:
    geotiff(tmp_path / "h.tif", (0.2, 0.4), 1)
    made = ground(tmp_path / "h.tif")
    assert made.cell == 0.2 and made.heights.shape == (24, 16)
    assert "interpolated to square cells of 0.2 m" in made.note
    assert made.heights[:, 3] == pytest.approx(np.interp(
        np.arange(24) * 0.2 + 0.1, np.arange(12) * 0.4 + 0.2, HILL[:, 3]), abs=1e-6)  # fmt: skip


def test_a_model_of_a_mountain_is_walked_at_its_true_size_around_the_start(tmp_path: Path) -> None:
    mountain = 437.0 + np.add.outer(np.arange(40) * 3.0, np.arange(40) * 1.5)
    tifffile.imwrite(
        tmp_path / "h.tif", mountain[::-1].astype(np.float32),
        extratags=[(33550, 12, 3, (30.0, 30.0, 0.0), False)],
    )  # fmt: skip
    made = ground(tmp_path / "h.tif")
    assert made.heights.shape == (1000, 1000) and made.cell == 0.05
    slope = (made.height_at(0.0, 5.0) - made.height_at(0.0, -5.0)) / 10.0
    assert slope == pytest.approx(0.1, abs=0.01)
    assert "40 x 40 of 30 m" in made.note and "around the start" in made.note
