"""A grid too large to be read is refused before it is."""

import pytest

from walking_console.sim.terrain.generators import GroundError
from walking_console.sim.terrain.readers.raster import CELLS_MAX, check_size


def test_the_largest_grid_is_taken_and_one_cell_more_is_not() -> None:
    side = int(CELLS_MAX**0.5)
    check_size(side, side)
    with pytest.raises(GroundError, match=f"{side + 1} x {side} cells; at most {CELLS_MAX}"):
        check_size(side, side + 1)


def test_a_grid_of_nothing_is_refused() -> None:
    with pytest.raises(GroundError, match="at least 2 x 2"):
        check_size(0, 4)
