"""The shadow lies on the ground, each part of it once."""

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level, standing
from walking_console.web.scene.shadow import BANDS, CORNERS, LIFT, SUN, ShadowOverlay
from walking_console.web.scene.terrain_tiles import TerrainTiles


@pytest.fixture
def terrain(server: viser.ViserServer) -> TerrainTiles:
    tiles = TerrainTiles(server)
    tiles.draw(level())
    return tiles


def test_it_lies_on_the_ground_under_torso_and_feet(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = ShadowOverlay(server, standing().machine)
    bands = [vertices for _, _, vertices in overlay.changes(standing(), terrain)]
    assert np.concatenate(bands)[:, 2] == pytest.approx(LIFT)
    middles = bands[0].reshape(-1, CORNERS, 3).mean(axis=1)
    assert middles[0, :2] == pytest.approx(SUN, abs=1e-6)
    assert middles[-4:, :2] == pytest.approx(np.array(standing().feet)[:, :2], abs=1e-6)


def test_its_bands_lie_beside_each_other_and_fade_outwards() -> None:
    for inner, outer in zip(BANDS, BANDS[1:], strict=False):
        assert inner.shares[-1] == outer.shares[0] and inner.opacity > outer.opacity


def test_a_step_under_it_never_comes_through(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    view = terrain.view
    assert view is not None
    view.heights[:, view.heights.shape[1] // 2 :] = 0.2
    overlay = ShadowOverlay(server, standing().machine)
    for _, _, vertices in overlay.changes(standing(), terrain):
        ground = terrain.heights(vertices[:, :2].astype(float), 0.0)
        assert np.all(vertices[:, 2] > ground)
