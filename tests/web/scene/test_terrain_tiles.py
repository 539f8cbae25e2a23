"""The ground in the scene: one patch sent for one edit, and heights and clicks that meet it."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level
from walking_console.sim.snapshot import TerrainView
from walking_console.web.scene.terrain_tiles import TerrainTiles


def with_hole() -> TerrainView:
    """Level ground with a square hole around its middle."""
    terrain = level(2)
    heights = terrain.heights.copy()
    heights[75:85, 75:85] = np.nan
    return replace(terrain, heights=heights, forbidden=np.isnan(heights))


def forbidden_at(view: TerrainView, revision: int, *cells: tuple[int, int]) -> TerrainView:
    forbidden = view.forbidden.copy()
    for cell in cells:
        forbidden[cell] = True
    return replace(view, revision=revision, forbidden=forbidden)


@pytest.fixture
def tiles(server: viser.ViserServer) -> TerrainTiles:
    return TerrainTiles(server)


def test_an_edited_patch_sends_one_tile(tiles: TerrainTiles) -> None:
    tiles.draw(forbidden_at(level(), 2, (30, 30)))
    before = dict(tiles.tiles)
    tiles.draw(forbidden_at(level(), 3, (30, 30), (31, 31)))
    after = tiles.tiles
    assert [n for n in after if after[n][0].key != before[n][0].key] == ["1_1"]
    assert all(after[n][1] is before[n][1] for n in after)


def test_an_edit_leaves_the_colours_of_all_other_ground(tiles: TerrainTiles) -> None:
    view = with_hole()
    hills = np.random.default_rng(1).uniform(0.0, 0.3, view.heights.shape)
    tiles.draw(replace(view, heights=hills))
    before = dict(tiles.tiles)
    raised = hills.copy()
    raised[30:34, 30:34] += 3.0
    tiles.draw(replace(view, revision=3, heights=raised))
    assert [n for n in before if tiles.tiles[n][0].key != before[n][0].key] == ["1_1"]
    tiles.draw(replace(view, revision=4, heights=hills + 1.0))
    assert tiles._relief == pytest.approx((hills.min() + 1.0, hills.max() + 1.0))


def test_the_same_ground_is_not_drawn_again(tiles: TerrainTiles) -> None:
    view = level()
    tiles.draw(view)
    shown = dict(tiles.tiles)
    tiles.draw(replace(view))
    assert all(tiles.tiles[name][0] is tile for name, (tile, _) in shown.items())


def test_a_map_of_another_size_leaves_no_old_tile(tiles: TerrainTiles) -> None:
    tiles.draw(level())
    small = np.zeros((4, 4))
    tiles.draw(TerrainView(2, small, np.zeros(small.shape, bool), 1.0, (-2.0, -2.0)))
    assert len(tiles.tiles) == 16
    names = set(tiles.server.scene._handle_from_node_name)
    assert {name for name in names if name.startswith("/world/ground/")} == {
        *(f"/world/ground/{name}" for name in tiles.tiles),
        "/world/ground/floor",
    }


def test_the_floor_is_seen_through_holes_only(tiles: TerrainTiles) -> None:
    tiles.draw(level())
    assert tiles.floor is not None and not tiles.floor.visible
    tiles.draw(with_hole())
    assert tiles.floor.visible


def test_heights_are_those_of_the_cells_and_the_other_value_over_holes_and_outside(
    tiles: TerrainTiles,
) -> None:
    view = with_hole()
    heights = view.heights.copy()
    heights[100, 20] = 0.3
    tiles.draw(replace(view, heights=heights))
    places = [(-2.99, 1.01), (0.0, 0.0), (99.0, 0.0), (1.0, 1.0)]
    wanted = [0.3, -7.0, -7.0, 0.0]
    assert tiles.heights(np.array(places), -7.0).tolist() == wanted
    assert [tiles.height(x, y, -7.0) for x, y in places] == wanted


def test_a_ray_meets_the_ground_where_it_is_seen(tiles: TerrainTiles) -> None:
    tiles.draw(level())
    place = tiles.hit(np.array((0.0, 0.0, 2.0)), np.array((1.0, 0.5, -2.0)))
    assert place == pytest.approx((1.0, 0.5), abs=0.02)


def test_a_ray_into_the_sky_or_beside_the_map_meets_nothing(tiles: TerrainTiles) -> None:
    down = np.array((0.0, 0.0, -1.0))
    assert tiles.hit(np.zeros(3), down) is None  # nothing drawn yet
    tiles.draw(level())
    assert tiles.hit(np.array((0.0, 0.0, 2.0)), -down) is None
    assert tiles.hit(np.array((9.0, 0.0, 2.0)), down) is None


def test_a_ray_meets_a_hole_at_the_height_of_the_ground_around(tiles: TerrainTiles) -> None:
    tiles.draw(with_hole())
    place = tiles.hit(np.array((-1.0, 0.0, 1.0)), np.array((1.0, 0.0, -1.0)))
    assert place == pytest.approx((0.0, 0.0), abs=0.03)
