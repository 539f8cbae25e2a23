"""Matrices and lists of points as spreadsheets, pandas and lidar tools write them."""

from pathlib import Path

import numpy as np
import pytest

from tests.sim.terrain.readers.files import ground
from walking_console.sim.terrain.generators import GroundError

NORTH = np.add.outer(np.arange(6) ** 2, np.arange(7)) % 5 / 10.0 + 0.02  # first row north
WORDS = [[f"{value:.2f}" for value in row] for row in NORTH]
GERMAN = [[word.replace(".", ",") for word in row] for row in WORDS]
COLUMNS = ",".join(str(k) for k in range(7))


def lines(rows: list[list[str]], separator: str) -> str:
    return "\n".join(separator.join(row) for row in rows)


def numbered(separator: str = ",") -> str:
    return lines([[str(k), *row] for k, row in enumerate(WORDS)], separator)


MATRICES = {
    "a heading of words": lines([["a b"] * 7, *WORDS], ","),
    "quotes": lines([[f'"{word}"' for word in row] for row in WORDS], ","),
    "quotes around decimal commas": lines([[f'"{word}"' for word in row] for row in GERMAN], ","),
    "decimal commas between blanks": lines(GERMAN, " "),
    "decimal commas between tabs": lines(GERMAN, "\t"),
    "decimal commas and semicolons, BOM, CRLF": "\ufeff" + lines(GERMAN, ";").replace("\n", "\r\n"),
    "the numbers pandas writes": f",{COLUMNS}\n" + numbered(),
    "the column numbers of pandas": f"{COLUMNS}\n" + lines(WORDS, ","),
    "ends of lines of an old Macintosh": lines(WORDS, ",").replace("\n", "\r"),
}


@pytest.mark.parametrize("what", MATRICES)
def test_a_matrix_loads_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.csv").write_bytes(MATRICES[what].encode())
    made = ground(tmp_path / "h.csv", cell=0.5)
    np.testing.assert_allclose(made.heights, NORTH[::-1], atol=1e-12)


@pytest.mark.parametrize("corner", ["", "y/x"])
@pytest.mark.parametrize("south", [False, True])
def test_places_at_the_edges_give_the_cell_and_the_way_up(
    tmp_path: Path, corner: str, south: bool
) -> None:
    way = -1 if south else 1
    y = (2.5 - 0.5 * np.arange(6))[::way]
    body = [[str(place), *row] for place, row in zip(y, WORDS[::way], strict=True)]
    (tmp_path / "h.csv").write_text(
        lines([[corner, *(f"{k * 0.5}" for k in range(7))], *body], ",")
    )
    made = ground(tmp_path / "h.csv")
    np.testing.assert_allclose(made.heights, NORTH[::-1], atol=1e-12)
    assert made.cell == 0.5


@pytest.mark.parametrize("separator", [";", "\t", " "])
@pytest.mark.parametrize("row", range(4))
def test_one_decimal_comma_among_whole_numbers_tells_what_all_commas_are(
    tmp_path: Path, row: int, separator: str
) -> None:
    words = [["1", "-2", "3"] for _ in range(4)]
    words[row][1] = "-2,5"
    (tmp_path / "h.csv").write_text(lines(words, separator))
    made = ground(tmp_path / "h.csv", cell=0.5)
    assert made.heights[:, 1].tolist() == [-2.5 if 3 - k == row else -2.0 for k in range(4)]


def test_a_minus_that_is_no_hyphen_is_one(tmp_path: Path) -> None:
    text = lines(WORDS, ",").replace("0.", "\N{MINUS SIGN}0.")
    (tmp_path / "h.csv").write_text(text, encoding="utf-8")
    np.testing.assert_allclose(ground(tmp_path / "h.csv", cell=0.5).heights, -NORTH[::-1])


@pytest.mark.parametrize("row", [0, 3])
@pytest.mark.parametrize("column", [0, 6])
def test_an_empty_place_is_a_hole_wherever_it_is(tmp_path: Path, row: int, column: int) -> None:
    words = [list(each) for each in WORDS]
    words[row][column] = ""
    (tmp_path / "h.csv").write_text(lines(words, ","))
    made = ground(tmp_path / "h.csv", cell=0.5, nan="hole")
    assert np.argwhere(np.isnan(made.heights)).tolist() == [[5 - row, column]]
    with pytest.raises(GroundError, match='is NaN; set nan = "hole"'):
        ground(tmp_path / "h.csv", cell=0.5)


