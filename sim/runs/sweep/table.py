"""The table of a sweep: a row a run, as CSV always and as Parquet where pyarrow is installed."""

from __future__ import annotations

import csv
import importlib.util
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from walking_console.sim.scenario_files import plain_value

from .grid import Axis

CSV = "table.csv"
PARQUET = "table.parquet"
# columns after those of the axes, with the type each has
FIGURES: dict[str, type] = {
    "seed": int,
    "result": str,
    "passed": bool,
    "reason": str,
    "unmet": str,
    "seconds": float,
    "distance": float,
    "mean_speed": float,
    "steps": int,
    "margin_min": float,
    "polygon_margin_min": float,
    "forbidden_steps": int,
    "falls": int,
    "emergent": int,
    "state_hash": str,
    "directory": str,
}

TableRow = dict[str, Any]


def axis_column(key: str) -> str:
    """How the column of a setting is called: a figure of the same name keeps it for itself."""
    is_taken = key == "run" or (key in FIGURES and key != "seed")
    return f"set {key}" if is_taken else key


def columns(axes: Sequence[Axis]) -> list[str]:
    """Names of all columns, in order."""
    figures = [name for name in FIGURES if name != "seed" or all(a.key != "seed" for a in axes)]
    return ["run", *(axis_column(axis.key) for axis in axes), *figures]


def write_tables(folder: Path, axes: Sequence[Axis], rows: Sequence[TableRow]) -> None:
    """Write the rows, sorted by run; each file is there whole or not at all."""
    ordered = sorted(rows, key=lambda row: int(row["run"]))
    _write_csv(folder / CSV, columns(axes), ordered)
    if importlib.util.find_spec("pyarrow") is not None:
        _write_parquet(folder / PARQUET, axes, ordered)


def _write_csv(path: Path, names: Sequence[str], rows: Sequence[TableRow]) -> None:
    """Numbers as ``repr`` has them: read back they are the same to the last bit."""
    beside = path.with_suffix(".part")
    with beside.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for row in rows:
            writer.writerow([_cell(row.get(name)) for name in names])
    os.replace(beside, path)


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool):
        return int(value)
    return repr(value) if isinstance(value, float) else value


def _write_parquet(path: Path, axes: Sequence[Axis], rows: Sequence[TableRow]) -> None:
    import pyarrow as arrow
    from pyarrow import parquet

    kinds = {str: arrow.string(), float: arrow.float64(), int: arrow.int64(), bool: arrow.bool_()}
    types = {"run": int, **{axis_column(axis.key): axis_type(axis) for axis in axes}, **FIGURES}
    names = columns(axes)
    schema = arrow.schema([(name, kinds[types[name]]) for name in names])
    values = [{name: _typed(row.get(name), types[name]) for name in names} for row in rows]
    beside = path.with_suffix(".part")
    parquet.write_table(arrow.Table.from_pylist(values, schema=schema), beside)
    os.replace(beside, path)


def axis_type(axis: Axis) -> type:
    """What all values of a setting are: whole numbers, numbers, or words."""
    kinds = {type(plain_value(value)) for value in axis.values}
    if kinds == {int}:
        return int
    return float if kinds <= {int, float} else str


def _typed(value: Any, wanted: type) -> Any:
    return None if value is None else wanted(value)


def read_table(folder: Path) -> Iterator[dict[str, str]]:
    """The rows of a table as CSV has them, words all; raises ``OSError`` where there is none."""
    with (folder / CSV).open(newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)
