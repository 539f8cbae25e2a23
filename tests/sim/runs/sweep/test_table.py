"""The table of a sweep as CSV and Parquet."""

from pathlib import Path

import pytest

from walking_console.sim.runs.sweep.grid import Axis
from walking_console.sim.runs.sweep.table import (
    CSV,
    PARQUET,
    axis_type,
    columns,
    read_table,
    write_tables,
)

AXES = (Axis("terrain.fraction", ("0.3", "1")), Axis("result", ("a", "b")))
ROWS = [
    {"run": 1, "terrain.fraction": "1", "set result": "b", "seed": 4, "result": "blocked",
     "passed": False, "seconds": 1 / 3, "steps": 7, "margin_min": None},
    {"run": 0, "terrain.fraction": "0.3", "set result": "a", "seed": 3, "result": "completed",
     "passed": True, "seconds": 2.0, "steps": 5, "margin_min": -0.0, "reason": 'said "no", left'},
]  # fmt: skip


def test_rows_stand_in_order_and_numbers_keep_every_bit(tmp_path: Path):
    write_tables(tmp_path, AXES, ROWS)
    first, second = read_table(tmp_path)
    assert (first["run"], second["run"]) == ("0", "1")
    assert float(second["seconds"]) == 1 / 3 and second["margin_min"] == ""
    assert first["reason"] == 'said "no", left' and first["passed"] == "1"


def test_parquet_holds_the_same_with_types(tmp_path: Path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_tables(tmp_path, AXES, ROWS)
    table = parquet.read_table(tmp_path / PARQUET)
    assert table.column_names == columns(AXES)
    first, second = table.to_pylist()
    assert first["terrain.fraction"] == 0.3 and first["set result"] == "a"
    assert second["passed"] is False and second["margin_min"] is None and second["steps"] == 7


def test_a_setting_called_like_a_figure_does_not_hide_it():
    names = columns(AXES)
    assert "set result" in names and "result" in names and len(set(names)) == len(names)


def test_a_seed_that_is_set_is_one_column():
    assert columns((Axis("seed", ("1", "2")),)).count("seed") == 1


@pytest.mark.parametrize(
    ("values", "kind"), [(("1", "2"), int), (("1", "0.5"), float), (("1", "paper"), str)]
)
def test_values_are_numbers_where_all_of_them_are(values, kind):
    assert axis_type(Axis("key", values)) is kind


def test_a_table_is_replaced_whole(tmp_path: Path):
    write_tables(tmp_path, AXES, ROWS)
    write_tables(tmp_path, AXES, ROWS[:1])
    assert len(list(read_table(tmp_path))) == 1
    assert not list(tmp_path.glob("*.part")) and (tmp_path / CSV).exists()
