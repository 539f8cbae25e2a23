"""The picture on the ground: even height colours, red forbidden cells, and a PNG that keeps it."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from walking_console.web.scene.terrain_texture import (
    COLOURS,
    CONTOUR,
    FORBIDDEN_EDGE,
    contours,
    height_colours,
    hill_shade,
    mark_forbidden,
    oklch,
    png,
)


def slope(rise: float) -> np.ndarray:
    """Ground that rises so many metres a metre along x; cells of 1 cm."""
    return np.repeat(np.arange(60)[None] * 0.01 * rise, 20, axis=0)


def test_height_colours_get_lighter_upwards_in_even_steps() -> None:
    light = COLOURS @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(light) > 0)


def test_full_lightness_without_chroma_is_white() -> None:
    white = oklch(np.array([1.0]), np.array([0.0]), np.array([0.0]))[0]
    assert white == pytest.approx([1.0, 1.0, 1.0], abs=1e-4)


def test_small_bumps_do_not_get_the_whole_ramp() -> None:
    small = height_colours(np.array([0.0, 0.05]), 0.0, 0.05)
    large = height_colours(np.array([0.0, 1.0]), 0.0, 1.0)
    assert np.abs(small[1] - small[0]).max() < 0.3 * np.abs(large[1] - large[0]).max()


def test_level_ground_has_one_colour_and_full_light() -> None:
    heights = np.zeros((6, 6))
    assert np.ptp(height_colours(heights, 0.0, 0.0), axis=(0, 1)) == pytest.approx([0.0] * 3)
    assert hill_shade(heights, 0.05, stepped=False) == pytest.approx(np.ones((6, 6)))


def test_slopes_towards_the_sun_are_brighter_than_slopes_away_from_it() -> None:
    towards = hill_shade(slope(0.5), 0.01, stepped=False)
    away = hill_shade(slope(-0.5), 0.01, stepped=False)
    assert towards.mean() > 1.0 > away.mean()


def test_contours_run_where_the_height_is_a_multiple_and_nowhere_on_level_ground() -> None:
    rising = slope(0.5)
    lines = contours(rising, 0.01)[10]
    on = np.abs(rising[10] / CONTOUR - np.rint(rising[10] / CONTOUR)) < 1e-6
    assert lines[on].min() > lines[~on].max() - 1e-9
    assert contours(np.zeros((6, 6)), 0.01).max() == 0.0


def test_forbidden_cells_turn_red_with_a_dark_edge() -> None:
    picture = np.full((8, 8, 3), 0.5)
    forbidden = np.zeros((8, 8), bool)
    forbidden[2:6, 2:5] = True
    mark_forbidden(picture, forbidden, scale=2)
    assert picture[3, 3][0] > 1.6 * picture[3, 3][1]
    assert picture[2, 2].mean() < picture[3, 3].mean()
    assert picture[2, 2] == pytest.approx(0.45 * picture[3, 3] + 0.55 * FORBIDDEN_EDGE)
    assert picture[~forbidden] == pytest.approx(0.5)


def test_a_picture_survives_its_png() -> None:
    picture = np.random.default_rng(1).integers(0, 256, (13, 7, 3)) / 255
    kept = np.asarray(Image.open(BytesIO(png(picture))))
    assert np.array_equal(kept, np.rint(picture * 255).astype(np.uint8))
