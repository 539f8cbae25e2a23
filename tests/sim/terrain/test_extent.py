"""How large a map a course is given."""

from __future__ import annotations

import numpy as np
import pytest

from tests.sim.terrain.grounds import GENERATED, ground
from walking_console.sim.terrain.ground import GroundError


@pytest.mark.parametrize("kind", GENERATED)
def test_maps_reach_two_metres_beyond_the_course(kind: str) -> None:
    x_min, x_max, y_min, y_max = ground(kind, span=(0.0, 9.0, -1.0, 3.0)).bounds
    assert x_min <= -2.0 and x_max >= 11.0 and y_min <= -3.0 and y_max >= 5.0


def test_flat_ground_reaches_twelve_metres_from_the_start_in_every_direction() -> None:
    x_min, x_max, y_min, y_max = ground("flat", start=(3.0, -2.0, 1.0)).bounds
    assert x_min <= -9.0 and x_max >= 15.0 and y_min <= -14.0 and y_max >= 10.0


def test_flat_ground_holds_an_hour_of_walking_in_a_million_cells() -> None:
    far = ground("flat", span=360.0)
    assert far.heights.size <= 1_000_000 and far.bounds[1] >= 362.0 and far.level == 0.0


@pytest.mark.parametrize("kind", GENERATED)
def test_a_longer_course_finds_the_same_ground(kind: str) -> None:
    near, far = ground(kind, span=1.0), ground(kind, span=9.0)
    row, column = (
        round((a - b) / near.cell) for a, b in zip(near.origin[::-1], far.origin[::-1], strict=True)
    )
    same = far.heights[row : row + near.rows, column : column + near.columns]
    np.testing.assert_allclose(same, near.heights, atol=1e-12)


def test_a_course_too_long_for_a_map_is_refused_in_words() -> None:
    with pytest.raises(GroundError, match="shorten"):
        ground("rough", span=200.0)
