"""Which figures there are, which sheet draws each, and the walks it is drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .run_data import Recipe

LIFT = "lift"
PACE = "pace"
# m and m/s, of which H fig. 16 has a line each
LINES = {LIFT: (0.05, 0.1, 0.2), PACE: (0.2, 0.4, 0.8)}
MARKS = {LIFT: (0.02, 0.05, 0.1, 0.15, 0.2), PACE: (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)}


@dataclass(frozen=True)
class CatalogueEntry:
    """What one figure shows, the name of the function that makes its sheet, and the walks it needs;
    ``--run`` may give the first of them.
    """

    title: str
    sheet: str
    walks: Mapping[str, Recipe]


def _one(scenario: str) -> dict[str, Recipe]:
    return {"walk": Recipe(scenario)}


def _odd_posture() -> dict[str, Recipe]:
    """fig. 6c: the domain methods, and the rule that paper warns of, from the same posture."""
    return _one("fig6c") | {"naive": Recipe("fig6c", ("mode=naive", "expect={}"))}


def _lifting(lift: float) -> tuple[str, ...]:
    """Settings for h_up, m, and twice as much down."""
    return f"gait.lift_up={lift:.3f}", f"gait.lift_down={2 * lift:.3f}"


def _sweep() -> dict[str, Recipe]:
    """fig. 16: every h_up with each v_up that has a line, and the other way round."""
    across = {(h, v) for h in MARKS[LIFT] for v in LINES[PACE]}
    along = {(h, v) for h in LINES[LIFT] for v in MARKS[PACE]}
    short = ("end={time=300.0, distance=1.6}", "expect={}")
    walks = {
        f"{h:g} m {v:g} m/s": Recipe("fig16", (*_lifting(h), *short), v)
        for h, v in sorted(across | along)
    }
    return _one("fig16") | walks


UP = "Up five steps"
DOWN = "Down five steps"
ODD = "From an odd posture: maximum strides, and the search domains"
SEARCH = "How each step searches its domain between holes"
SPEED = "Body speed against height and velocity of the lift"

FIGURES: dict[str, CatalogueEntry] = {
    "fig6a": CatalogueEntry("Standard crab walk along x, α = 16°", "standard_walk", _one("fig6a")),
    "fig6b": CatalogueEntry("Standard crab walk along y, α = 74°", "standard_walk", _one("fig6b")),
    "fig6c": CatalogueEntry(ODD, "odd_posture", _odd_posture()),
    "fig12": CatalogueEntry(SEARCH, "search_domains", _one("fig12")),
    "fig13": CatalogueEntry("Across a river as wide as the stride", "river", _one("fig13")),
    "fig14": CatalogueEntry(
        "Round large holes and back to the commanded line", "detour", _one("fig14")
    ),
    "fig15": CatalogueEntry("Height of the body over steps", "heights", _one("fig15")),
    "fig16": CatalogueEntry(SPEED, "speeds", _sweep()),
    "fig17-up": CatalogueEntry(UP, "stairs", _one("fig17-up")),
    "fig17-down": CatalogueEntry(DOWN, "stairs", _one("fig17-down")),
    "fig19": CatalogueEntry("Over a block found by touch", "block", _one("fig19")),
    "omni": CatalogueEntry("Through every direction", "directions", _one("omni")),
}
