"""What bars the way as the map has it, in words: for a body that gets no farther, whatever its feet
do.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.transforms import Body, direction
from ..robot.model import Machine
from ..terrain.map import TerrainMap

DEPTH = 0.5  # m behind its nearest cell, to which what stands ahead is looked at for its width
WIDEST = 2.0  # m to either side, no farther
UNFELT = ": as if something that no foot has felt were in its way"


def what_bars(body: Body, heading: float, terrain: TerrainMap, machine: Machine) -> str:
    """What is taller than any leg can be lifted in the lane of a machine that goes in direction
    ``heading`` (rad, absolute), up to its own length before its legs: how far before the middle of
    the body, m, and how far to either side. Empty when the map shows nothing.
    """
    x, y, z, yaw = body
    top = z + max(leg.z[1] for leg in machine.legs) + machine.overreach[2]
    corners = [(bx, by) for box in machine.boxes for bx in box[:2] for by in box[2:]]
    c, s = direction(heading - yaw)
    ahead = [c * bx + s * by for bx, by in corners]
    aside = [c * by - s * bx for bx, by in corners]
    far = 2.0 * max(ahead) - min(ahead)
    reach = math.hypot(far, WIDEST)
    rows, columns = terrain.window(x - reach, x + reach, y - reach, y + reach)
    tall = np.argwhere(terrain.heights[rows, columns] > top) + (rows.start, columns.start)
    if not len(tall):
        return ""
    c, s = direction(heading)
    dy, dx = ((tall + 0.5) * terrain.cell + (terrain.origin[1] - y, terrain.origin[0] - x)).T
    along, across = c * dx + s * dy, c * dy - s * dx
    in_lane = (along > 0.0) & (along < far) & (across > min(aside)) & (across < max(aside))
    if not in_lane.any():
        return ""
    nearest = float(along[in_lane].min())
    beside = across[(np.abs(along - nearest) <= DEPTH) & (np.abs(across) <= WIDEST)]
    ends = " to ".join(_side(float(end)) for end in (beside.max(), beside.min()))
    stands = f"{nearest:.1f} m before its middle, from {ends} of its line"
    return f": what no leg can be lifted over stands {stands}"


def _side(across: float) -> str:
    """So many metres to one side of the line."""
    return f"{abs(across):.1f} m {'left' if across > 0.0 else 'right'}"
