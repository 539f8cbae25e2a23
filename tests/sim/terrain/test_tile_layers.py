"""What is known of a wide map tile by tile."""

import numpy as np

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.grid import crests_of
from walking_console.planner.terrain.traversability import classify
from walking_console.sim.terrain.tile_layers import Layer, TileFacts
from walking_console.sim.terrain.wide_map import TILE, WideMap, tiles_in

SHAPE = (400, 290)
MACHINE = load_machine("titan3")
WHOLE = slice(0, SHAPE[0]), slice(0, SHAPE[1])


def hills() -> np.ndarray:
    rng = np.random.default_rng(3)
    heights = 0.3 * np.add.outer(np.sin(np.arange(SHAPE[0]) / 9.0), np.cos(np.arange(SHAPE[1]) / 7))
    heights[rng.integers(0, SHAPE[0], 60), rng.integers(0, SHAPE[1], 60)] = np.nan
    return heights.astype(np.float32)


def facts() -> TileFacts:
    heights = hills()
    whole = WideMap(SHAPE, 0.025, (0.0, 0.0), lambda rows, columns: heights[rows, columns])
    return TileFacts(whole, MACHINE, final=False)


def test_tile_by_tile_a_map_is_what_it_is_as_a_whole() -> None:
    heights, forbidden, crests = facts().over(WHOLE)
    exact = hills().astype(np.float64)
    np.testing.assert_array_equal(heights, exact)
    assert np.array_equal(forbidden, classify(exact, 0.025, MACHINE))
    assert np.array_equal(crests, crests_of(exact, 2))
    part = slice(64, 192), slice(96, 290)
    assert np.array_equal(facts().prohibited(part), forbidden[part])


def test_only_what_depends_on_a_changed_tile_is_worked_out_again() -> None:
    tiles = facts()
    tiles.over(WHOLE)
    changed = tiles.whole.with_cells(np.array([100]), np.array([100]), np.array([2.0]))
    missing = tiles.after_change(changed)
    assert missing == tiles.missing(WHOLE)
    assert len(missing) == 9 and {(p.row, p.column) for p in missing} == {
        (r, c) for r in (2, 3, 4) for c in (2, 3, 4)
    }
    heights, forbidden, _ = tiles.over(WHOLE)
    assert heights[100, 100] == 2.0 and forbidden[100, 100]


def test_a_copy_goes_its_own_way() -> None:
    tiles = facts()
    tiles.over(WHOLE)
    other = tiles.copy()
    other.keep_only((slice(0, TILE), slice(0, TILE)))
    assert not tiles.missing(WHOLE) and len(other.missing(WHOLE)) == len(tiles_in(WHOLE)) - 1


def test_a_layer_brings_back_what_was_left_behind() -> None:
    layer = Layer(SHAPE, False)
    west, east = (slice(0, 128), slice(0, 128)), (slice(64, 192), slice(96, 224))
    values = np.zeros((128, 128), dtype=bool)
    values[3, 5] = values[100, 120] = True
    there = layer.moved(values, west, east)
    assert there[36, 24] and there.sum() == 1
    there[120, 120] = True
    back = layer.moved(there, east, west)
    assert np.array_equal(back, values)
    again = layer.moved(back, west, east)
    assert again[120, 120] and again.sum() == 2


def test_single_cells_are_changed_where_no_window_is() -> None:
    layer = Layer(SHAPE, 0.0)
    layer.set_cells(np.array([399, 10]), np.array([289, 10]), 1.5)
    values = np.zeros(SHAPE)
    layer.lay_over(values, WHOLE)
    assert values[399, 289] == values[10, 10] == 1.5 and values.sum() == 3.0
    part = np.zeros((20, 20))
    layer.lay_over(part, (slice(5, 25), slice(7, 27)))
    assert part[5, 3] == 1.5 and part.sum() == 1.5