@pytest.mark.parametrize("row", [0, 3])
def test_a_word_among_heights_is_refused_in_any_row(tmp_path: Path, row: int) -> None:
    words = [list(each) for each in WORDS]
    words[row][0] = "abc"
    (tmp_path / "h.csv").write_text(lines(words, ","))
    with pytest.raises(GroundError, match=f"line {row + 1} holds what is no number: 'abc'"):
        ground(tmp_path / "h.csv")


# -- points

PLACES = [(0.25 * c, 0.25 * (5 - r), NORTH[r, c]) for r, c in np.ndindex(NORTH.shape)]
SHUFFLED = [PLACES[k * 17 % len(PLACES)] for k in range(len(PLACES))]


def points(heading: str, order: tuple[int, ...] = (0, 1, 2), more: float | None = None) -> str:
    """The points in another order of rows and columns, with a further column."""
    rows = [[place[k] for k in order] + ([] if more is None else [more]) for place in SHUFFLED]
    body = "\n".join(",".join(f"{value:.3f}" for value in row) for row in rows)
    return f"{heading}\n{body}" if heading else body


LISTS = {
    "no heading": points(""),
    "x, y and z": points("x,y,z"),
    "units": points("X [m],Y [m],Height (m)"),
    "the height first": points("elevation,x,y", (2, 0, 1)),
    "a further column": points("", more=7.0),
    "surveyors' words": points("Easting,Northing,Elevation"),
    "semicolons and decimal commas": points("x,y,z").replace(",", ";").replace(".", ","),
    "their number before them": f"{len(PLACES)}\n" + points(""),
    "quoted names": points('"x","y","z"'),
}


@pytest.mark.parametrize("what", LISTS)
def test_points_in_any_order_are_a_map_with(tmp_path: Path, what: str) -> None:
    (tmp_path / "h.csv").write_text(LISTS[what])
    made = ground(tmp_path / "h.csv")
    np.testing.assert_allclose(made.heights, NORTH[::-1], atol=1e-9)
    assert made.cell == 0.25


@pytest.mark.parametrize("decimals", [2, 6])
def test_points_far_from_0_are_a_map_of_square_cells(tmp_path: Path, decimals: int) -> None:
    rows = [(437123.25 + x, 5312345.75 + y, z) for x, y, z in PLACES]
    body = "\n".join(f"{x:.{decimals}f} {y:.{decimals}f} {z:.3f}" for x, y, z in rows)
    (tmp_path / "h.xyz").write_text(body)
    made = ground(tmp_path / "h.xyz")
    np.testing.assert_allclose(made.heights, NORTH[::-1], atol=1e-12)
    assert made.cell == pytest.approx(0.25) and "interpolated" not in made.note


def test_points_a_rounding_apart_are_of_square_cells(tmp_path: Path) -> None:
    rows = [(437123.21 + 0.2 * x, 5312345.77 + 0.2 * y, z) for x, y, z in PLACES]
    (tmp_path / "h.xyz").write_text("\n".join(f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in rows))
    assert ground(tmp_path / "h.xyz").note == "point list, 7 x 6 of 0.05 m"


def test_a_place_without_a_point_is_a_hole(tmp_path: Path) -> None:
    (tmp_path / "h.xyz").write_text("\n".join(points("").replace(",", " ").split("\n")[1:]))
    made = ground(tmp_path / "h.xyz", nan="hole")
    assert int(np.isnan(made.heights).sum()) == 1


@pytest.mark.parametrize("name", ["h.xyz", "h.csv"])
def test_points_anywhere_are_no_map_and_no_matrix(tmp_path: Path, name: str) -> None:
    scattered = np.random.default_rng(1).random((200, 3))
    np.savetxt(tmp_path / name, scattered, delimiter=" " if name.endswith("xyz") else ",")
    with pytest.raises(GroundError, match="points must lie on a grid"):
        ground(tmp_path / name)


def test_points_by_longitude_and_latitude_say_the_cell_in_metres(tmp_path: Path) -> None:
    text = points("longitude,latitude,z").split("\n")
    (tmp_path / "h.csv").write_text("\n".join(text))
    with pytest.raises(GroundError, match="degrees of longitude and latitude .* that is cell"):
        ground(tmp_path / "h.csv")
