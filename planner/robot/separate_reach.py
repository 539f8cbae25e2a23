"""Reach boxes that overlap, cut apart: no leg then crosses a neighbour, standing or swinging.

K's second truncation ("non-touching the neighbouring leg") compares feet, which is enough where
every leg has its own ground. Where reach overlaps, legs would cross in plan; each keeps the part
on its own side of the middle of the overlap.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

from .model import Leg, Machine

AxisSpan = tuple[float, float]


def separated(machine: Machine) -> Machine:
    """The same machine planned for without overlaps; itself when there are none."""
    legs = list(machine.legs)
    for i, j in combinations(range(len(legs)), 2):
        legs[i], legs[j] = _cut_apart(legs[i], legs[j])
    if tuple(legs) == machine.legs:
        return machine
    return replace(machine, legs=tuple(legs))


def _cut_apart(a: Leg, b: Leg) -> tuple[Leg, Leg]:
    """Two legs whose rectangles share no ground, cut along the axis on which they overlap less."""
    along_x = _overlap(a.x, b.x)
    along_y = _overlap(a.y, b.y)
    if along_x <= 0.0 or along_y <= 0.0:
        return a, b
    if along_x <= along_y:
        one, other = _halves(a.x, b.x)
        return replace(a, x=one), replace(b, x=other)
    one, other = _halves(a.y, b.y)
    return replace(a, y=one), replace(b, y=other)


def _overlap(a: AxisSpan, b: AxisSpan) -> float:
    return min(a[1], b[1]) - max(a[0], b[0])


def _halves(a: AxisSpan, b: AxisSpan) -> tuple[AxisSpan, AxisSpan]:
    """Two spans that overlap, each up to the middle of the overlap."""
    middle = (max(a[0], b[0]) + min(a[1], b[1])) / 2.0
    if a[0] + a[1] <= b[0] + b[1]:
        return (a[0], middle), (middle, b[1])
    return (middle, a[1]), (b[0], middle)
