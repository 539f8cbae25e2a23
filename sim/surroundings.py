"""A wide map as a machine walks in it: the window it is given, which goes along with it, and what
is kept of the ground that lies beyond.

Nothing of a wide map is worked out but what comes near. A tile that the next window will want is
worked out in each tick, so that it can be put together from tiles when the machine has come two
tiles far.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.grid import Window, common, grown, joined, within
from walking_console.planner.terrain.map import TerrainMap, with_crests
from walking_console.planner.terrain.mapping import ElevationMapper, Index, Sightings
from walking_console.planner.terrain.traversability import Kind, kinds
from walking_console.planner.terrain.working_map import Evidence
from walking_console.planner.types import Array

from .range_sensor import EyeSettings
from .scenario import Scenario
from .terrain.ground import Ground, GroundError
from .terrain.tile_layers import Layer, TileFacts
from .terrain.wide_map import TILE, WHOLE_CELLS_MAX, WideMap

CellFlags = NDArray[np.bool_]

MOVES = 2  # tiles the machine comes before its window goes along
BODY_LENGTHS = 4.0  # of ground about the machine that a trace walker may look at
BESIDE = 0.5  # m beyond what is looked at


def reach_of(scenario: Scenario, machine: Machine) -> float:
    """How far about the machine its planner and its eye may look, m."""
    x = [side for box in machine.boxes for side in box[:2]]
    y = [side for box in machine.boxes for side in box[2:]]
    length = max(x) - min(x)
    navigation = scenario.planner_config.navigation
    ahead = navigation.bodies_ahead * length + max(x)
    # beside the line, and as far again where the body is at the edge of its way
    aside = 2.0 * navigation.width + max(y)
    eye = scenario.eye or EyeSettings()
    sees = eye.range + math.hypot(*eye.position[:2]) if scenario.sensing == "eye" else 0.0
    return max(math.hypot(ahead, aside), BODY_LENGTHS * length, sees) + BESIDE


class Seen(NamedTuple):
    """A window of a wide map, in truth."""

    ground: Ground
    forbidden: CellFlags
    crests: Array  # m, highest ground within a foot radius


def window_on(tiles: TileFacts, ground: Ground, window: Window) -> Seen:
    """The ground in a window of its wide map."""
    heights, forbidden, crests = tiles.over(window)
    heights.setflags(write=False)
    seen = replace(
        ground,
        heights=heights,
        origin=tiles.whole.corner(window),
        corner=(window[0].start, window[1].start),
    )
    return Seen(seen, forbidden, crests)


def first_window(whole: WideMap, x: float, y: float, reach: float) -> Window:
    """The window a walk at this place begins with; raises ``GroundError`` where it would be too
    large to be held.
    """
    window = whole.window_about(whole.tile_under(x, y), reach)
    rows, columns = (side.stop - side.start for side in window)
    if rows * columns > WHOLE_CELLS_MAX:
        raise GroundError(
            f"the map has {whole.shape[1]} x {whole.shape[0]} cells, and so many of "
            f"{whole.cell:g} m lie near the machine ({columns} x {rows}) that they cannot be held "
            f"(at most {WHOLE_CELLS_MAX}): take larger cells or a smaller map"
        )
    return window


class Surroundings:
    """Where the window is, and what is known of the ground beyond it.

    ``been`` is the rectangle of all windows so far.
    """

    def __init__(self, tiles: TileFacts, ground: Ground, at: tuple[float, float], reach: float):
        self.tiles = tiles.copy()
        self.reach = reach
        self.been = self.window = ground.cells
        self._centre = self._under = self.tiles.whole.tile_under(*at)
        self._missing = self.tiles.missing(self._soon())
        self._rests = False  # in a tick that had enough to do
        shape = self.tiles.whole.shape
        self._marked = Layer(shape, False)
        self._learnt = Layer(shape, False)
        self._is_felt = Layer(shape, False)
        self._felt = Layer(shape, 0.0)
        self._seen = Layer(shape, math.nan)
        self._known = Layer(shape, False)
        self._looks = Layer(shape, np.uint8(0))

    # where the machine is

    def next_window(self, x: float, y: float) -> Window | None:
        """One tick of working out what comes near; the window to go on to, once the machine at
        (x, y) has come far enough.
        """
        whole = self.tiles.whole
        under = whole.tile_under(x, y)
        if under != self._under:
            self._under = under
            self._missing = self.tiles.missing(self._soon())
        if self._missing and not self._rests:
            self.tiles.work_out(self._missing.pop())
        self._rests = False
        came = max(abs(now - then) for now, then in zip(under, self._centre, strict=True))
        if came < MOVES:
            return None
        window = whole.window_about(under, self.reach)
        if window == self.window:  # in a corner of the map
            self._centre = under
            return None
        return window

    def _soon(self) -> Window:
        """The cells that the next window may want, wherever the machine goes from here."""
        whole = self.tiles.whole
        return grown(whole.window_about(self._under, self.reach), TILE, whole.shape)

    def go_on_to(self, window: Window) -> None:
        """The window is there now."""
        self.window = window
        self._centre = self._under
        self._missing = []
        self.been = joined(self.been, window)
        self.tiles.keep_only(grown(window, TILE * MOVES, self.tiles.whole.shape))

    # what an operator has marked

    def marks(self, window: Window, marked: CellFlags) -> CellFlags:
        """Cells that an operator has forbidden in another window; those of this one are kept."""
        return self._marked.moved(marked, self.window, window)

    def change_beyond(self, rows: Index, columns: Index, action: str, maps: bool) -> None:
        """What an edit says of cells beyond the window; ``maps``: the machine maps for itself, and
        hears of nothing but what is forbidden and cleared.
        """
        if action in ("forbid", "clear"):
            self._marked.set_cells(rows, columns, action == "forbid")
        if not maps:
            self._learnt.set_cells(rows, columns, False)
            self._is_felt.set_cells(rows, columns, False)
        elif action in ("forbid", "clear"):
            self._learnt.set_cells(rows, columns, action == "forbid")

    def truth_changed(self, whole: WideMap) -> None:
        """The whole map has other heights in some of its tiles now."""
        self._missing += self.tiles.after_change(whole)
        self._rests = True

    # what a machine that knows the ground has found out

    def belief_in(
        self, seen: Seen, ground: Ground, forbidden: CellFlags, belief: TerrainMap
    ) -> TerrainMap:
        """What it believes of another window, ``seen`` as it is with its crests: the truth, and
        what it has found out there. What it has in this one, other than ``ground`` and what is
        ``forbidden``, is kept.
        """
        there, prohibited, crests = seen
        window = there.cells
        learnt = self._learnt.moved(belief.forbidden & ~forbidden, self.window, window)
        now = replace(
            belief,
            heights=there.heights,
            forbidden=prohibited | learnt,
            origin=there.origin,
        )
        if belief.heights is ground.heights and self._is_felt.is_usual:
            return with_crests(now, crests)
        is_felt = ~_are_equal(belief.heights, ground.heights)
        felt = np.where(is_felt, belief.heights, 0.0)
        is_felt = self._is_felt.moved(is_felt, self.window, window)
        felt = self._felt.moved(felt, self.window, window)
        if not is_felt.any():
            return with_crests(now, crests)
        return replace(now, heights=np.where(is_felt, felt, there.heights))

    # what a machine that maps for itself has seen

    def move_map(self, mapper: ElevationMapper, window: Window) -> None:
        """Have it map another window from now on; what it knows of this one is kept."""
        (seen, known, learnt), looks = mapper.sightings
        evidence = Evidence(
            self._seen.moved(seen, self.window, window),
            self._known.moved(known, self.window, window),
            self._learnt.moved(learnt, self.window, window),
        )
        shared = common(self.window, window)
        mapper.move(
            Sightings(evidence, self._looks.moved(looks, self.window, window)),
            self.tiles.whole.corner(window),
            within(shared, self.window),
            within(shared, window),
        )

    # for the record

    def recorded(self) -> Window:
        """The cells a walk has depended on: all windows so far, and what decides their rims."""
        rim = TILE * math.ceil(self.tiles.reach / TILE)
        return grown(self.been, rim, self.tiles.whole.shape)

    def truly_forbidden(self, window: Window) -> CellFlags:
        """Where the machine must not step beyond the window at hand."""
        forbidden = self.tiles.prohibited(window)
        marked = np.zeros(forbidden.shape, dtype=bool)
        self._marked.lay_over(marked, window)
        return forbidden | marked

    def believed(
        self, window: Window, forbidden: CellFlags, mapper: ElevationMapper | None
    ) -> tuple[Array, CellFlags]:
        """Heights, m, and forbidden cells as they are believed to be beyond the window at hand;
        ``forbidden`` cells are so in truth.
        """
        learnt = np.zeros(forbidden.shape, dtype=bool)
        self._learnt.lay_over(learnt, window)
        if mapper is None:
            heights = self.tiles.whole.read(*window)
            is_felt = np.zeros(forbidden.shape, dtype=bool)
            self._is_felt.lay_over(is_felt, window)
            felt = np.zeros(forbidden.shape)
            self._felt.lay_over(felt, window)
            return np.where(is_felt, felt, heights), forbidden | learnt
        known = np.zeros(forbidden.shape, dtype=bool)
        self._known.lay_over(known, window)
        seen = np.full(forbidden.shape, math.nan)
        self._seen.lay_over(seen, window)
        found = kinds(seen, known, self.tiles.whole.cell, mapper.machine, mapper.final) != Kind.O
        unknown = ~known & (mapper.unknown == "forbidden")
        return np.where(known, seen, mapper.level), found | learnt | unknown


def _are_equal(one: Array, other: Array) -> CellFlags:
    """Where heights are equal, holes included."""
    return np.asarray((one == other) | (np.isnan(one) & np.isnan(other)))


def belief_of(
    ground: Ground, forbidden: CellFlags, machine: Machine, crests: Array | None
) -> TerrainMap:
    """The true ground as a map, whose crests, m, may be known already."""
    belief = TerrainMap(
        ground.heights,
        forbidden,
        ground.cell,
        ground.origin,
        machine.foot_radius,
        edge=ground.edge,
        relief=ground.relief,
    )
    return belief if crests is None else with_crests(belief, crests)
