"""What the search for a step of a turn considered, told for the decision trace: the twin of the
notes ``xy`` and ``landing`` take.

Worked out once the step is chosen, from the same search, so that a walk that explains itself takes
the same steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..geometry.paths import ArcPath
from ..search import Branch, firsts
from ..stability import XY, stable_on_arc, support_polygon
from .gait import OTHERS

if TYPE_CHECKING:
    from .arcplan import Move
    from .turning import Outlook, Place

REFUSED_MAX = 200  # cells told of one leg


def legs_tried(outlook: Outlook, taken: Move | None) -> list[dict[str, Any]]:
    """Every leg in the order of the arc's own walk, the successor first: how far the body could go,
    the cells refused, or why not.
    """
    circular, root = outlook.circular, outlook.root
    leg, told = circular.successor[root.last] if root.last >= 0 else 0, []
    for _ in range(len(root.feet)):
        shift = outlook.shift_of(root, leg)
        trial: dict[str, Any] = {
            "leg": leg + 1,
            "return_length": max(0.0, circular.stride + circular.spares[leg] - root.exits[leg]),
            "refused": [],
        }
        if shift is None:
            trial["reason"] = why_not(outlook, leg)
        else:
            g0, g, inset = shift
            trial |= {"g0": g0, "g": g, "inset": inset}
            if taken is not None and taken.leg == leg:
                trial["refused"] = refused(outlook, taken)
            elif not any(True for _ in outlook.landings(root, leg, g0, g, inset, 0)):
                trial["reason"] = "no foothold in reach"
        told.append(trial)
        leg = circular.successor[leg]
    return told


def why_not(outlook: Outlook, leg: int) -> str:
    """Why ``leg`` cannot swing now: which condition of H §5.2 fails on the arc."""
    root, arc = outlook.root, outlook.circular.arc
    i, j, k = OTHERS[leg]
    low, high = stable_on_arc(
        support_polygon((root.feet[i], root.feet[j], root.feet[k])), *arc, outlook.insets[-1]
    )
    if low > high:
        return "the course misses the triangle of the other feet"
    if high < 0.0:
        return "the centre of gravity has already left the triangle of the other feet"
    if low > min(root.exits[i], root.exits[j], root.exits[k], root.exits[leg]):
        return "the centre of gravity cannot enter the triangle of the other feet before a leg leaves its reach"
    return "the centre of gravity would leave the feet on the way into the triangle"


def refused(outlook: Outlook, move: Move) -> list[dict[str, Any]]:
    """Cells nearer to I_u than J_u that were passed over within the leg's reach, and why."""
    root, allows = outlook.root, outlook.ground.allows
    x1, x2, y1, y2 = outlook.circular.boxes[move.leg]
    around = root.absolute(*move.start)
    nearer = (
        math.hypot(move.ground[0] - around[0], move.ground[1] - around[1])
        + outlook.terrain.cell / 2
    )
    told: list[dict[str, Any]] = []
    for px, py, qx, qy, _ in outlook.cells(root, around, every=True):
        if math.hypot(qx - around[0], qy - around[1]) > nearer or len(told) == REFUSED_MAX:
            break
        x, y = outlook.circular.arc.seen(px, py, move.g)
        if not (x1 <= x <= x2 and y1 <= y <= y2) or (qx, qy) == move.ground:
            continue
        if not allows(qx, qy):
            told.append({"x": qx, "y": qy, "reason": "prohibited cell"})
        elif outlook.rises.refuses(move.leg, move.g, (qx, qy)):
            told.append({"x": qx, "y": qy, "reason": "too high or too low for the legs"})
    return told


def searched(outlook: Outlook, move: Move) -> list[list[float]]:
    """Corners, in the absolute frame, of where the foot may come down: the leg's reach as it will
    lie at N_{k+1}.
    """
    root, arc, (x1, x2, y1, y2) = (
        outlook.root,
        outlook.circular.arc,
        outlook.circular.boxes[move.leg],
    )
    return [
        list(root.absolute(*_ahead(arc, move.g, corner)))
        for corner in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))
    ]


def _ahead(arc: ArcPath, g: float, point: XY) -> XY:
    """A point of the body axes at N_{k+1} in those at N_k."""
    dx, dy, turn = arc.pose(g)
    c, s = math.cos(turn), math.sin(turn)
    return dx + c * point[0] - s * point[1], dy + s * point[0] + c * point[1]


def weighed(ways: Iterable[Branch[Place, Move]], horizon: int) -> dict[str, Any]:
    """The search: each candidate's first step and how it scored."""
    candidates = [
        {
            "leg": way.first.leg + 1 if way.first.leg >= 0 else None, "g0": way.first.g0, "g": way.first.g, "inset": way.first.inset,
            "landing": list(way.first.ground), "score": way.score, "gain": way.gain, "steps": way.steps,
        }
        for way in firsts(ways)
    ]  # fmt: skip
    return {"search": "turn", "horizon": horizon, "candidates": candidates}
