"""Two measurements of ``bench`` against each other: what a change has made faster or slower."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

# of a walk, the figures that are compared: milliseconds, and simulated over processor time
WALK_FIGURES = ("median", "p99", "p999", "largest", "per_metre", "factor")
# what two walks must have alike to be the same one
WALKED = ("scenario", "planner", "plant", "sensing", "seconds")


class ComparisonError(ValueError):
    """A file that holds nothing to compare with; the message is one clear line."""


class Ratio(NamedTuple):
    """One figure now and in the other file, in its own unit."""

    what: str
    figure: str
    now: float
    before: float

    @property
    def ratio(self) -> float:
        """Now over before: under 1 is less time, and of a factor or a speed over 1 is faster."""
        return self.now / self.before


def compared(now: dict[str, Any], before: Any) -> list[Ratio]:
    """Every figure that both measurements hold. Raises ``ComparisonError`` where there is none."""
    if not isinstance(before, dict):
        raise ComparisonError("this is no file of bench --json")
    try:
        ratios = [*_of_figures(now, before), *_of_walks(now, before)]
    except (AttributeError, KeyError, TypeError):
        raise ComparisonError("this is no file of bench --json") from None
    if not ratios:
        raise ComparisonError("no figure is in both measurements: were other walks timed?")
    return ratios


def _of_figures(now: dict[str, Any], before: dict[str, Any]) -> Iterator[Ratio]:
    others = before.get("figures", {})
    for name, entry in now.get("figures", {}).items():
        other = others.get(name)
        if other is not None and other["value"] > 0.0:
            yield Ratio(name, entry["unit"], entry["value"], other["value"])


def _of_walks(now: dict[str, Any], before: dict[str, Any]) -> Iterator[Ratio]:
    others = {_walk(entry): entry for entry in before.get("walks", [])}
    for entry in now.get("walks", []):
        other = others.get(_walk(entry))
        if other is None:
            continue
        for figure in WALK_FIGURES:
            if entry[figure] is not None and other[figure]:
                yield Ratio(named(entry), figure, entry[figure], other[figure])


def _walk(entry: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(entry[key] for key in WALKED)


def named(entry: dict[str, Any]) -> str:
    """The walk as tables name it."""
    return " ".join(str(entry[key]) for key in WALKED[:-1])
