"""The table of ``walking-console bench``."""

from __future__ import annotations

from typing import Any

from rich.console import Console as Terminal
from rich.table import Table


def print_figures(figures: dict[str, Any], terminal: Terminal) -> None:
    """Every figure with its value, unit and target."""
    title = (
        f"walking-console {figures['version']}, Python {figures['python']}, "
        "medians of processor time"
    )
    table = Table(title=title, title_justify="left")
    for column in ("figure", "value", "unit", "target"):
        table.add_column(column, justify="right" if column == "value" else "left")
    for name, entry in figures["figures"].items():
        table.add_row(name, f"{entry['value']:g}", entry["unit"], entry["target"])
    terminal.print(table)
