"""Six legs whose reach overlaps: they never cross, and their feet keep two radii apart."""

from __future__ import annotations

import pytest

from tests.sweeps.crossings import FRACTIONS, OVERLAPS, walk


@pytest.mark.parametrize("by", OVERLAPS)
@pytest.mark.parametrize("fraction", FRACTIONS)
def test_legs_whose_reach_overlaps_neither_cross_nor_touch(by: float, fraction: float) -> None:
    told = walk(by, fraction, seed=1)
    assert told.crossed == 0 and told.apart >= -1e-6
    assert told.distance > 2.0
