"""How far a machine was from tipping over a whole walk: every margin, from the rows of its log.

What ``margins`` says of one moment, for all rows at once and to the last bit as there: feet that
carry stay where they are, so that one polygon serves many rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner import stability
from walking_console.planner.geometry.polygons import Polygon
from walking_console.planner.geometry.transforms import direction, left_fold_sum, rotation
from walking_console.planner.robot.model import Machine
from walking_console.planner.statics import centre_of_gravity

_Floats = NDArray[np.float64]
_Bools = NDArray[np.bool_]

BLOCK = 4096  # rows at a time, so that a long walk takes no more memory than a short one
PARALLEL = 1e-12  # as in ``stable_interval``: of an edge that a course does not come nearer to
NOWHERE = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))  # stands for a polygon where there is none


class WalkRows(NamedTuple):
    """What margins depend on, a row a tick."""

    body: _Floats  # (T, 6) m, rad
    feet: _Floats  # (T, n, 3) m
    support: _Bools  # (T, n), which of them are meant to carry
    heading: _Floats  # (T,) rad, where the course goes
    velocity: _Floats  # (T, 2) m/s, of the body over the ground

    def part(self, begin: int, end: int | None = None) -> WalkRows:
        """The rows from one on, up to another."""
        rows = slice(begin, end)
        return WalkRows(
            self.body[rows],
            self.feet[rows],
            self.support[rows],
            self.heading[rows],
            self.velocity[rows],
        )


class _Edges(NamedTuple):
    """The support polygon's edges in every row, (T, m): where they begin and what way they go."""

    ax: _Floats
    ay: _Floats
    ex: _Floats
    ey: _Floats

    def across(self, place: _Floats) -> _Floats:
        """How far inside every edge a place (T, 2) is, times the edge's length, m²."""
        return self.ex * (place[:, 1, None] - self.ay) - self.ey * (place[:, 0, None] - self.ax)

    @property
    def length(self) -> _Floats:
        """Of every edge, m."""
        length: _Floats = np.sqrt(self.ex * self.ex + self.ey * self.ey)
        return length


def margins_over(machine: Machine, walk: WalkRows) -> _Floats:
    """Longitudinal, polygon and capture margin, (T, 3) m: ``margins_of`` row by row."""
    begins = range(0, len(walk.body), BLOCK)
    blocks = [_margins(machine, walk.part(begin, begin + BLOCK)) for begin in begins]
    return np.concatenate(blocks) if blocks else np.zeros((0, 3))


def true_centres(machine: Machine, body: _Floats, feet: _Floats) -> _Floats:
    """``true_centre`` row by row, (T, 3) m, for rows of body (T, 6) and feet (T, n, 3)."""
    if not len(body):
        return np.zeros((0, 3))
    turn = _rotations(body[:, 3:])
    away = np.moveaxis(feet - body[:, None, :3], 1, 0)
    feet_b = [_times(turn[:, :, 0], turn[:, :, 1], turn[:, :, 2], foot) for foot in away]
    centre = _centres(machine, feet_b)
    return body[:, :3] + _times(turn[:, 0], turn[:, 1], turn[:, 2], centre)


def _centres(machine: Machine, feet_b: list[_Floats]) -> _Floats:
    """``centre_of_gravity`` row by row, for every leg's foot (T, 3): for all rows at once where it
    asks for nothing but sums.
    """
    if machine.mass_at_feet is not None:
        columns = [(foot[:, 0], foot[:, 1], foot[:, 2]) for foot in feet_b]
        return np.stack(centre_of_gravity(machine, columns), axis=1)  # type: ignore[arg-type]
    rows = np.stack(feet_b, axis=1).tolist()
    return np.array([centre_of_gravity(machine, feet) for feet in rows])


def _times(a: _Floats, b: _Floats, c: _Floats, vector: _Floats) -> _Floats:
    """A vector times three others, row by row, (T, 3)."""
    x = vector[:, 0]
    y = vector[:, 1]
    z = vector[:, 2]
    return np.stack([row[:, 0] * x + row[:, 1] * y + row[:, 2] * z for row in (a, b, c)], axis=1)


