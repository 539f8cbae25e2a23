"""The table of ``walking-console bench``."""

import io

from rich.console import Console

from walking_console.server.benchmark_table import print_figures

FIGURES = {
    "version": "0.2.0",
    "python": "3.11.7",
    "figures": {
        "plan": {"value": 1.25, "unit": "ms", "target": "under 5"},
        "headless": {"value": 80.0, "unit": "times life", "target": "over 20"},
    },
}


def test_every_figure_is_a_row_with_value_unit_and_target() -> None:
    said = io.StringIO()
    print_figures(FIGURES, Console(file=said, width=120))
    rows = [line for line in said.getvalue().splitlines() if "plan" in line or "headless" in line]
    assert len(rows) == 2
    for row, entry in zip(rows, FIGURES["figures"].values(), strict=True):
        assert f"{entry['value']:g}" in row and entry["unit"] in row and entry["target"] in row
    assert "walking-console 0.2.0, Python 3.11.7" in said.getvalue()
