"""Arrays of numpy: checked from their headers, rows as they are."""

from pathlib import Path

import numpy as np
import pytest

from tests.sim.terrain.readers.files import HILL, ground
from walking_console.sim.terrain.generators import GroundError


def test_the_first_row_of_an_array_is_the_least_y(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", HILL)
    np.testing.assert_array_equal(ground(tmp_path / "h.npy", cell=0.5).heights, HILL)


def test_exact_heights_win_over_those_for_readers(tmp_path: Path) -> None:
    np.savez(tmp_path / "h.npz", heights=HILL.astype(np.float32), heights_exact=HILL, cell=0.5)
    made = ground(tmp_path / "h.npz")
    np.testing.assert_array_equal(made.heights, HILL)
    assert made.cell == 0.5


def test_an_archive_without_heights_names_what_it_has(tmp_path: Path) -> None:
    np.savez(tmp_path / "h.npz", depth=HILL)
    with pytest.raises(GroundError, match="no 'heights' in it, only depth"):
        ground(tmp_path / "h.npz")
