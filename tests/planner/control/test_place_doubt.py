"""What footholds keep from holes by odometry that drifts."""

import numpy as np
import pytest

from tests.planner.control.plans import HEIGHT, TITAN, sensed
from walking_console.planner.control.place_doubt import FARTHEST, MIDDLE, PlaceDoubt
from walking_console.planner.terrain.map import EDGE, TerrainMap


def with_a_hole(cell: float = 0.1, known: bool = False) -> TerrainMap:
    heights = np.zeros((60, 60))
    heights[:, 30:] = np.nan
    forbidden = np.isnan(heights)
    seen = np.ones_like(forbidden) if known else None
    return TerrainMap(heights, forbidden, cell, (0.0, 0.0), TITAN.foot_radius, seen)


def after(doubt: PlaceDoubt, way: float, terrain: TerrainMap) -> TerrainMap:
    """The map after so much more way, in ticks of a centimetre."""
    for x in np.arange(0.0, way + 0.005, 0.01).tolist():
        terrain_now = doubt.cautious(sensed(body=(x, 0.0, HEIGHT, 0.0, 0.0, 0.0)), terrain)
    return terrain_now


@pytest.mark.parametrize(("way", "edge"), [(4.0, EDGE), (8.0, 0.015), (11.0, 0.02)])
def test_footholds_keep_farther_off_the_longer_the_way(way, edge):
    terrain = with_a_hole()
    now = after(PlaceDoubt(0.002), way, terrain)
    assert now.edge == pytest.approx(edge)
    assert (now is terrain) == (edge == EDGE)
    border = 30 * terrain.cell
    assert now.allows(border - edge - 0.001, 1.05)
    assert not now.allows(border - edge + 0.001, 1.05)


def test_never_farther_than_the_middle_of_a_cell_nor_than_three_centimetres():
    coarse = with_a_hole(0.05)
    assert after(PlaceDoubt(0.1), 5.0, coarse).edge == pytest.approx(MIDDLE * 0.05)
    assert after(PlaceDoubt(0.1), 5.0, coarse).allows(29.5 * 0.05, 1.025)
    for cell in (0.1, 0.015):
        assert after(PlaceDoubt(0.1), 5.0, with_a_hole(cell)).edge == pytest.approx(FARTHEST)


def test_a_body_that_sways_on_the_spot_gets_no_doubt():
    terrain = with_a_hole()
    doubt = PlaceDoubt(0.002)
    for tick in range(2000):
        x = 0.02 * (tick % 2)
        now = doubt.cautious(sensed(body=(x, 0.0, HEIGHT, 0.0, 0.0, 0.0)), terrain)
    assert now is terrain


@pytest.mark.parametrize("drift", [0.0, 0.002])
def test_a_map_it_has_made_itself_and_a_place_that_is_sure_are_left_as_they_are(drift):
    terrain = with_a_hole(known=drift > 0.0)
    assert after(PlaceDoubt(drift), 12.0, terrain) is terrain


def test_the_same_map_is_made_once_as_long_as_the_doubt_is_the_same():
    terrain = with_a_hole().work_out()
    doubt = PlaceDoubt(0.002)
    now = after(doubt, 8.0, terrain)
    assert doubt.cautious(sensed(body=(8.01, 0.0, HEIGHT, 0.0, 0.0, 0.0)), terrain) is now
    assert now.crests is terrain.crests and now.holes_bytes is terrain.holes_bytes
