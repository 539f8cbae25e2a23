"""Heights as text: ASCII grids as found in the wild, matrices and point lists."""

from pathlib import Path

import numpy as np
import pytest

from tests.sim.terrain.readers.files import FIXTURES, ground, of_fixture
from walking_console.sim.terrain.generators import GroundError

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
    "commas": ASCII + ROWS.replace(" ", ","),
    "commas and blanks": ASCII + ROWS.replace(" ", ", "),
    "semicolons": ASCII + ROWS.replace(" ", ";"),
    "old ends of lines": (ASCII + ROWS).replace("\n", "\r"),
    "comments before it": "# made by hand\n! twice\n" + ASCII + ROWS,
    "equals signs": ASCII.replace(" ", " = ") + ROWS,
    "colons": ASCII.replace(" ", ": ") + ROWS,
    "NODATA that is no number": ASCII.replace("-9999", "NaN") + ROWS,
    "edges as GRASS says them": "north: 1.5\nsouth: 0\neast: 2\nwest: 0\nrows: 3\ncols: 4\n" + ROWS,
    "a mark of the byte order": "\ufeff" + ASCII + ROWS,
    "equals signs without blanks": ASCII.replace(" ", "=") + ROWS,
    "a header in one line": ASCII.replace("\n", " ") + "\n" + ROWS,
    "comments behind what is said": ASCII.replace("\n", "   # so\n") + ROWS.replace("\n", " # x\n"),
    "two keys a line": ASCII.replace("\nnrows", "  NROWS") + ROWS,
    "decimal commas in the last row alone": ASCII.replace("0.5", "0,5")
    + ROWS.replace("12", "12,0"),
    "the grid of Surfer": "DSAA\n4 3\n0.25 1.75\n0.25 1.25\n1 12\n9 10 11 12\n5 6 7 8\n1 2 3 4\n",
}
MATRICES = {
    "commas": "1,2.5,3\n4,5,6\n",
    "semicolons": "1;2.5;3\n4;5;6\n",
    "semicolons and decimal commas": "1;2,5;3\n4;5;6,0\n",
    "tabs": "1\t2.5\t3\n4\t5\t6\n",
    "blanks": "1 2.5 3\n4 5 6\n",
    "trailing commas": "1,2.5,3,\n4,5,6,\n",
    "a comment behind numbers": "1,2.5,3  # the north\n4,5,6\n",
    "Windows ends of lines and a comment": "# heights\r\n1, 2.5, 3\r\n4, 5, 6\r\n",
}


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


@pytest.mark.parametrize("what", WILD)
def test_an_ascii_grid_loads_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.asc").write_bytes(WILD[what].encode("utf-8"))
    made = ground(tmp_path / "h.asc", scale=0.1)
    np.testing.assert_allclose(made.heights * 10, [[9, 10, 11, 12], [5, 6, 7, 8], [1, 2, 3, 4]])
    assert made.cell == 0.5


@pytest.mark.parametrize("name", ["h.txt", "h.grd", "h.csv", "h.dat"])
def test_an_ascii_grid_is_known_by_its_keys_whatever_the_file_is_called(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / name).write_text(ASCII + ROWS)
    assert ground(tmp_path / name, scale=0.1).cell == 0.5


@pytest.mark.parametrize("word", ["nan", "NaN", "*", "null"])
def test_a_word_for_no_height_is_a_hole(tmp_path: Path, word: str) -> None:
    (tmp_path / "h.asc").write_text(ASCII + f"{word} " + ROWS[2:])
    made = ground(tmp_path / "h.asc", scale=0.1, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[2, 0]]


def test_what_surfer_writes_for_no_height_is_a_hole(tmp_path: Path) -> None:
    (tmp_path / "h.grd").write_text("DSAA\n2 2\n0 1\n0 1\n0 1\n0 1.70141e+038\n0.5 1\n")
    made = ground(tmp_path / "h.grd", nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[0, 1]] and made.cell == 1.0


@pytest.mark.parametrize("corner", [(11.0, 47.0), (0.5, 0.5)])
def test_a_grid_in_degrees_says_the_cell_in_metres(
    tmp_path: Path, corner: tuple[float, float]
) -> None:
    head = f"ncols 4\nnrows 3\nxllcorner {corner[0]}\nyllcorner {corner[1]}\ncellsize 0.00083333\n"
    (tmp_path / "h.asc").write_text(head + ROWS)
    with pytest.raises(GroundError, match=f"at latitude {corner[1]:g} that is cell = "):
        ground(tmp_path / "h.asc")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (ASCII + "1 2 3\n", "3 x 4 heights are announced, 3 are there"),
        (ASCII + ROWS.replace("7", "seven"), "heights must be numbers"),
        ("ncols 4\n" + ROWS, "no nrows in its header"),
        ("", "it is empty"),
        ("ncols four\nnrows 3\n" + ROWS, "ncols must be a number, got 'four'"),
        ("ncols 70000\nnrows 70000\n1 2", "70000 x 70000 cells; at most"),
        ("hello 4\n" + ROWS, "unknown header key 'hello'"),
        ("DSAA\n4 3\n0 1 0 1\n" + ROWS, "a Surfer grid has counts and x, y, z from and to"),
        ("DSAA\n4 3\n0 1\n0 1\n0 1\n1 2 3\n", "3 x 4 heights are announced, 3 are there"),
        ("CDF\x01\0\0\0\0", r"text is wanted, and it is binary: it begins with b'CDF\\x01'"),
    ],
)
def test_an_ascii_grid_that_is_none_is_refused_with_what_is_wrong(
    tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "h.asc").write_text(text)
    with pytest.raises(GroundError, match=says):
        ground(tmp_path / "h.asc")


@pytest.mark.parametrize("what", MATRICES)
def test_a_matrix_loads_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.csv").write_bytes(MATRICES[what].encode())
    made = ground(tmp_path / "h.csv", cell=0.5)
    np.testing.assert_array_equal(made.heights, [[4.0, 5.0, 6.0], [1.0, 2.5, 3.0]])


def test_points_beside_a_grid_are_refused_with_the_first_of_them(tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text("x,y,z\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n0.53,0.5,5\n")
    with pytest.raises(GroundError, match="points must lie on a grid"):
        ground(tmp_path / "h.csv")
