"""The table of docs/faults.md: a row for every fault, written anew when that fault is tried."""

from __future__ import annotations

import re
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

PAGE = Path(__file__).resolve().parents[3] / "docs/faults.md"
HEAD = "| fault | what must happen | measured | held | when, and by which command |"
ROW = re.compile(r"\| (.+?) \| .* \|$")


@dataclass(frozen=True)
class Outcome:
    """What came of the trials of one fault."""

    measured: str
    held: bool


@dataclass(frozen=True)
class Fault:
    """A fault, what must happen, and how it is tried so many times."""

    key: str  # on the command line
    title: str
    must: str
    trials: Callable[[int], Outcome]
    most: int = 10_000  # trials that make sense of it; more are not made

    def row(self, outcome: Outcome, count: int) -> str:
        """Its line of the table, as of today."""
        held = "yes" if outcome.held else "**no**"
        command = f"{date.today()}, `{self.key} --count {count}`"
        return f"| {self.title} | {self.must} | {outcome.measured} | {held} | {command} |"


def spread(seconds: Sequence[float | None], limit: float) -> Outcome:
    """How long each trial took, None for one that never ended; held where all are in time."""
    times = [one for one in seconds if one is not None]
    good = sum(one <= limit for one in times)
    if not times:
        return Outcome(f"0 of {len(seconds)}", False)
    typical, worst = 1000 * statistics.median(times), 1000 * max(times)
    said = f"{good} of {len(seconds)}; median {typical:.0f}, worst {worst:.0f} ms"
    return Outcome(said, good == len(seconds))


def share(values: Sequence[float], part: float) -> float:
    """The value below which this part of all lies."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


def kept_rows(text: str) -> dict[str, str]:
    """The rows of a page by the title of their fault."""
    found = (ROW.fullmatch(line) for line in text.splitlines())
    return {row[1]: row[0] for row in found if row}


def write(faults: Sequence[Fault], new: dict[str, str]) -> None:
    """Put new rows into the page, in the order of the faults; what was not tried stays."""
    text = PAGE.read_text("utf-8")
    rows = kept_rows(text) | new
    before, _, after = text.partition(HEAD)
    rest = "\n".join(line for line in after.splitlines()[2:] if not line.startswith("|"))
    table = [HEAD, "|---|---|---|---|---|", *(rows[f.title] for f in faults if f.title in rows)]
    PAGE.write_text(before + "\n".join(table) + "\n" + rest.rstrip("\n") + "\n", "utf-8")
