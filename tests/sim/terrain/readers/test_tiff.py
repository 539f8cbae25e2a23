"""TIFF and GeoTIFF: any number type, and what the tags say."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image

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
        GroundError, match=r"degrees of longitude and latitude .* cell = \[30.91, 30.91\]"
    ):
        ground(tmp_path / "h.tif")
    assert ground(tmp_path / "h.tif", cell=0.2).cell == 0.2


def test_degrees_at_no_latitude_on_earth_are_not_turned_into_metres(tmp_path: Path) -> None:
    keys = (1, 1, 0, 1, 1024, 0, 1, 2)
    tie = (0.0, 0.0, 0.0, 641_000.0, 5_812_000.0, 0.0)
    tifffile.imwrite(tmp_path / "h.tif", HILL[::-1].astype(np.float32), extratags=[
        (33550, 12, 3, (3e-4, 3e-4, 0.0), False), (33922, 12, 6, tie, False),
        (34735, 3, len(keys), keys, False),
    ])  # fmt: skip
    with pytest.raises(GroundError, match="set cell in metres$"):
        ground(tmp_path / "h.tif")


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


PLACED = (33550, 12, 3, (0.2, 0.2, 0.0), False)


@pytest.mark.parametrize("layout", [{"tile": (16, 16)}, {"rowsperstrip": 5}, {"bigtiff": True}])
@pytest.mark.parametrize("order", ["<", ">"])
def test_tiles_strips_and_byte_orders_make_no_difference(
    tmp_path: Path, layout: dict[str, Any], order: str
) -> None:
    values = HILL.astype(np.float32)
    tifffile.imwrite(tmp_path / "h.tif", values, byteorder=order, extratags=[PLACED], **layout)
    made = ground(tmp_path / "h.tif")
    np.testing.assert_array_equal(made.heights, values[::-1].astype(np.float64))
    assert made.cell == 0.2


@pytest.mark.parametrize("packing", ["tiff_lzw", "tiff_adobe_deflate", "packbits"])
@pytest.mark.parametrize("kind", ["u1", "u2", "i4", "f4"])
def test_packed_pictures_of_other_programs_load(tmp_path: Path, kind: str, packing: str) -> None:
    values = (HILL * 20.0).astype(kind)
    Image.fromarray(values).save(tmp_path / "h.tif", compression=packing)
    made = ground(tmp_path / "h.tif", cell=0.2)
    np.testing.assert_array_equal(made.heights, values[::-1].astype(np.float64))


@pytest.mark.parametrize("said", ["-9999", "-9999.0 ", "-9.999e3", "-9999,0"])
def test_nodata_is_understood_however_it_is_written(tmp_path: Path, said: str) -> None:
    values = HILL.astype(np.float32)
    values[0, 3] = -9999.0
    tags = [PLACED, (42113, 2, len(said) + 1, said, False)]
    tifffile.imwrite(tmp_path / "h.tif", values, extratags=tags)
    made = ground(tmp_path / "h.tif", nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[11, 3]]


def test_rows_that_run_north_are_not_turned_over(tmp_path: Path) -> None:
    matrix = (0.2, 0, 0, 5e5, 0, 0.2, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)
    tifffile.imwrite(tmp_path / "h.tif", HILL, extratags=[(34264, 12, 16, matrix, False)])
    made = ground(tmp_path / "h.tif")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == pytest.approx(0.2)


def test_heights_packed_as_whole_numbers_are_unpacked_as_gdal_says(tmp_path: Path) -> None:
    item = '<Item name="{}" sample="{}" role="{}">{}</Item>'
    said = "".join(
        item.format(*words)
        for words in (
            ("OFFSET", 1, "offset", 7),
            ("OFFSET", 0, "offset", 0.5),
            ("SCALE", 0, "scale", "1e-3"),
        )
    )
    metadata = f"<GDALMetadata>{said}</GDALMetadata>"
    tags = [PLACED, (42112, 2, len(metadata) + 1, metadata, False), (42113, 2, 7, "-32768", False)]
    packed = np.round(HILL[::-1] * 1000.0).astype(np.int16)
    packed[0, 3] = -32768
    tifffile.imwrite(tmp_path / "h.tif", packed, extratags=tags)
    made = ground(tmp_path / "h.tif", nan="hole")
    wanted = np.round(HILL, 3) + 0.5
    wanted[11, 3] = np.nan
    np.testing.assert_allclose(made.heights, wanted)


def test_columns_that_run_west_are_turned_over(tmp_path: Path) -> None:
    matrix = (-0.2, 0, 0, 5e5, 0, 0.2, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)
    tifffile.imwrite(tmp_path / "h.tif", HILL, extratags=[(34264, 12, 16, matrix, False)])
    np.testing.assert_array_equal(ground(tmp_path / "h.tif").heights, HILL[:, ::-1])


def test_rows_askew_on_the_map_are_refused_with_their_angle(tmp_path: Path) -> None:
    c, s = 0.2 * math.cos(0.5), 0.2 * math.sin(0.5)
    matrix = (c, s, 0, 5e5, s, -c, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)
    tifffile.imwrite(tmp_path / "h.tif", HILL, extratags=[(34264, 12, 16, matrix, False)])
    with pytest.raises(GroundError, match="rows are turned 28.6 degrees .* turn it north up"):
        ground(tmp_path / "h.tif")


def test_a_palette_of_greys_is_the_greys(tmp_path: Path) -> None:
    greys = np.tile((255 - np.arange(256)) * 257, (3, 1)).astype(np.uint16)
    levels = np.arange(192, dtype=np.uint8).reshape(12, 16)
    tifffile.imwrite(tmp_path / "h.tif", levels, photometric="palette", colormap=greys)
    made = ground(tmp_path / "h.tif", scale=0.01)
    np.testing.assert_allclose(made.heights, (255.0 - levels[::-1]) * 0.01)


def test_a_file_that_ends_too_early_says_so(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    tifffile.imwrite(tmp_path / "h.tif", HILL)
    (tmp_path / "h.tif").write_bytes((tmp_path / "h.tif").read_bytes()[:-500])
    with pytest.raises(GroundError, match="its pixels cannot be read: failed to read 1536 bytes"):
        ground(tmp_path / "h.tif")
    assert capfd.readouterr() == ("", "")


def test_pixels_in_feet_are_brought_to_metres(tmp_path: Path) -> None:
    keys = (1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9002)
    feet = [(33550, 12, 3, (1.0, 1.0, 0.0), False), (34735, 3, len(keys), keys, False)]
    tifffile.imwrite(tmp_path / "h.tif", HILL, extratags=feet)
    assert ground(tmp_path / "h.tif").cell == pytest.approx(0.3048)


def test_small_pixels_at_a_longitude_and_latitude_are_degrees(tmp_path: Path) -> None:
    place = [(33550, 12, 3, (1 / 3600, 1 / 3600, 0.0), False),
             (33922, 12, 6, (0.0, 0.0, 0.0, 11.0, 60.0, 0.0), False)]  # fmt: skip
    tifffile.imwrite(tmp_path / "h.tif", HILL, extratags=place)
    with pytest.raises(GroundError, match=r"at latitude 60 that is cell = \[15.44, 30.89\]"):
        ground(tmp_path / "h.tif")


def test_a_channel_one_sees_through_makes_holes_and_other_channels_are_refused(
    tmp_path: Path,
) -> None:
    grey = np.full((12, 16, 2), 255, np.uint8)
    grey[0, 3, 1] = 0
    layout = {"photometric": "minisblack", "planarconfig": "contig"}
    tifffile.imwrite(tmp_path / "h.tif", grey, extrasamples=["unassalpha"], **layout)
    made = ground(tmp_path / "h.tif", cell=0.2, scale=0.01, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[11, 3]]
    tifffile.imwrite(tmp_path / "five.tif", np.zeros((12, 16, 5), np.float32), **layout)
    with pytest.raises(GroundError, match="one channel of heights is wanted, got 5"):
        ground(tmp_path / "five.tif")
