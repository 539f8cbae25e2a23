"""Maps that are read where they are wanted, and changed tile by tile."""

import numpy as np
import pytest

from walking_console.sim.terrain.wide_map import (
    TILE,
    TileNumber,
    WideMap,
    cut_to,
    tiles_beside,
    tiles_in,
    tiles_of,
)

ROWS, COLUMNS = 300, 200
HEIGHTS = np.random.default_rng(1).uniform(-1.0, 1.0, (ROWS, COLUMNS)).astype(np.float32)


def wide() -> WideMap:
    return WideMap((ROWS, COLUMNS), 0.1, (-5.0, 2.0), lambda rows, columns: HEIGHTS[rows, columns])


def test_any_rectangle_is_read_and_every_so_many_cells_of_it() -> None:
    assert np.array_equal(wide().read(slice(3, 290), slice(7, 9)), HEIGHTS[3:290, 7:9])
    coarse = wide().read(slice(5, ROWS, 7), slice(0, COLUMNS, 64))
    assert np.array_equal(coarse, HEIGHTS[5::7, ::64]) and coarse.dtype == np.float64


def test_what_is_changed_is_read_changed_whole_and_every_so_many_cells() -> None:
    rows = np.array([0, 31, 32, 299, 150])
    columns = np.array([0, 31, 32, 199, 63])
    changed = wide().with_cells(rows, columns, np.array([1.5, np.nan, 2.5, 3.5, 4.5]))
    expected = HEIGHTS.copy()
    expected[rows, columns] = [1.5, np.nan, 2.5, 3.5, 4.5]
    whole = slice(0, ROWS), slice(0, COLUMNS)
    np.testing.assert_array_equal(changed.read(*whole), expected)
    for step in (2, 3, 31, 64):
        part = changed.read(slice(0, ROWS, step), slice(32, COLUMNS, step))
        np.testing.assert_array_equal(part, expected[::step, 32::step])
    np.testing.assert_array_equal(changed.at(rows, columns), expected[rows, columns])
    assert np.array_equal(wide().read(*whole), HEIGHTS)


def test_an_edit_copies_only_the_tiles_it_lies_in() -> None:
    first = wide().with_cells(np.array([5]), np.array([5]), np.array([1.0]))
    second = first.with_cells(np.array([100]), np.array([100]), np.array([1.0]))
    assert set(second.changed) == {TileNumber(0, 0), TileNumber(3, 3)}
    assert second.changed[TileNumber(0, 0)] is first.changed[TileNumber(0, 0)]


def test_a_rectangle_is_lowered_and_nothing_beside_it() -> None:
    lowered = wide().lowered((slice(20, 70), slice(190, 200)), 0.25)
    expected = HEIGHTS.astype(np.float64)
    expected[20:70, 190:200] = (expected[20:70, 190:200] - 0.25).astype(np.float32)
    assert np.array_equal(lowered.read(slice(0, ROWS), slice(0, COLUMNS)), expected)


def test_a_window_keeps_its_reach_until_the_machine_has_come_two_tiles_far() -> None:
    terrain = WideMap((1000, 1000), 0.1, (0.0, 0.0), lambda rows, columns: np.zeros((1, 1)))
    rows, columns = terrain.window_about(TileNumber(15, 15), 7.0)
    side = TILE * 0.1
    for x in (14 * side, 17 * side):  # the edges of the tiles beside its own
        assert columns.start * 0.1 <= x - 7.0 and x + 7.0 <= columns.stop * 0.1
    assert rows == columns and rows.start % TILE == 0 == rows.stop % TILE


def test_at_an_edge_a_window_ends_with_the_map() -> None:
    assert wide().window_about(TileNumber(0, 6), 3.0) == (slice(0, 96), slice(128, COLUMNS))
    assert wide().tile_under(-100.0, 1000.0) == (ROWS // TILE, 0)


def test_tiles_of_cells_hold_each_cell_once() -> None:
    rng = np.random.default_rng(2)
    rows, columns = rng.integers(0, ROWS, 500), rng.integers(0, COLUMNS, 500)
    found = tiles_of(rows, columns)
    assert sorted(np.concatenate([mine for _, mine in found]).tolist()) == list(range(500))
    for place, mine in found:
        assert {(r // TILE, c // TILE) for r, c in zip(rows[mine], columns[mine], strict=True)} == {
            place
        }


def test_tiles_beside_a_window_are_those_of_the_other_alone() -> None:
    window = slice(0, 4 * TILE), slice(0, 3 * TILE)
    other = slice(TILE, 4 * TILE), slice(0, 3 * TILE)
    assert tiles_beside(window, other) == [TileNumber(0, 0), TileNumber(0, 1), TileNumber(0, 2)]
    assert len(tiles_in(window)) == 12
    assert tiles_beside(window, (slice(0, 0), slice(0, 0))) == tiles_in(window)


@pytest.mark.parametrize("window", [(slice(-9, 5), slice(0, 999)), (slice(400, 500), slice(0, 1))])
def test_a_window_is_cut_to_the_map(window: tuple[slice, slice]) -> None:
    rows, columns = cut_to(window, (ROWS, COLUMNS))
    assert 0 <= rows.start <= rows.stop <= ROWS and 0 <= columns.start <= columns.stop <= COLUMNS
