"""Height files as people have them: what is done with them whatever their format."""

from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from tests.sim.terrain.readers.files import FIXTURES, HILL, ground, of_fixture
from walking_console.sim.terrain.files import Smoothed, read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError
from walking_console.sim.terrain.wide_map import WHOLE_CELLS_MAX


def test_heights_above_the_sea_are_brought_to_the_start_and_that_is_told() -> None:
    made = of_fixture("heights-above-the-sea")
    assert abs(made.heights).max() < 0.2 and made.heights[made.cell_at(0.0, 0.0)] == 0.0
    assert "m taken off" in made.note
    lowest = of_fixture("heights-above-the-sea", "terrain.offset=min")
    assert lowest.heights.min() == 0.0
    by_hand = of_fixture("heights-above-the-sea", "terrain.offset=437.2")
    raw = np.load(FIXTURES / "heights-above-the-sea" / "ground.npy")
    np.testing.assert_allclose(by_hand.heights, raw.astype(np.float64) - 437.2)


def test_holes_and_smoothing_go_together() -> None:
    made = of_fixture("missing-heights", scenario="a.toml")
    raw = np.load(FIXTURES / "missing-heights" / "nan.npy")
    assert made.cell == pytest.approx(0.025)
    holes = np.repeat(np.repeat(np.isnan(raw), 2, axis=0), 2, axis=1)
    assert (np.isnan(made.heights) == holes).all()
    assert np.nanmax(made.heights) <= np.nanmax(raw) and np.nanmin(made.heights) >= np.nanmin(raw)


def test_nodata_that_nobody_told_of_is_named_with_the_key_that_cures_it() -> None:
    with pytest.raises(GroundError, match="looks like NODATA .* set nodata = -9999"):
        of_fixture("missing-heights", scenario="b.toml")
    cured = of_fixture(
        "missing-heights", "terrain.nodata=-9999.0", 'terrain.nan="hole"', scenario="b.toml"
    )
    assert np.isnan(cured.heights).any()


@pytest.mark.parametrize("suffix", ["npy", "png", "tif"])
def test_one_limit_for_fine_cells_of_all_formats_and_the_thinning_is_told(
    tmp_path: Path, suffix: str
) -> None:
    side = 2100
    values = np.zeros((side, side), dtype=np.uint8)
    path = tmp_path / f"h.{suffix}"
    if suffix == "npy":
        np.save(path, values)
    elif suffix == "png":
        Image.fromarray(values).save(path)
    else:
        tifffile.imwrite(path, values)
    made = ground(path, cell=0.005)
    assert made.heights.size <= WHOLE_CELLS_MAX and made.cell == 0.01
    assert "thinned to one cell in 2" in made.note


def test_crop_step_and_flip_take_a_part_of_a_map(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", HILL)
    whole = ground(tmp_path / "h.npy", cell=0.5, origin=[-4.0, -3.0])
    part = ground(tmp_path / "h.npy", cell=0.5, origin=[-4.0, -3.0], crop=[-2.0, 2.0, -1.0, 2.0])
    np.testing.assert_array_equal(part.heights, whole.heights[4:10, 4:12])
    assert part.bounds == (-2.0, 2.0, -1.0, 2.0)
    every_other = ground(tmp_path / "h.npy", cell=0.5, step=2)
    np.testing.assert_array_equal(every_other.heights, HILL[::2, ::2])
    assert every_other.cell == 1.0
    turned = ground(tmp_path / "h.npy", cell=0.5, flip="xy")
    np.testing.assert_array_equal(turned.heights, HILL[::-1, ::-1])
    with pytest.raises(GroundError, match="crop .* leaves no ground: the map reaches from x -4"):
        ground(tmp_path / "h.npy", cell=0.5, origin=[-4.0, -3.0], crop=[20.0, 22.0, 0.0, 2.0])


def test_the_reader_is_chosen_by_the_ending_in_any_case(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", HILL)
    (tmp_path / "h.npy").rename(tmp_path / "H.NPY")
    terrain = FileTerrain(kind="file", file="H.NPY", cell=0.5)
    assert read_heights(terrain, tmp_path).heights.shape == HILL.shape


def test_smooth_ground_of_many_cells_is_interpolated_where_it_is_wanted(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    heights = rng.uniform(-0.2, 0.2, (500, 600))
    heights[40:44, 100] = np.nan
    np.save(tmp_path / "h.npy", heights)
    made = ground(tmp_path / "h.npy", cell=0.1, smooth=True, nan="hole")
    whole = made.whole
    assert whole is not None and whole.shape == (2000, 2400) and whole.cell == 0.025
    exact = Smoothed(heights, 4)(slice(0, 2000), slice(0, 2400))
    for rows, columns in ((slice(0, 50), slice(0, 9)), (slice(150, 200), slice(380, 2400, 7))):
        np.testing.assert_allclose(whole.read(rows, columns), exact[rows, columns], atol=1e-7)
    assert np.array_equal(made.heights, whole.read(*made.cells))
    assert "interpolated to 0.025 m" in made.note
    with pytest.raises(GroundError, match="smooth = true would make 8000 x 9600 cells"):
        np.save(tmp_path / "h.npy", np.zeros((2000, 2400)))
        ground(tmp_path / "h.npy", cell=0.1, smooth=True)