def _rotations(attitude: _Floats) -> _Floats:
    """Body axes to absolute ones, (T, 3, 3), for rows of roll, pitch and yaw."""
    starts, lengths = _unchanged(attitude)
    turns = np.array([rotation(*angles) for angles in attitude[starts].tolist()])
    return np.repeat(turns, lengths, axis=0)


def _unchanged(rows: _Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where rows begin that are not as the ones before, and for how many it stays so."""
    changes = np.nonzero((rows[1:] != rows[:-1]).any(axis=1))[0] + 1
    starts = np.concatenate([[0], changes])
    return starts, np.diff(np.concatenate([starts, [len(rows)]]))


def _margins(machine: Machine, walk: WalkRows) -> _Floats:
    """The same for so many rows that there is memory for all of their edges."""
    standing = np.where(walk.support[..., None], walk.feet, -np.inf)
    starts, lengths = _unchanged(standing.reshape(len(standing), -1))
    stances = list(_standing(walk.feet[starts], walk.support[starts]))
    polygons = [stability.support_polygon(on) for on in stances]
    edges = _edges(polygons, lengths)
    exists = np.repeat([len(polygon) > 2 for polygon in polygons], lengths)
    heights = [left_fold_sum(foot[2] for foot in on) / len(on) if on else 0.0 for on in stances]
    polygon = (edges.across(walk.body) / edges.length).min(axis=1)
    longitudinal = _longitudinal(edges, walk, polygon)
    capture = _capture(edges, machine, walk, np.repeat(heights, lengths))
    margins = np.stack([longitudinal, polygon, capture], axis=1)
    margins[~exists] = -np.inf
    return margins


def _standing(feet: _Floats, support: _Bools) -> Iterator[list[list[float]]]:
    """Of every row the feet that are meant to carry."""
    for points, carries in zip(feet.tolist(), support.tolist(), strict=True):
        yield [point for point, on in zip(points, carries, strict=True) if on]


def _edges(polygons: list[Polygon], lengths: NDArray[np.intp]) -> _Edges:
    """The edges of polygons that serve so many rows; of one with fewer than others the last stands
    there again.
    """
    most = max(3, max(map(len, polygons)))
    ends = []
    for polygon in polygons:
        corners = polygon if len(polygon) > 2 else NOWHERE
        edges = [(*a, *b) for a, b in zip((corners[-1], *corners[:-1]), corners, strict=True)]
        ends.append(edges + edges[-1:] * (most - len(edges)))
    ax, ay, bx, by = np.moveaxis(np.repeat(ends, lengths, axis=0), 2, 0)
    return _Edges(ax, ay, bx - ax, by - ay)


def _longitudinal(edges: _Edges, walk: WalkRows, polygon: _Floats) -> _Floats:
    """``longitudinal_margin`` row by row; ``polygon`` is the polygon margin."""
    along = np.array([direction(angle) for angle in walk.heading.tolist()])
    distance = edges.across(walk.body)
    rate = edges.ex * along[:, 1, None] - edges.ey * along[:, 0, None]
    nearer = rate > PARALLEL
    farther = rate < -PARALLEL
    s = -distance / np.where(nearer | farther, rate, 1.0)
    low = np.where(nearer, s, -np.inf).max(axis=1)
    high = np.where(farther, s, np.inf).min(axis=1)
    misses = (~nearer & ~farther & (distance < 0.0)).any(axis=1) | (low > high)
    return np.where(misses, np.minimum(polygon, 0.0), np.minimum(-low, high))


def _capture(edges: _Edges, machine: Machine, walk: WalkRows, ground: _Floats) -> _Floats:
    """``capture_margin`` row by row, of feet whose mean height is ``ground``, m."""
    centre = true_centres(machine, walk.body, walk.feet)
    length = edges.length
    vx = walk.velocity[:, 0, None]
    vy = walk.velocity[:, 1, None]
    outward = (edges.ey * vx - edges.ex * vy) / length
    time = np.sqrt(np.maximum(centre[:, 2] - ground, 0.0) / stability.GRAVITY)
    spared = edges.across(centre) / length - np.maximum(outward, 0.0) * time[:, None]
    least: _Floats = spared.min(axis=1)
    return least
