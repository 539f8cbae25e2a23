"""The true ground: made from words, looked up and edited."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.sim.terrain.grounds import FEET, GENERATED, START, TITAN, ground, terrain
from walking_console.planner.terrain.map import TerrainMap
from walking_console.sim.terrain.ground import GroundError, make_ground


@pytest.mark.parametrize("kind", GENERATED)
def test_the_start_posture_finds_ground(kind: str) -> None:
    made = ground(kind, stand=FEET, seed=3)
    assert all(math.isfinite(made.height_at(x, y)) for x, y in FEET)


@pytest.mark.parametrize(
    "kind", [kind for kind in GENERATED if kind not in ("slope", "dem", "rough", "wave")]
)
def test_the_ground_around_the_start_is_level(kind: str) -> None:
    made = ground(kind, seed=3)
    assert {made.height_at(x, y) for x, y in FEET} == {0.0}


@pytest.mark.parametrize("kind", GENERATED)
def test_the_same_seed_gives_the_same_ground_bit_for_bit(kind: str) -> None:
    assert ground(kind, seed=7).heights.tobytes() == ground(kind, seed=7).heights.tobytes()


@pytest.mark.parametrize("kind", ["rough", "holes", "footholds", "poles", "stepping_stones"])
def test_another_seed_gives_other_ground_and_the_terrains_own_seed_wins(kind: str) -> None:
    one, two = ground(kind, seed=1), ground(kind, seed=2)
    assert one.heights.tobytes() != two.heights.tobytes()
    own = make_ground(terrain(kind, seed=1), TITAN, START, 2)
    assert own.heights.tobytes() == one.heights.tobytes()


def test_cells_sit_on_multiples_of_their_size_and_agree_with_the_belief() -> None:
    made = ground("holes", fraction=0.5)
    belief = TerrainMap(made.heights, np.isnan(made.heights), made.cell, made.origin)
    for x, y in np.random.default_rng(1).uniform(-6.5, 6.5, (500, 2)):
        assert made.index(x, y) == belief.index(x, y)
        assert made.height_at(x, y) == belief.height_at(x, y) or math.isnan(made.height_at(x, y))


def test_outside_the_map_there_is_no_ground() -> None:
    assert math.isnan(ground("flat").height_at(100.0, 0.0))


def test_a_start_over_a_hole_is_refused_in_words() -> None:
    with pytest.raises(GroundError, match="foot 1 .* over a hole"):
        ground("river", at=0.4, width=0.3, stand=FEET)


@pytest.mark.parametrize("kind", GENERATED)
def test_slopes_and_rough_ground_are_relief_and_what_is_built_is_cells(kind: str) -> None:
    made = ground(kind, seed=3)
    assert made.relief == (kind in ("slope", "dem", "rough", "wave")), kind


def test_relief_is_relief_after_an_edit_too() -> None:
    before = ground("rough", seed=3)
    dug = before.edited([(30, 40, math.nan)])
    assert dug.relief and not ground("flat").edited([(30, 40, 0.1)]).relief
    x, y = before.centre(50, 60)
    assert dug.height_at(x + 0.01, y) == before.height_at(x + 0.01, y)


def test_edited_ground_is_new_ground() -> None:
    before = ground("flat")
    after = before.edited([(3, 4, -0.2), (5, 6, math.nan)])
    assert after.heights[3, 4] == -0.2 and math.isnan(after.heights[5, 6]) and before.level == 0.0
    with pytest.raises(ValueError):
        after.heights[0, 0] = 1.0


@pytest.mark.parametrize("cell", [(-1, 0, 0.0), (0, 480, 0.0), (0, 0, math.inf), (0, 0, 1e6)])
def test_edits_outside_the_map_or_of_infinite_height_are_refused(
    cell: tuple[int, int, float],
) -> None:
    with pytest.raises(GroundError):
        ground("flat").edited([cell])
