"""H's four legs, one in each quadrant of the body, and the box they have in common (H fig. 1)."""

from __future__ import annotations

from collections.abc import Sequence

from ..geometry.paths import Box

SIDES = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))  # of the legs of H


def ordered(a: float, b: float) -> tuple[float, float]:
    """The two, the smaller first."""
    return (a, b) if a <= b else (b, a)


def mirrored_part(boxes: Sequence[Box]) -> Box | None:
    """The largest box that, mirrored to four quadrants, lies in all four; None without one."""
    x = [ordered(sx * box[0], sx * box[1]) for box, (sx, _) in zip(boxes, SIDES, strict=True)]
    y = [ordered(sy * box[2], sy * box[3]) for box, (_, sy) in zip(boxes, SIDES, strict=True)]
    x1 = max(low for low, _ in x)
    x2 = min(high for _, high in x)
    y1 = max(low for low, _ in y)
    y2 = min(high for _, high in y)
    return (x1, x2, y1, y2) if x2 > x1 and y2 > y1 else None
