"""The ground as tiles: exact where it is stepped, without cracks where it is smooth, and sent again
only where it changed.
"""

import numpy as np
import pytest

from tests.web.scene.glb_files import triangles
from walking_console.web.scene.terrain import PIT, QUADS_MAX, TerrainMesh, Window, floor


def area_from_above(corners: np.ndarray) -> float:
    a, b = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    return float(np.sum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])) / 2)


def hills(rows: int = 90, columns: int = 70) -> np.ndarray:
    y, x = np.mgrid[:rows, :columns] * 0.05
    return 0.2 * np.sin(1.7 * x) * np.cos(1.3 * y)


def nothing_forbidden(heights: np.ndarray) -> np.ndarray:
    return np.zeros(heights.shape, bool)


def test_stepped_ground_is_drawn_at_exactly_its_own_heights() -> None:
    heights = np.repeat([0.0, 0.12, 0.24, 0.36], 20)[None, :].repeat(40, axis=0)
    mesh = TerrainMesh(heights, nothing_forbidden(heights), 0.025, (0.0, 0.0))
    assert mesh.stepped
    drawn = np.concatenate([triangles(mesh.draw(tile)) for tile in mesh.tiles()])
    for corners in drawn:
        middle = corners.mean(axis=0)
        cell = heights[int(middle[1] / 0.025), int(middle[0] / 0.025)]
        assert corners[:, 2] == pytest.approx(cell)
    assert area_from_above(drawn) == pytest.approx(40 * 80 * 0.025**2)


def test_holes_are_left_open() -> None:
    rng = np.random.default_rng(5)
    heights = np.where(rng.random((60, 60)) < 0.3, np.nan, 0.0)
    mesh = TerrainMesh(heights, np.isnan(heights), 0.05, (-1.5, -1.5))
    drawn = np.concatenate([triangles(mesh.draw(tile)) for tile in mesh.tiles()])
    assert area_from_above(drawn) == pytest.approx(np.isfinite(heights).sum() * 0.05**2, rel=1e-5)


def test_smooth_tiles_meet_without_cracks() -> None:
    heights = hills()
    mesh = TerrainMesh(heights, nothing_forbidden(heights), 0.05, (0.0, 0.0))
    assert not mesh.stepped
    height_at: dict[tuple[float, float], float] = {}
    for tile in mesh.tiles():
        for x, y, z in triangles(mesh.draw(tile)).reshape(-1, 3).tolist():
            assert height_at.setdefault((round(x, 4), round(y, 4)), z) == z
    assert height_at[0.5, 1.0] == pytest.approx(heights[19:21, 9:11].mean(), abs=1e-6)


def test_a_large_map_is_thinned_out_but_keeps_its_size() -> None:
    heights = hills(900, 700)
    mesh = TerrainMesh(heights, nothing_forbidden(heights), 0.025, (0.0, 0.0))
    drawn = np.concatenate([triangles(mesh.draw(tile)) for tile in mesh.tiles()])
    assert len(drawn) <= 2 * (QUADS_MAX + 16) ** 2
    assert area_from_above(drawn) == pytest.approx(900 * 700 * 0.025**2, rel=1e-4)


def test_a_smooth_hole_is_a_pit_and_painted_black() -> None:
    heights = hills()
    heights[40:50, 30:40] = np.nan
    mesh = TerrainMesh(heights, np.isnan(heights), 0.05, (0.0, 0.0))
    assert mesh.picture(Window(44, 46, 34, 36)).max() < 0.05
    lowest = min(triangles(mesh.draw(tile))[..., 2].min() for tile in mesh.tiles())
    assert lowest < np.nanmin(heights) - 0.4


def test_an_edit_changes_the_tile_it_is_in_and_no_other() -> None:
    heights = hills(160, 160)
    before = {
        tile.name: tile.key
        for tile in TerrainMesh(heights, nothing_forbidden(heights), 0.05, (0.0, 0.0)).tiles()
    }
    forbidden = nothing_forbidden(heights)
    forbidden[30, 30] = True
    marked = {
        tile.name: tile.key for tile in TerrainMesh(heights, forbidden, 0.05, (0.0, 0.0)).tiles()
    }
    again = forbidden.copy()
    again[31, 31] = True
    after = {tile.name: tile.key for tile in TerrainMesh(heights, again, 0.05, (0.0, 0.0)).tiles()}
    assert set(marked) == set(before)
    assert [name for name in after if after[name] != marked[name]] == ["1_1"]


def test_forbidden_cells_are_red_and_free_ones_are_not() -> None:
    heights = np.zeros((40, 40))
    forbidden = nothing_forbidden(heights)
    forbidden[10:20, 10:20] = True
    picture = TerrainMesh(heights, forbidden, 0.05, (0.0, 0.0)).picture(Window(0, 40, 0, 40))
    scale = len(picture) // 40
    inside, outside = picture[15 * scale, 15 * scale], picture[30 * scale, 30 * scale]
    assert inside[0] > 1.6 * inside[1]
    assert outside[0] < 1.2 * outside[1]


def test_the_floor_lies_under_the_whole_map_at_the_depth_of_a_pit() -> None:
    heights = hills()
    mesh = TerrainMesh(heights, nothing_forbidden(heights), 0.05, (-1.0, 2.0))
    corners = triangles(floor(mesh))
    assert area_from_above(corners) == pytest.approx(heights.size * 0.05**2)
    assert corners[..., 2] == pytest.approx(heights.min() - PIT)
    assert corners[..., 0].min() == pytest.approx(-1.0)
    assert corners[..., 1].min() == pytest.approx(2.0)


def test_a_window_grows_up_to_the_edges_of_the_map() -> None:
    assert Window(1, 5, 3, 6).grown(2) == Window(0, 7, 1, 8)
