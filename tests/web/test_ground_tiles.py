"""The ground as tiles: exact where it is stepped, without cracks where it is smooth, and sent again
only where it changed.
"""

import json
import struct

import numpy as np
import pytest

from walking_console.web.scene.gltf import Part, glb, linear
from walking_console.web.scene.terrain import COLOURS, QUADS_MAX, Ground, oklch, png


def contents(data: bytes) -> tuple[dict, bytes]:
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def triangles(data: bytes, primitive: int = 0) -> np.ndarray:
    """Corners of a primitive's triangles, (n, 3, 3)."""
    scene, binary = contents(data)
    part = scene["meshes"][0]["primitives"][primitive]

    def read(index: int, kind: type, width: int) -> np.ndarray:
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        raw = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        return np.frombuffer(raw, kind).reshape(-1, width)

    points = read(part["attributes"]["POSITION"], np.float32, 3)
    return points[read(part["indices"], np.uint32, 3)]


def area_from_above(corners: np.ndarray) -> float:
    a, b = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    return float(np.sum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])) / 2)


def hills(rows: int = 90, columns: int = 70) -> np.ndarray:
    y, x = np.mgrid[:rows, :columns] * 0.05
    return 0.2 * np.sin(1.7 * x) * np.cos(1.3 * y)


def nothing_forbidden(heights: np.ndarray) -> np.ndarray:
    return np.zeros(heights.shape, bool)


def test_glb_colours_are_linear_light() -> None:
    assert linear(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 0.21404, 1.0], abs=1e-5)


def test_an_empty_file_is_still_a_file() -> None:
    scene, _ = contents(glb([Part(np.zeros((0, 3)), np.zeros((0, 3), int))]))
    assert "meshes" not in scene


def test_height_colours_get_lighter_upwards_in_even_steps() -> None:
    light = COLOURS @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(light) > 0)
    assert oklch(np.array([1.0]), np.array([0.0]), np.array([0.0]))[0] == pytest.approx(
        [1.0, 1.0, 1.0], abs=1e-4
    )


def test_stepped_ground_is_drawn_at_exactly_its_own_heights() -> None:
    heights = np.repeat([0.0, 0.12, 0.24, 0.36], 20)[None, :].repeat(40, axis=0)
    ground = Ground(heights, nothing_forbidden(heights), 0.025, (0.0, 0.0))
    assert ground.stepped
    drawn = np.concatenate([triangles(ground.draw(tile)) for tile in ground.tiles()])
    for corners in drawn:
        middle = corners.mean(axis=0)
        cell = heights[int(middle[1] / 0.025), int(middle[0] / 0.025)]
        assert corners[:, 2] == pytest.approx(cell)
    assert area_from_above(drawn) == pytest.approx(40 * 80 * 0.025**2)


def test_holes_are_left_open() -> None:
    rng = np.random.default_rng(5)
    heights = np.where(rng.random((60, 60)) < 0.3, np.nan, 0.0)
    ground = Ground(heights, np.isnan(heights), 0.05, (-1.5, -1.5))
    drawn = np.concatenate([triangles(ground.draw(tile)) for tile in ground.tiles()])
    assert area_from_above(drawn) == pytest.approx(np.isfinite(heights).sum() * 0.05**2, rel=1e-5)


def test_smooth_tiles_meet_without_cracks() -> None:
    heights = hills()
    ground = Ground(heights, nothing_forbidden(heights), 0.05, (0.0, 0.0))
    assert not ground.stepped
    height_at: dict[tuple[float, float], float] = {}
    for tile in ground.tiles():
        for x, y, z in triangles(ground.draw(tile)).reshape(-1, 3).tolist():
            assert height_at.setdefault((round(x, 4), round(y, 4)), z) == z
    assert height_at[0.5, 1.0] == pytest.approx(heights[19:21, 9:11].mean(), abs=1e-6)


def test_a_large_map_is_thinned_out_but_keeps_its_size() -> None:
    heights = hills(900, 700)
    ground = Ground(heights, nothing_forbidden(heights), 0.025, (0.0, 0.0))
    drawn = np.concatenate([triangles(ground.draw(tile)) for tile in ground.tiles()])
    assert len(drawn) <= 2 * (QUADS_MAX + 16) ** 2
    assert area_from_above(drawn) == pytest.approx(900 * 700 * 0.025**2, rel=1e-4)


def test_a_smooth_hole_is_a_pit_and_painted_black() -> None:
    heights = hills()
    heights[40:50, 30:40] = np.nan
    ground = Ground(heights, np.isnan(heights), 0.05, (0.0, 0.0))
    assert ground.picture(44, 46, 34, 36).max() < 0.05
    lowest = min(triangles(ground.draw(tile))[..., 2].min() for tile in ground.tiles())
    assert lowest < np.nanmin(heights) - 0.4


def test_an_edit_changes_the_tile_it_is_in_and_no_other() -> None:
    heights = hills(160, 160)
    before = {
        tile.name: tile.key
        for tile in Ground(heights, nothing_forbidden(heights), 0.05, (0.0, 0.0)).tiles()
    }
    forbidden = nothing_forbidden(heights)
    forbidden[30, 30] = True
    marked = {tile.name: tile.key for tile in Ground(heights, forbidden, 0.05, (0.0, 0.0)).tiles()}
    again = forbidden.copy()
    again[31, 31] = True
    after = {tile.name: tile.key for tile in Ground(heights, again, 0.05, (0.0, 0.0)).tiles()}
    assert set(marked) == set(before)
    assert [name for name in after if after[name] != marked[name]] == ["1_1"]


def test_forbidden_cells_are_red_and_free_ones_are_not() -> None:
    heights = np.zeros((40, 40))
    forbidden = nothing_forbidden(heights)
    forbidden[10:20, 10:20] = True
    picture = Ground(heights, forbidden, 0.05, (0.0, 0.0)).picture(0, 40, 0, 40)
    scale = len(picture) // 40
    inside, outside = picture[15 * scale, 15 * scale], picture[30 * scale, 30 * scale]
    assert inside[0] > 1.6 * inside[1]
    assert outside[0] < 1.2 * outside[1]


def test_a_picture_survives_its_png() -> None:
    from io import BytesIO

    from PIL import Image

    picture = np.random.default_rng(1).integers(0, 256, (13, 7, 3)) / 255
    assert np.array_equal(
        np.asarray(Image.open(BytesIO(png(picture)))), np.rint(picture * 255).astype(np.uint8)
    )
