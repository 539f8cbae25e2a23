"""Level B2 while the torso turns (H §5 with circles for lines): who swings, how far, and where to.

The path is an arc, down to a turn on the spot. What the paper settles by rule on a straight course
is searched for here: sequences of swings and of body shifts on four legs are grown a few steps
deep, always the most promising ones, and the first step of the best is taken. Each swing is the
paper's: g0 until the triangle carries, g as far as it carries and every standing leg reaches, the
foot put where it leaves its stroke later than u* by the nominal phase difference. Bounded by count;
no memory, so it takes over from any posture of a straight walk and hands any back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from operator import itemgetter
from typing import NamedTuple

from ..config import Turning
from ..decision_log import DecisionLog, note_cell, note_leg, note_reason, note_search
from ..geometry.paths import arc_exit
from ..geometry.polygons import inside_of
from ..geometry.transforms import XY, left_fold_sum
from ..motion.step_builder import changed
from ..protocols import PlanningJob
from ..search import Branch, Option, Search, beam, firsts, uninterruptible
from ..stability import polygon_margin_on, stable_on
from ..terrain.cells import FootholdMap, cells_around, foothold_map
from ..types import Blocked, Reason, StepPlan
from .candidates import entry_of, shift_room, shortest_shift
from .foothold_checks import FootholdChecks
from .foothold_search import phase_point
from .gait import Posture, nominal_gait_of, posture_of
from .leg_selection import (
    SLACK,
    STILL,
    after,
    changes_nothing,
    free_shift,
    shifted,
    triangle_of,
)
from .step_plans import plan_of
from .step_refusals import StepRefusal
from .steps import BodyShift, Candidate, Landing, Shift, StepRequest, SwingStep

# steps a sequence is long, sequences kept, and for how many of its steps feet may come down
# anywhere in reach
LOOKS = (
    (6, 6, 0),  # less: see it shift the body where a swing would do
    (9, 16, 0),  # each of these when the one before finds no way on
    # without: see it stand for good after a turn of mind, its legs at the edges of their reach
    (8, 32, 1),
    (6, 128, 2),
)
# of the reach, along and across: where feet are tried when they may come down anywhere
ANYWHERE = (0.02, 0.5, 0.98)
# m; an inset every swing keeps where it can, and one it keeps always; none: see the torso tip as a
# foot lifts
THIN, BARE = 0.004, 0.001
# steps without a useful way after which the way that gets on soonest is taken; else see it go to
# and fro
STILL_MAX = 2
IN_NEED = 10.0  # m such a way is held to gain over one that never gets on; more than any way loses
IN_NEED_LOOK = 2  # the look it begins with
SHIFT_MIN = 0.002  # m; a shorter body shift is none
CANDIDATE = 3  # what finding one weighs, in postures looked at
REFUSED_MAX = 200  # cells logged of one leg


class TurnNode(NamedTuple):
    """A posture in the search."""

    posture: Posture
    way: float = 0.0  # m of the path gone
    shifted: bool = False  # the last step was a body shift


TurnBranch = Branch[TurnNode, Candidate]


class TurnSearch:
    """One search for the next step of a turn from one stance."""

    def __init__(self, checks: FootholdChecks, settings: Turning) -> None:
        nominal, stance = checks.nominal, checks.stance
        self.checks = checks
        self.settings = settings
        self.nominal = nominal
        self.arc = nominal.path
        self.cells: FootholdMap = foothold_map(checks.terrain)
        duty = nominal.duty_factor
        self.full = (1.0 - duty) / duty * nominal.stride  # m, the way of a swing of the walk
        self.useful = settings.useful * self.full
        size = nominal.size
        thin = size * THIN
        comfort = min(size * settings.inset, settings.inset_share * nominal.margin)
        self.insets = (comfort, thin, size * BARE) if comfort > thin else (thin, size * BARE)
        self.root = TurnNode(checks.posture)
        self.in_need = stance.still >= STILL_MAX  # the way that gets on soonest is the best
        self.anywhere = 0  # steps in which feet may come down anywhere in reach

    def look(self, depth: int, width: int, anywhere: int = 0) -> Search[TurnNode, Candidate]:
        """The ways on, best first: way gone, less what was lost on it, less what the legs lack of
        the nominal phases.
        """
        self.anywhere = anywhere
        return beam(self.root, self.options, depth, width, self.checks.work)

    def options(self, node: TurnNode, depth: int) -> Iterator[Option[Candidate, TurnNode]]:
        """Every next step worth looking at, for the beam."""
        for candidate in self.candidates(node, depth):
            self.checks.work.asked += CANDIDATE
            reached, gain = self.after(node, candidate)
            if self.in_need and node.way < self.useful <= reached.way:
                gain += IN_NEED / (1 + depth)
            yield candidate, reached, gain, self.heuristic(reached)

    def heuristic(self, node: TurnNode) -> float:
        """Minus what the exits lack of the nominal ones after the same leg has landed, m."""
        layouts = self.nominal.layouts
        last = node.posture.last
        ends = self.nominal.ends
        lacks = min(
            left_fold_sum(
                max(0.0, ahead + end - has)
                for end, ahead, has in zip(ends, layout, node.posture.exits, strict=True)
            )
            for layout in ((layouts[last],) if last >= 0 else layouts)
        )
        return -self.settings.phase_weight * lacks

    def after(self, node: TurnNode, candidate: Candidate) -> tuple[TurnNode, float]:
        """The posture at N_{k+1}, and the way gone less what could have been gone in the time: the
        cheap roll-out of one step.
        """
        if isinstance(candidate, BodyShift):
            posture = shifted(node.posture, candidate)
            return TurnNode(posture, node.way, True), -math.hypot(candidate.x, candidate.y)
        posture = after(node.posture, candidate)
        lost = max(0.0, self.full - (candidate.g - candidate.g0))
        if candidate.margin < self.nominal.size * THIN:
            lost += self.nominal.size * self.settings.thin_cost
        return TurnNode(posture, node.way + candidate.g), candidate.g - lost

    # what can be done next

    def candidates(self, node: TurnNode, depth: int) -> Iterator[Candidate]:
        """Swings of every leg but the last, body shifts where swings do little; the last leg again
        when nothing else is left.
        """
        last = node.posture.last
        found = False
        stuck = []
        for leg in range(4):
            shift = self.shift_of(node, leg) if leg != last else None
            for step in self.swings(node, shift, depth):
                found = True
                yield step
            if shift is None or shift.g - shift.g0 < self.useful:
                stuck.append(leg)
        if not found and last >= 0:
            for step in self.swings(node, self.shift_of(node, last), depth):
                found = True
                yield step
        may_shift = depth == 0 or depth < self.anywhere or len(stuck) == 4
        if not found or (not node.shifted and may_shift):
            shifts = self.body_shifts(node, stuck)
            yield from (s for s in shifts if depth > 0 or not self.checks.is_barred(s))

    def shift_of(self, node: TurnNode, leg: int) -> Shift | None:
        """g0, g and the inset kept when ``leg`` swings; None when it cannot."""
        best: Shift | None = None
        for inset in self.insets:
            shift = free_shift(node.posture, leg, inset=inset)
            if isinstance(shift, StepRefusal) or not self._carried(node, shift.g0):
                continue
            if best is None or shift.g - shift.g0 > best.g - best.g0:
                best = shift
            if shift.g - shift.g0 >= self.useful:
                break
        return best

    def _carried(self, node: TurnNode, g0: float) -> bool:
        """True when the body stays over its four feet until g0."""
        if g0 <= 0.0:
            return True
        low, high = stable_on(self.arc, node.posture.support, -SLACK)
        return low <= 0.0 and high >= g0

    def swings(self, node: TurnNode, shift: Shift | None, depth: int) -> Iterator[SwingStep]:
        """Where the foot may come down: by phase, as far ahead as its stroke goes, and, when
        nothing else leads on, anywhere.
        """
        if shift is None:
            return
        leg, g = shift.leg, shift.g
        nominal = self.nominal
        end = nominal.ends[leg]
        farthest = g + nominal.stride
        phase = min(max(phase_point(node.posture, leg) + end, g), farthest)
        leaves = [phase]
        if farthest - phase > 0.05 * nominal.stride:
            leaves.append(farthest)
        starts = [(self.arc.placed(*nominal.centres[leg], s - end), s) for s in leaves]
        if depth < self.anywhere:
            x1, x2, y1, y2 = nominal.boxes[leg]
            starts += [
                (self.arc.placed(x1 + u * (x2 - x1), y1 + v * (y2 - y1), g), 0.0)
                for u in ANYWHERE
                for v in ANYWHERE
            ]
        for start, wanted in starts:
            landing = self.foothold(node, shift, start, wanted, depth == 0)
            if landing is not None:
                yield SwingStep(leg, shift.g0, g, start, landing, shift.inset, False)

    def foothold(
        self, node: TurnNode, shift: Shift, start: XY, wanted: float, first: bool
    ) -> Landing | None:
        """I_u itself, or the best free cell: near it, and left no sooner than ``wanted``."""
        around = node.posture.absolute(*start)
        exact = Landing(*start, *around)
        if self.cells.allows(*around) and self.fits(shift, exact, first) is not None:
            return None if changes_nothing(node.posture, shift, exact) else exact
        costs: list[tuple[float, Landing]] = []
        for ax, ay, away in cells_around(self.cells, around, self.settings.far_enough):
            landing = Landing(*node.posture.canonical(ax, ay), ax, ay)
            left = self.fits(shift, landing, first)
            if left is None or changes_nothing(node.posture, shift, landing):
                continue
            costs.append((away + max(0.0, wanted - shift.g - left), landing))
            if len(costs) >= self.settings.cells_max:
                break
        return min(costs, key=itemgetter(0))[1] if costs else None

    def fits(self, shift: Shift, landing: Landing, first: bool) -> float | None:
        """How far on from N_{k+1} a foothold stays in reach; None when it is not, or its height
        will not do (asked of ``first`` steps only).
        """
        x, y = self.arc.seen(landing.x, landing.y, shift.g)
        box = self.nominal.boxes[shift.leg]
        if not (box[0] <= x <= box[1] and box[2] <= y <= box[3]):
            return None
        if first and not self.checks.is_level and self.checks.refuses(shift, landing) is not None:
            return None
        return arc_exit(x, y, box, self.arc)

    def body_shifts(self, node: TurnNode, legs: list[int]) -> Iterator[BodyShift]:
        """For every leg the shortest shift of the body on four legs after which it can swing: for a
        useful way, else at all.
        """
        room = shift_room(node.posture)
        ahead_x, ahead_y, _ = self.arc.pose(2.0 * self.useful)
        for leg in legs:
            triangle = triangle_of(node.posture, leg)
            if len(triangle) < 3:
                continue
            insets = ((inset, inside_of(room, triangle, inset)) for inset in self.insets)
            regions = (
                region
                for inset, here in insets
                for region in (inside_of(here, triangle, inset, ahead_x, ahead_y), here)
            )
            shift = shortest_shift(node.posture, regions, self.nominal.size * SHIFT_MIN)
            if shift is not None:
                yield shift


# the step that is taken


def turn_job(request: StepRequest) -> PlanningJob:
    """The next step of a turning walk from N_k, or why there is none, slice by slice; always to the
    end, a few ticks of standing at most.
    """
    command = request.command
    nominal = nominal_gait_of(command, request.machine, request.gait)
    pace = math.hypot(command.speed, request.machine.yaw_length * command.turn_rate)
    log = request.log(crab_angle=command.crab_angle, turn=nominal.path.turn, stride=nominal.stride)
    posture = posture_of(nominal, request.stance)
    search = TurnSearch(FootholdChecks(posture, request), request.config.turning)
    answer: StepPlan | Blocked = Blocked(Reason.NO_WAY_ON_AN_ARC, None, log)
    for depth, width, anywhere in LOOKS[IN_NEED_LOOK:] if search.in_need else LOOKS:
        # half a search knows no better than to stay, and a walk of such answers never ends
        found = yield from uninterruptible(search.look(depth, width, anywhere))
        ways = firsts(found.ways)
        if log is not None:
            note_search(log, "turn", depth, [entry_of(posture, way, "inset") for way in ways])
        for way in ways:
            if _gets_on(search, way):
                _note_legs(search, way.first, log)
                answer = _planned(search, way.first, pace, log)
                if isinstance(answer, StepPlan):
                    return answer
    if log is not None and "legs" not in log:
        _note_legs(search, None, log)
    return answer


def _gets_on(search: TurnSearch, way: TurnBranch) -> bool:
    """True of a way that is better than to stay."""
    if way.node.way >= search.useful:
        return True
    better = search.heuristic(way.node) > search.heuristic(search.root) + STILL
    return better and not search.in_need


def _planned(
    search: TurnSearch, first: Candidate, pace: float, log: DecisionLog | None
) -> StepPlan | Blocked:
    """The plan of the step that is taken, with how often in a row the body has not got on."""
    checks, stance = search.checks, search.checks.stance
    way = 0.0
    if isinstance(first, SwingStep):
        way = first.g
        first = first._replace(margin=_least_margin(checks.posture, first))
    plan = plan_of(checks, first, pace, log)
    if isinstance(plan, Blocked):
        return plan
    still = 0 if way >= search.useful else stance.still + 1
    end = replace(plan.end, still=still, quarter_turns=stance.quarter_turns)
    return changed(plan, end=end)


def _least_margin(posture: Posture, step: SwingStep) -> float:
    """Least polygon margin of a step, first on all feet, then on those that stay."""
    path = posture.nominal.path
    on_four = polygon_margin_on(path, posture.support, 0.0, step.g0)
    return min(on_four, polygon_margin_on(path, triangle_of(posture, step.leg), step.g0, step.g))


# the decision log, worked out once the step is chosen: a walk that explains itself takes the same
# steps


def _note_legs(search: TurnSearch, taken: Candidate | None, log: DecisionLog | None) -> None:
    """Every leg in the order of the arc's own walk, the successor first: how far the body could go,
    the cells refused, or why not.
    """
    if log is None:
        return
    log["legs"] = []
    nominal, root = search.nominal, search.root
    last = root.posture.last
    leg = nominal.order.successor[last] if last >= 0 else 0
    for _ in range(4):
        whole = nominal.stride + nominal.spares[leg]
        trial = note_leg(log, leg, return_length=max(0.0, whole - root.posture.exits[leg]))
        shift = search.shift_of(root, leg)
        if shift is None:
            note_reason(trial, _why_not(search, leg))
        elif trial is not None:
            trial |= {"g0": shift.g0, "g": shift.g, "inset": shift.inset}
            if isinstance(taken, SwingStep) and taken.leg == leg:
                _note_refused(search, shift, taken, trial)
            elif not any(True for _ in search.swings(root, shift, 0)):
                note_reason(trial, StepRefusal.NONE_IN_REACH)
        leg = nominal.order.successor[leg]


def _why_not(search: TurnSearch, leg: int) -> StepRefusal:
    """Why ``leg`` cannot swing now: which condition of H §5.2 fails on the arc."""
    shift = free_shift(search.root.posture, leg, inset=search.insets[-1])
    return shift if isinstance(shift, StepRefusal) else StepRefusal.UNCARRIED


def _note_refused(search: TurnSearch, shift: Shift, taken: SwingStep, trial: DecisionLog) -> None:
    """Cells nearer to I_u than J_u that were passed over within the leg's reach, and why."""
    posture, landing = search.root.posture, taken.landing
    x1, x2, y1, y2 = search.nominal.boxes[taken.leg]
    around = posture.absolute(*taken.start)
    nearer = math.dist((landing.ax, landing.ay), around) + search.cells.cell / 2
    for ax, ay, _ in cells_around(search.cells, around, search.settings.far_enough, every=True):
        if math.dist((ax, ay), around) > nearer or len(trial["refused"]) == REFUSED_MAX:
            break
        cell = Landing(*posture.canonical(ax, ay), ax, ay)
        x, y = search.arc.seen(cell.x, cell.y, taken.g)
        if not (x1 <= x <= x2 and y1 <= y <= y2) or cell[2:] == landing[2:]:
            continue
        if not search.cells.allows(ax, ay):
            note_cell(trial, ax, ay, StepRefusal.PROHIBITED)
            continue
        refusal = None if search.checks.is_level else search.checks.refuses(shift, cell)
        if refusal is not None:
            note_cell(trial, ax, ay, refusal)
