"""Height files as people have them: each loads as what it is, or is refused in one line that says
what to do."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import png
import pytest
import tifffile
from PIL import Image

from walking_console.planner.robot.model import load_machine
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import prepare
from walking_console.sim.terrain.files import CELLS_MAX, read_heights
from walking_console.sim.terrain.generators import FileTerrain, GroundError
from walking_console.sim.terrain.ground import Ground, make_ground

FIXTURES = Path(__file__).parents[1] / "fixtures"
TITAN = load_machine("titan3")
HILL = np.add.outer(np.arange(12) * 0.01, np.arange(16) * 0.002)  # first row lowest


def ground(path: Path, **keys: Any) -> Ground:
    terrain = FileTerrain(kind="file", file=path.name, **keys)
    return make_ground(terrain, TITAN, (0.0, 0.0, 0.0), 1, base=path.parent)


def of_fixture(name: str, *settings: str, scenario: str = "s.toml") -> Ground:
    return prepare(load_scenario(str(FIXTURES / name / scenario), settings)).ground


# the files of the cases


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "LA", "P"])
def test_a_grey_picture_of_any_mode_is_the_ground_of_the_grey_one(mode: str) -> None:
    grey = of_fixture("colour-mode-pictures")
    same = of_fixture("colour-mode-pictures", f"terrain.file={mode}.png")
    np.testing.assert_array_equal(same.heights, grey.heights)
    assert same.cell == grey.cell and same.origin == grey.origin


def test_the_top_of_a_picture_is_north() -> None:
    made = of_fixture("picture-upside-down")
    assert made.height_at(2.7, 1.7) > 0.1 > made.height_at(2.7, -1.7)


def test_an_esri_ascii_grid_loads_with_its_cell_and_its_first_row_in_the_north() -> None:
    made = of_fixture("esri-ascii-grid")
    lines = (FIXTURES / "esri-ascii-grid" / "ground.asc").read_text().splitlines()
    north, south = ([float(word) for word in lines[k].split()] for k in (6, -1))
    assert made.cell == 0.05 and made.heights.shape == (50, 60)
    np.testing.assert_allclose(made.heights[-1], north)
    np.testing.assert_allclose(made.heights[0], south)
    assert made.note.startswith("ESRI ASCII grid, 60 x 50 of 0.05 m")


def test_a_matrix_with_decimal_commas_is_the_matrix_with_points() -> None:
    made = of_fixture("csv-matrix-and-points")
    german = of_fixture("csv-matrix-and-points", "terrain.file=de.csv")
    np.testing.assert_array_equal(german.heights, made.heights)


def test_a_list_of_points_is_a_matrix_with_its_own_cell() -> None:
    made = of_fixture("csv-matrix-and-points", "terrain={kind='file', file='xyz.csv'}")
    points = np.genfromtxt(
        FIXTURES / "csv-matrix-and-points" / "xyz.csv", delimiter=",", names=True
    )
    assert made.cell == pytest.approx(0.25)
    x, y, z = points[17]
    assert made.heights[round(y / 0.25), round(x / 0.25)] == z


def test_a_geotiff_brings_its_pixel_size_and_its_nodata() -> None:
    made = of_fixture("geotiff-float32")
    values = tifffile.imread(FIXTURES / "geotiff-float32" / "ground.tif").astype(np.float64)
    assert made.cell == pytest.approx(0.05)
    holes = values[::-1] == -9999.0
    assert holes.any() and (np.isnan(made.heights) == holes).all()
    np.testing.assert_array_equal(made.heights[~holes], values[::-1][~holes])
    with pytest.raises(GroundError, match=r"has no height \(NODATA -9999; \d+ such\); set nan"):
        of_fixture("geotiff-float32", 'terrain={kind="file", file="ground.tif"}')


def test_heights_above_the_sea_are_brought_to_the_start_and_that_is_told() -> None:
    made = of_fixture("heights-above-the-sea")
    assert abs(made.heights).max() < 0.2 and made.height_at(0.0, 0.0) == 0.0
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


def test_a_staircase_from_a_mesh_has_no_hole_at_its_risers_and_its_true_heights() -> None:
    made = of_fixture("stairs-as-stl")
    assert not np.isnan(made.heights).any()
    levels = sorted({round(float(z), 6) for z in made.heights.ravel()})
    assert levels == [0.0, 0.1, 0.2, 0.3]


# kinds beyond the cases


@pytest.mark.parametrize("planes", [1, 2, 3, 4])
def test_pictures_of_16_bits_keep_them_all(tmp_path: Path, planes: int) -> None:
    levels = (np.arange(192).reshape(12, 16) * 257 + 3).astype(np.uint16)
    rows = np.repeat(levels[..., None], planes, axis=-1)
    if planes in (2, 4):
        rows[..., -1] = 65535
    writer = png.Writer(16, 12, bitdepth=16, greyscale=planes < 3, alpha=planes in (2, 4))
    with (tmp_path / "deep.png").open("wb") as file:
        writer.write(file, rows.reshape(12, -1).tolist())
    made = ground(tmp_path / "deep.png", cell=0.2)
    np.testing.assert_array_equal(made.heights, levels[::-1] / 65535.0)


def test_pixels_one_sees_through_are_holes(tmp_path: Path) -> None:
    picture = Image.new("RGBA", (16, 12), (51, 51, 51, 255))
    picture.putpixel((3, 0), (0, 0, 0, 0))
    picture.save(tmp_path / "clear.png")
    made = ground(tmp_path / "clear.png", cell=0.2, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[11, 3]]


@pytest.mark.parametrize("kind", ["u1", "i2", "u2", "i4", "f4", "f8"])
@pytest.mark.parametrize("compression", [None, "zlib"])
def test_tiffs_of_any_number_type_load_north_up(
    tmp_path: Path, kind: str, compression: str | None
) -> None:
    values = (np.arange(192).reshape(12, 16) % 9).astype(kind)
    tifffile.imwrite(tmp_path / "h.tif", values, compression=compression)
    made = ground(tmp_path / "h.tif", cell=0.2)
    np.testing.assert_array_equal(made.heights, values[::-1].astype(np.float64))


def geotiff(path: Path, scale: tuple[float, float], model: int) -> None:
    keys = (1, 1, 0, 1, 1024, 0, 1, model)
    tifffile.imwrite(path, HILL[::-1].astype(np.float32), extratags=[
        (33550, 12, 3, (*scale, 0.0), False), (34735, 3, len(keys), keys, False),
    ])  # fmt: skip


def test_pixels_in_degrees_are_answered_and_a_cell_in_metres_is_taken(tmp_path: Path) -> None:
    geotiff(tmp_path / "h.tif", (0.000278, 0.000278), 2)
    with pytest.raises(
        GroundError, match="degrees of longitude and latitude .* set cell in metres"
    ):
        ground(tmp_path / "h.tif")
    assert ground(tmp_path / "h.tif", cell=0.2).cell == 0.2


def test_unequal_pixels_are_interpolated_to_square_ones_and_that_is_told(tmp_path: Path) -> None:
    geotiff(tmp_path / "h.tif", (0.2, 0.4), 1)
    made = ground(tmp_path / "h.tif")
    assert made.cell == 0.2 and made.heights.shape == (24, 16)
    assert "interpolated to square cells of 0.2 m" in made.note
    assert made.heights[:, 3] == pytest.approx(np.interp(
        np.arange(24) * 0.2 + 0.1, np.arange(12) * 0.4 + 0.2, HILL[:, 3]), abs=1e-6)  # fmt: skip


def test_a_model_of_a_mountain_is_walked_at_its_true_size_around_the_start(tmp_path: Path) -> None:
    mountain = 437.0 + np.add.outer(np.arange(40) * 3.0, np.arange(40) * 1.5)
    tifffile.imwrite(
        tmp_path / "h.tif", mountain[::-1].astype(np.float32),
        extratags=[(33550, 12, 3, (30.0, 30.0, 0.0), False)],
    )  # fmt: skip
    made = ground(tmp_path / "h.tif")
    assert made.heights.shape == (1000, 1000) and made.cell == 0.05
    slope = (made.height_at(0.0, 5.0) - made.height_at(0.0, -5.0)) / 10.0
    assert slope == pytest.approx(0.1, abs=0.01)
    assert "40 x 40 of 30 m" in made.note and "around the start" in made.note


ASCII = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9999\n"
ROWS = "1 2 3 4\n5 6 7 8\n9 10 11 12\n"
WILD = {
    "as it is written": ASCII + ROWS,
    "Windows ends of lines": (ASCII + ROWS).replace("\n", "\r\n"),
    "keys in capitals and any order": "NROWS 3\nCELLSIZE 0.5\nNCOLS 4\nYLLCENTER 0\nXLLCENTER 0\n"
    + ROWS,
    "one number a line": ASCII + ROWS.replace(" ", "\n"),
    "rows that run on": ASCII + "1 2 3\n4 5 6 7 8 9\n10 11 12",
    "tabs": (ASCII + ROWS).replace(" ", "\t"),
    "decimal commas": ASCII.replace("0.5", "0,5") + ROWS.replace(" ", ",0 ").replace("\n", ",0\n"),
    "sides of their own": ASCII.replace("cellsize 0.5", "dx 0.5\ndy 0.5") + ROWS,
    "blanks before keys": ASCII.replace("\n", "\n  ") + ROWS,
    "a mark of the byte order": "\ufeff" + ASCII + ROWS,
}


@pytest.mark.parametrize("what", WILD)
def test_an_ascii_grid_loads_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.asc").write_bytes(WILD[what].encode("utf-8"))
    made = ground(tmp_path / "h.asc", scale=0.1)
    np.testing.assert_allclose(made.heights * 10, [[9, 10, 11, 12], [5, 6, 7, 8], [1, 2, 3, 4]])
    assert made.cell == 0.5


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (ASCII + "1 2 3\n", "3 x 4 heights are announced, 3 are there"),
        (ASCII + ROWS.replace("7", "seven"), "heights must be numbers"),
        ("ncols 4\n" + ROWS, "no nrows in its header"),
        ("ncols four\nnrows 3\n" + ROWS, "ncols must be a number, got 'four'"),
        ("ncols 70000\nnrows 70000\n1 2", "70000 x 70000 cells; at most"),
        ("hello 4\n" + ROWS, "unknown header key 'hello'"),
    ],
)
def test_an_ascii_grid_that_is_none_is_refused_with_what_is_wrong(
    tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "h.asc").write_text(text)
    with pytest.raises(GroundError, match=says):
        ground(tmp_path / "h.asc")


MATRICES = {
    "commas": "1,2.5,3\n4,5,6\n",
    "semicolons": "1;2.5;3\n4;5;6\n",
    "semicolons and decimal commas": "1;2,5;3\n4;5;6,0\n",
    "tabs": "1\t2.5\t3\n4\t5\t6\n",
    "blanks": "1 2.5 3\n4 5 6\n",
    "trailing commas": "1,2.5,3,\n4,5,6,\n",
    "Windows ends of lines and a comment": "# heights\r\n1, 2.5, 3\r\n4, 5, 6\r\n",
}


@pytest.mark.parametrize("what", MATRICES)
def test_a_matrix_loads_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.csv").write_bytes(MATRICES[what].encode())
    made = ground(tmp_path / "h.csv", cell=0.5)
    np.testing.assert_array_equal(made.heights, [[4.0, 5.0, 6.0], [1.0, 2.5, 3.0]])


def test_points_beside_a_grid_are_refused_with_the_first_of_them(tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text("x,y,z\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n0.53,0.5,5\n")
    with pytest.raises(GroundError, match="points must lie on a grid"):
        ground(tmp_path / "h.csv")


def box(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
    import trimesh

    made = trimesh.creation.box(bounds=[low, high])
    return np.asarray(made.triangles)


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
def test_the_upper_surface_of_a_mesh_is_the_ground(tmp_path: Path, suffix: str) -> None:
    import trimesh

    floor = trimesh.creation.box(bounds=[[-2, -2, -0.1], [2, 2, 0.0]])
    step = trimesh.creation.box(bounds=[[0.5, -2, 0.0], [1.0, 2, 0.15]])
    trimesh.util.concatenate([floor, step]).export(tmp_path / f"m.{suffix}")
    made = ground(tmp_path / f"m.{suffix}")
    assert made.cell == 0.025 and made.bounds == pytest.approx((-2.0, 2.0, -2.0, 2.0))
    assert made.height_at(0.2, 0.3) == pytest.approx(0.0, abs=1e-6)
    assert made.height_at(0.7, 0.3) == pytest.approx(0.15, abs=1e-6)


def test_a_mesh_in_millimetres_is_brought_to_metres_by_scale(tmp_path: Path) -> None:
    triangles = box((-2000.0, -2000.0, -50.0), (2000.0, 2000.0, 0.0))
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles)
    (tmp_path / "m.stl").write_bytes(b" " * 80 + struct.pack("<I", len(triangles)) + facets)
    made = ground(tmp_path / "m.stl", scale=0.001)
    assert made.bounds == pytest.approx((-2.0, 2.0, -2.0, 2.0)) and made.level == 0.0


@pytest.mark.parametrize("suffix", ["npy", "png", "tif"])
def test_one_limit_for_all_formats_and_the_thinning_is_told(tmp_path: Path, suffix: str) -> None:
    side = 2100
    values = np.zeros((side, side), dtype=np.uint8)
    path = tmp_path / f"h.{suffix}"
    if suffix == "npy":
        np.save(path, values)
    elif suffix == "png":
        Image.fromarray(values).save(path)
    else:
        tifffile.imwrite(path, values)
    made = ground(path, cell=0.05)
    assert made.heights.size <= CELLS_MAX and made.cell == 0.1
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
