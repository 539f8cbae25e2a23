"""What a touch teaches the map: heights beside the foot, and cells no foot may land on (H §9.2)."""

from __future__ import annotations

from ..geometry.transforms import placed
from ..terrain.map import TerrainMap
from ..types import Point
from .encounter import ContactEvent, Encounter, FootState, ceiling
from .execution import Execution, feet_absolute
from .feelers import CLOSE, Touch, felt_towards, hangs_over_towards, stands_beside
from .touch_memory import CellSet, Felt, cell_of, cells_ahead, cells_near, edge_cells
from .walk_state import Now


class TouchLessons:
    """What touch has shown since the map was last told; ``felt`` holds it."""

    def __init__(self, run: Execution) -> None:
        self.felt = Felt()
        self._run = run
        self._settings = run.config.contact

    def take(self) -> Felt:
        """What touch has shown, once."""
        felt = self.felt
        self.felt = Felt()
        return felt

    def gave_way(self, foot: Point, terrain: TerrainMap) -> None:
        """The foothold here gave way, and what lies around it may do so too."""
        self.felt.prohibited |= cells_near(foot, self._settings.edge_depth, terrain)

    def learn(self, touch: Touch, encounter: Encounter | None, now: Now) -> None:
        """What touch has shown: how high ground stands beside the foot, and which cells no foot may
        land on, or a rectangle of them along an edge whose direction was felt. There is no ground
        where a foot has gone down as far as its leg reaches, and has met none.
        """
        foot = feet_absolute(now.sensing)[touch.leg]
        under = cell_of(foot, now.terrain)
        if touch.event is ContactEvent.HIT and touch.bearing is not None:
            self.felt.raise_to(self._ahead(foot, touch.bearing, now.terrain), foot[2])
        if encounter is not None and _bars_the_way(touch.event, encounter):
            self._learn_a_bar(touch, encounter, now)
        elif touch.event is ContactEvent.EDGE:
            self._learn_a_bad_foothold(touch, now)
        elif touch.event is ContactEvent.NO_GROUND and _reached_the_bottom(encounter):
            self.felt.prohibited |= under
            self.felt.dig(under)

    def _learn_a_bad_foothold(self, touch: Touch, now: Now) -> None:
        """It is on an edge, or close beside what stands taller: cells along either are prohibited,
        and what stands beside it is at least as high as it was first felt.
        """
        foot = feet_absolute(now.sensing)[touch.leg]
        self.felt.prohibited |= cell_of(foot, now.terrain)
        edge = hangs_over_towards(touch.leg, now.sensing)
        wall = stands_beside(touch.leg, now.sensing)
        if edge is not None:
            self.felt.prohibited |= self._edge(foot, edge, now.terrain)
        elif wall is not None and touch.tall is not None:
            radius = self._run.machine.foot_radius
            length = self._settings.edge_length
            reach = CLOSE * (radius + self._settings.whisker_tip)
            size = length, reach + radius
            self.felt.prohibited |= cells_ahead(foot, wall, now.terrain, size)
            x, y = placed((foot[0], foot[1], wall), reach, 0.0)
            size = length, self._settings.edge_depth
            beyond = cells_ahead((x, y, foot[2]), wall, now.terrain, size)
            self.felt.raise_to(beyond, touch.tall)

    def _learn_a_bar(self, touch: Touch, encounter: Encounter, now: Now) -> None:
        """What a leg cannot be drawn over, or what kept a foot from its place."""
        foot = feet_absolute(now.sensing)[touch.leg]
        under = cell_of(foot, now.terrain)
        edge = felt_towards(encounter, now.sensing)
        edge = encounter.felt if edge is None else edge
        barred = under if edge is None else self._edge(foot, edge, now.terrain)
        home = self._run.stance.feet[touch.leg]  # it stood there: it can go back
        barred -= cells_near(home, self._run.machine.foot_radius, now.terrain)
        self.felt.prohibited |= barred
        if edge is not None and touch.event is ContactEvent.TOP:
            wall = self._wall(foot, edge, now)
            wall -= cells_near(home, self._settings.edge_depth, now.terrain)
            self.felt.raise_to(wall - under, self._beyond_reach(touch.leg, now))

    def _wall(self, foot: Point, bearing: float, now: Now) -> CellSet:
        """Cells of what no leg can be drawn over: as far to either side as is supposed, but not
        where feet stand.
        """
        size = self._settings.wall_length, self._settings.edge_depth
        cells = cells_ahead(foot, bearing, now.terrain, size)
        for leg, place in enumerate(feet_absolute(now.sensing)):
            if now.sensing.soles[leg]:
                cells -= cells_near(place, self._settings.edge_depth, now.terrain)
        return cells

    def _beyond_reach(self, leg: int, now: Now) -> float:
        """A height, m, that this leg cannot be drawn up to."""
        here = self._run.actual(now.sensing, self._run.plan.end)
        return ceiling(here, leg, self._run.machine) + self._settings.lift_step

    def _ahead(self, foot: Point, bearing: float, terrain: TerrainMap) -> CellSet:
        """The cell at the tip of a whisker."""
        reach = self._run.machine.foot_radius + self._settings.whisker_tip
        x, y = placed((foot[0], foot[1], bearing), reach, 0.0)
        return cell_of((x, y, foot[2]), terrain)

    def _edge(self, foot: Point, bearing: float, terrain: TerrainMap) -> CellSet:
        return edge_cells(foot, bearing, terrain, self._settings)


def _reached_the_bottom(encounter: Encounter | None) -> bool:
    """True of a foot that has gone down as far as its leg reaches, and of no other."""
    return encounter is not None and encounter.state in (FootState.RETRY, FootState.DESCEND)


def _bars_the_way(event: ContactEvent, encounter: Encounter) -> bool:
    if event is ContactEvent.TOP:
        return True
    return event is ContactEvent.HIT and encounter.state is FootState.PLACE
