"""Pictures are grounds: of any mode whose channels are equal, north up, every bit kept."""

from pathlib import Path

import numpy as np
import png
import pytest
from PIL import Image

from tests.sim.terrain.readers.files import ground, of_fixture
from walking_console.sim.terrain.generators import GroundError


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "LA", "P"])
def test_a_grey_picture_of_any_mode_is_the_ground_of_the_grey_one(mode: str) -> None:
    grey = of_fixture("colour-mode-pictures")
    same = of_fixture("colour-mode-pictures", f"terrain.file={mode}.png")
    np.testing.assert_array_equal(same.heights, grey.heights)
    assert same.cell == grey.cell and same.origin == grey.origin


def test_the_top_of_a_picture_is_north() -> None:
    made = of_fixture("picture-upside-down")
    assert made.height_at(2.7, 1.7) > 0.1 > made.height_at(2.7, -1.7)


@pytest.mark.parametrize("planes", [1, 2, 3, 4])
def test_pictures_of_16_bits_keep_them_all(tmp_path: Path, planes: int) -> None:
    levels = (np.arange(192).reshape(12, 16) * 257 + 3).astype(np.uint16)
    rows = np.repeat(levels[..., None], planes, axis=-1)
    if planes in (2, 4):
        rows[..., -1] = 65535
    writer = png.Writer(16, 12, bitdepth=16, greyscale=planes < 3, alpha=planes in (2, 4))
    with (tmp_path / "deep.png").open("wb") as file:
        writer.write(file, rows.reshape(12, -1).tolist())
    made = ground(tmp_path / "deep.png", cell=0.2)
    np.testing.assert_array_equal(made.heights, levels[::-1] / 65535.0)


def test_pixels_one_sees_through_are_holes(tmp_path: Path) -> None:
    picture = Image.new("RGBA", (16, 12), (51, 51, 51, 255))
    picture.putpixel((3, 0), (0, 0, 0, 0))
    picture.save(tmp_path / "clear.png")
    made = ground(tmp_path / "clear.png", cell=0.2, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[11, 3]]


@pytest.mark.parametrize("interlace", [False, True])
@pytest.mark.parametrize("bits", [1, 2, 4, 8, 16])
def test_grey_of_any_depth_is_a_part_of_white(tmp_path: Path, bits: int, interlace: bool) -> None:
    white = 2**bits - 1
    levels = np.arange(192).reshape(12, 16) * 331 % (white + 1)
    writer = png.Writer(16, 12, bitdepth=bits, greyscale=True, interlace=interlace)
    with (tmp_path / "h.png").open("wb") as file:
        writer.write(file, levels.tolist())
    made = ground(tmp_path / "h.png", cell=0.2)
    np.testing.assert_allclose(made.heights, levels[::-1] / white, atol=1e-12)


@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_a_palette_of_greys_is_the_greys(tmp_path: Path, bits: int) -> None:
    greys = [(255 * k // (2**bits - 1),) * 3 for k in range(2**bits)]
    places = np.arange(192).reshape(12, 16) % 2**bits
    with (tmp_path / "h.png").open("wb") as file:
        png.Writer(16, 12, bitdepth=bits, palette=greys).write(file, places.tolist())
    expected = np.array([grey[0] for grey in greys])[places] / 255.0
    np.testing.assert_array_equal(ground(tmp_path / "h.png", cell=0.2).heights, expected[::-1])


@pytest.mark.parametrize("bits", [1, 2, 8, 16])
def test_the_level_that_one_sees_through_is_a_hole(tmp_path: Path, bits: int) -> None:
    levels = np.ones((12, 16), dtype=int)
    levels[0, 3] = 0
    writer = png.Writer(16, 12, bitdepth=bits, greyscale=True, transparent=0)
    with (tmp_path / "h.png").open("wb") as file:
        writer.write(file, levels.tolist())
    made = ground(tmp_path / "h.png", cell=0.2, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[11, 3]]


@pytest.mark.parametrize("suffix", ["jpg", "bmp", "pgm", "ppm", "pnm"])
def test_other_grey_pictures_are_read_as_well(tmp_path: Path, suffix: str) -> None:
    Image.new("L", (16, 12), 51).save(tmp_path / f"h.{suffix}")
    assert ground(tmp_path / f"h.{suffix}", cell=0.2).heights == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize("suffix", ["png", "jpg", "bmp", "pgm"])
def test_what_is_no_picture_is_refused_by_what_it_begins_with(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"h.{suffix}").write_bytes(b"GIF89a of another kind")
    with pytest.raises(GroundError, match="is wanted; .* begins with b'GIF89a o'") as refused:
        ground(tmp_path / f"h.{suffix}")
    assert str(tmp_path) not in str(refused.value)


def test_colours_that_differ_by_one_level_of_16_bits_are_told_apart(tmp_path: Path) -> None:
    levels = np.full((12, 48), 12000)
    levels[0, 2] = 12001
    with (tmp_path / "h.png").open("wb") as file:
        png.Writer(16, 12, greyscale=False, bitdepth=16).write(file, levels.tolist())
    with pytest.raises(GroundError, match=r"green 0\.18311, blue 0\.18312 \(1 such\)"):
        ground(tmp_path / "h.png")
