"""A polygon laid over the ground: over steps, never under its corners, and whole."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level
from walking_console.web.scene.draped_mesh import EDGE_LIFT, LIFT, VERTICES, drape, draped_faces
from walking_console.web.scene.terrain_tiles import TerrainTiles

SQUARE = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])


@pytest.fixture
def terrain(server: viser.ViserServer) -> TerrainTiles:
    """Level ground with a block 0.2 m high in its middle, and a hole beside it."""
    view = level()
    heights = view.heights.copy()
    heights[78:82, 78:82] = 0.2
    heights[70:75, 70:75] = np.nan
    tiles = TerrainTiles(server)
    tiles.draw(replace(view, heights=heights))
    return tiles


def area(mesh: np.ndarray) -> float:
    a, b, c = (mesh[draped_faces()][:, k, :2] for k in range(3))
    one, two = b - a, c - a
    return float(np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum() / 2)


def test_it_covers_the_polygon_whatever_the_number_of_corners(terrain: TerrainTiles) -> None:
    square, _ = drape(SQUARE, terrain)
    triangle, _ = drape(SQUARE[:3], terrain)
    assert len(square) == len(triangle) == VERTICES
    assert area(square) == pytest.approx(1.0, rel=1e-5)
    assert area(triangle) == pytest.approx(0.5, rel=1e-5)


def test_it_lies_on_the_ground_where_that_is_higher_than_the_feet(terrain: TerrainTiles) -> None:
    mesh, _ = drape(SQUARE, terrain)
    on_block = np.all(np.abs(mesh[:, :2]) < 0.09, axis=1)
    assert mesh[on_block, 2] == pytest.approx(0.2 + LIFT)
    far = np.any(np.abs(mesh[:, :2]) > 0.11, axis=1)
    assert mesh[far, 2] == pytest.approx(LIFT)


def test_over_a_hole_it_keeps_the_plane_of_its_corners(terrain: TerrainTiles) -> None:
    mesh, edge = drape(SQUARE + (0.0, 0.0, 0.1), terrain)
    assert mesh[:, 2].min() == pytest.approx(0.1 + LIFT)
    assert edge[..., 2].min() == pytest.approx(0.1 + EDGE_LIFT)


def test_its_edge_goes_once_round(terrain: TerrainTiles) -> None:
    _, edge = drape(SQUARE, terrain)
    length = np.linalg.norm(edge[:, 1, :2] - edge[:, 0, :2], axis=1).sum()
    assert length == pytest.approx(4.0, rel=1e-5)
