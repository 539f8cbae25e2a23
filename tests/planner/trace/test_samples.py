"""Sets of samples as bits: runs, unbroken parts, ways inside them."""

import numpy as np
import pytest

from walking_console.planner.trace.samples import (
    SampleGrid,
    bits_of,
    first_bit,
    run_end,
    run_start,
    span,
)


def test_samples_are_bits() -> None:
    mask = span(3, 7) | span(10, 12)
    assert first_bit(mask) == 3
    assert (run_start(mask, 5), run_end(mask, 5)) == (3, 7)
    assert (run_start(mask, 11), run_end(mask, 11)) == (10, 12)
    assert span(5, 4) == 0


def test_flags_become_bits_the_first_as_bit_0() -> None:
    assert bits_of(np.array([True, False, True])) == 0b101


def test_rows_are_packed_one_after_the_other_with_an_empty_bit_between() -> None:
    grid = SampleGrid(2, 3)
    flags = np.array([[True, True, True], [False, True, False]])
    assert grid.pack(flags) == 0b0010_0111
    assert grid.pack_each(np.array([flags, ~flags])) == [0b0010_0111, 0b0101_0000]
    assert grid.all == 0b0111_0111
    assert grid.row_of(grid.pack(flags), 1) == 0b010


def test_an_unbroken_part_joins_rows_where_they_have_a_sample_in_common() -> None:
    grid = SampleGrid(3, 8)
    mask = span(0, 3) | span(3, 6) << grid.width | span(0, 1) << 2 * grid.width | span(6, 7)
    part = grid.unbroken(mask, 2)
    assert part == mask, "6 to 7 of the trace are reached over row 1, row 2 at its first samples"
    apart = span(0, 1) | span(3, 6) << grid.width
    assert grid.unbroken(apart, 0) == span(0, 1)


def test_the_farthest_sample_is_that_of_any_row() -> None:
    grid = SampleGrid(2, 8)
    assert grid.farthest(span(0, 3) | span(2, 6) << grid.width) == 6


def test_the_nearest_place_is_onward_rather_than_back_and_on_the_trace_rather_than_beside() -> None:
    grid = SampleGrid(2, 20)
    assert grid.nearest(span(2, 4) | span(12, 15), 6) == 12
    assert grid.nearest(span(8, 9) | span(6, 9) << grid.width, 6) == 8
    assert SampleGrid(1, 20).nearest(span(2, 4), 6) == 4


def test_a_way_stays_inside_the_mask_and_changes_rows_at_one_sample() -> None:
    grid = SampleGrid(2, 8)
    mask = span(0, 3) | span(3, 6) << grid.width
    way = grid.way(mask, 0, grid.width + 6)
    assert way[0] == 0 and way[-1] == grid.width + 6
    assert all(mask >> sample & 1 for sample in way)
    assert all(abs(b - a) in (1, grid.width) for a, b in zip(way, way[1:], strict=False))
    assert grid.way(mask, 3, 0) == [3, 2, 1, 0]
    assert grid.way(mask, 2, 2) == [2]


def test_where_no_way_leads_it_says_so() -> None:
    grid = SampleGrid(1, 8)
    with pytest.raises(RuntimeError, match="no way for the body from sample 0 to 6"):
        grid.way(span(0, 3) | span(5, 7), 0, 6)
