"""Colours, thresholds and leg names of everything that is drawn: scene, page and figures alike.

The server sends them to the page as its *style* (``style_of``); the page holds none of its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from walking_console.planner.robot.model import Leg, Machine

RGB = tuple[int, int, int]  # sRGB, 0-255

# One colour a leg, in machine order. Told apart by protanopes and deuteranopes too: no two of them
# are nearer than 11 (CIEDE2000, dichromacy after Machado et al. 2009); wrong: two legs look alike.
LEGS = (
    "#1f86d8", "#00936a", "#e0661a", "#b457a0", "#ff87a5", "#b43c2d", "#4bb4e1", "#ff0069",
)  # fmt: skip
GOOD = "#4ad295"
WARN = "#ffb03b"
BAD = "#ff6257"
PATH = "#4cc9f0"  # what is commanded, and the preview as far as the walk is sure

# m, polygon or longitudinal margin that is drawn fully green; larger: good walks look risky
MARGIN_GOOD = 0.03

# Share of white that the page's film-like tone mapping adds to a colour in the scene. Larger:
# colours there look darker than the same ones on the page; smaller: paler.
TONE_MAPPED = 0.28

MIDLINE = 0.02  # m; a leg whose reach is centred this near to y = 0 is on neither side
ALONG = {1: "M", 2: "FR", 3: "FMR"}  # front, middle, rear: letters for so many legs in one row
NAME_MAX = 3  # characters of a leg's short name; longer ones do not fit beside the gait diagram


def rgb(colour: str) -> RGB:
    """The channels of "#rrggbb"."""
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return red, green, blue


def for_scene(colour: str) -> RGB:
    """A colour that looks like ``colour`` once the page's renderer has mapped its tones."""
    red, green, blue = (
        min(max(round((channel - 255 * TONE_MAPPED) / (1 - TONE_MAPPED)), 0), 255)
        for channel in rgb(colour)
    )
    return red, green, blue


def margin_share(margin: float) -> float:
    """How good a margin (m) is, 0 to 1: 0 at none, 1 from ``MARGIN_GOOD`` on."""
    return min(max(margin / MARGIN_GOOD, 0.0), 1.0) if math.isfinite(margin) else 0.0


def leg_names(legs: Sequence[Leg]) -> tuple[str, ...]:
    """A short name for every leg, in machine order: FL, RL, RR, FR.

    The initials of the names the machine gives its legs; where those do not tell them apart, the
    place on the side it stands on.
    """
    names = tuple("".join(word[0].upper() for word in leg.name.split()) for leg in legs)
    told_apart = len(set(names)) == len(names) and all(0 < len(n) <= NAME_MAX for n in names)
    return names if told_apart else _names_by_place(legs)


def _names_by_place(legs: Sequence[Leg]) -> tuple[str, ...]:
    """Front to rear letters (numbers between four or more) with L or R; the midline has no side."""
    names = [""] * len(legs)
    for side in ("L", "", "R"):
        row = [index for index, leg in enumerate(legs) if _side(leg) == side]
        row.sort(key=lambda index: -legs[index].centre[0])
        for place, index in enumerate(row):
            names[index] = f"{_along(place, len(row), legs[index])}{side}"
    return tuple(names)


def _side(leg: Leg) -> str:
    y = leg.centre[1]
    if abs(y) < MIDLINE:
        return ""
    return "L" if y > 0.0 else "R"


def _along(place: int, count: int, leg: Leg) -> str:
    if count == 1 and abs(leg.centre[0]) > MIDLINE:
        return "F" if leg.centre[0] > 0.0 else "R"
    if count in ALONG:
        return ALONG[count][place]
    return {0: "F", count - 1: "R"}.get(place, str(place + 1))


def style_of(machine: Machine) -> dict[str, Any]:
    """What the page draws this machine with, ready for JSON; another machine, another style."""
    return {
        "palette": {"legs": LEGS, "good": GOOD, "warn": WARN, "bad": BAD, "path": PATH},
        "margin_good_m": MARGIN_GOOD,
        "leg_names": leg_names(machine.legs),
    }
