"""Pictures are grounds: of any mode whose channels are equal, north up, every bit kept."""

from pathlib import Path

import numpy as np
import png
import pytest
from PIL import Image

from tests.sim.terrain.readers.files import ground, of_fixture


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
