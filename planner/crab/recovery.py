"""What is left when no step gets on along the course: a step back, another course within a cone,
legs stretched to the limit, the reason.

Four-leg shifts, other legs and lifting a foot to put it elsewhere are candidates of
``lookahead_search`` already; these are of another kind: they give up the commanded course for one
step, or the control reach until a gap is behind the walker. They are searched to their end even
when Level C waits: bounded by count, some two thousand slices at the very most.
"""

from __future__ import annotations

import math
from itertools import islice
from typing import NamedTuple

from ..decision_log import DecisionLog, reasons_of, refused_cells
from ..protocols import SlicedJob
from ..types import Blocked, Reason
from .candidates import Node, SearchContext, near_steps
from .lookahead_search import Branches, best_of, is_open, look_near, standard_way

# degrees against the commanded course, in the order they are tried
CONE = (15.0, -15.0, 30.0, -30.0)
BACK_MAX = 4  # steps back that are tried
WORTH = 0.1  # of the standard way: net way a step a recovery must lead to; less is wandering
STRAIN = 0.005  # m beyond the control reach that counts as stretched; less and servo errors do
CELLS_LOGGED = 8  # refused cells named when blocked


class Recovery(NamedTuple):
    """A way out: what it is, on which course, and by which steps, best first."""

    kind: str  # back | cone | stretch
    context: SearchContext
    ways: Branches


RecoveryJob = SlicedJob[Recovery | None]


def way_out(context: SearchContext) -> RecoveryJob:
    """A step back that lets the walk get past where it stands, a course within the cone that gets
    on, stretched legs; None without one.
    """
    back = yield from _by_a_step_back(context)
    if back is not None:
        return back
    least = WORTH * standard_way(context.nominal)
    for degrees in CONE:
        off = math.radians(degrees)
        aside = SearchContext(context.request, context.request.command.crab_angle + off)
        found = yield from look_near(aside)
        if found.ways and found.ways[0].pace(context.depth) >= least / math.cos(off):
            return Recovery("cone", aside, found.ways)
    return (yield from by_stretching(context, least))


def by_stretching(context: SearchContext, least: float) -> RecoveryJob:
    """The commanded course with legs stretched to the mechanical limit, if that gains more than
    ``least`` m a step: wider gaps, slowly.
    """
    if context.stretched_ways is None:
        far = SearchContext(context.request, context.request.command.crab_angle, stretched=True)
        context.stretched_ways = far, (yield from best_of(far))
    far, found = context.stretched_ways
    return Recovery("stretch", far, found.ways) if found.pace > least else None


def is_strained(context: SearchContext) -> bool:
    """True in the middle of a stretched crossing: a foot stands beyond its control reach, and the
    ground ahead is not open.
    """
    feet = context.start.posture.feet
    strain = STRAIN * context.nominal.size
    beyond = any(
        not (x1 - strain <= x <= x2 + strain and y1 - strain <= y <= y2 + strain)
        for (x, y), (x1, x2, y1, y2) in zip(feet, context.nominal.boxes, strict=True)
    )
    return beyond and not is_open(context)


def _by_a_step_back(context: SearchContext) -> RecoveryJob:
    request = context.request
    course = request.command.crab_angle
    behind = SearchContext(request, course + math.pi)
    need = WORTH * (context.depth + 1) * standard_way(context.nominal)
    for step in islice(near_steps(behind, behind.start, (behind.nominal.margin,), 2), BACK_MAX):
        node = Node(behind, behind.start, step)
        z = request.stance.body[2] if behind.here.is_level else None
        there = behind.here.stance_after(node.posture, step, z)
        found = yield from look_near(SearchContext(request._replace(stance=there), course))
        if found.ways and found.ways[0].gain - step.g >= need:
            return Recovery("back", behind, [found.ways[0]._replace(first=step)])
    return None


def blocked(context: SearchContext, ways: Branches, log: DecisionLog | None) -> Blocked:
    """No way on: what failed for each leg where the farthest way ends, and cells refused there."""
    end = ways[0].node if ways else context.start
    tried: DecisionLog = {}
    context.paper_step(end, tried)
    legs = tried.get("legs", [])
    cells = refused_cells(tried, CELLS_LOGGED)
    where = f"after {ways[0].gain:.2f} m more " if ways and ways[0].gain > 0.005 else ""
    places = "".join(f" ({cell['x']:.2f}, {cell['y']:.2f})" for cell in cells[:3])
    named = f"; refused cells:{places}" if places else ""
    facts = {"where": where, "because": reasons_of(tried, "no gain"), "cells": named}
    leg = legs[0]["leg"] - 1 if legs else None
    return Blocked(Reason.NO_WAY_ON, leg, {**(log or {}), "refused": cells}, facts)
