"""``Perception``: the true ground, and what the machine believes of it.

With ``sensing = "known"`` the belief is the truth, and what a foot has learnt the hard way. With
"eye" and "none" an ``ElevationMapper`` grows a map from what the range sensor sees and the feet
touch.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Sequence

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.control.supervisor import GaitSupervisor
from walking_console.planner.control.touch_memory import Felt
from walking_console.planner.geometry.transforms import left_fold_sum
from walking_console.planner.protocols import Plant
from walking_console.planner.terrain.grid import Window, around_cells
from walking_console.planner.terrain.map import TerrainMap, changed_in
from walking_console.planner.terrain.mapping import ElevationMapper, Index
from walking_console.planner.terrain.traversability import classify_again
from walking_console.planner.types import Command, Sensing

from .foot_touches import FootTouches, touch
from .giving_ground import GivingGround
from .range_sensor import RangeSensor, Scan
from .requests import Edit, edited, rows_and_columns
from .snapshot import TerrainView
from .surroundings import Seen, Surroundings, window_on
from .terrain.ground import Ground
from .world import World, true_forbidden

# rad; before it sets out the range sensor has looked everywhere
ALL_ROUND = (0.0, 2 * math.pi / 3, -2 * math.pi / 3)
# m around the start: ground the machine was set down on, known whatever the range sensor sees
SET_DOWN = 1.2
# ticks of a walk in one of which a block of the map is renewed: about all in view in a step
RENEWING = 3
SENSOR_STREAM = 9  # of the scenario's seed: the range sensor draws from a generator of its own


class Perception:
    """The ground as it is and as it is believed to be, and how the one becomes the other.

    ``revision`` counts what viewers must draw again; it goes on across a reset.
    """

    def __init__(self, world: World, body: Sequence[float], revision: int = 0) -> None:
        self.world = world
        self.ground = world.ground
        self.loose = GivingGround(world.scenario.terrain.gives_way, world.machine)
        self.belief = world.belief
        self.true_forbidden = world.forbidden
        self.wide = world.surroundings()
        # cells an operator has forbidden, whatever their height
        self._marked = np.zeros_like(world.forbidden)
        self.revision = revision
        self._view: TerrainView | None = None
        self.mapper: ElevationMapper | None = None
        self.range_sensor: RangeSensor | None = None
        self._scan: Generator[None, None, Scan] | None = None  # under way
        self._foot_touches = FootTouches()
        # of the plant, the oldest first: the one that is acted on, where sensors are late
        late = world.scenario.noise.late if world.scenario.noise else 0
        self.readings: deque[Sensing] = deque(maxlen=1 + late)
        if world.scenario.sensing != "known":
            self._begin_to_map(world, body)

    def _begin_to_map(self, world: World, body: Sequence[float]) -> None:
        """Before the first tick only the ground the machine was set down on is known."""
        scenario = world.scenario
        self.mapper = mapper = _empty_mapper(world)
        mapper.touch(world.stance.feet)
        mapper.set_prior(world.stance.feet)
        if scenario.sensing == "eye":
            rng = np.random.default_rng([scenario.seed, SENSOR_STREAM])
            self.range_sensor = RangeSensor(world.machine, world.ground, rng, scenario.eye)
            x, y = world.stance.body[:2]
            mapper.see(*disc(world.ground, x, y, SET_DOWN))
            for direction in ALL_ROUND:
                mapper.see(*self.range_sensor.scan(body, direction))
        self._believe(mapper.publish().work_out())

    def perceive(
        self,
        sensing: Sensing,
        supervisor: GaitSupervisor,
        body: Sequence[float],
        command: Command,
        tick: int,
    ) -> None:
        """What the feet touch and the range sensor sees goes into the map; planning gets a new one
        at step switches and at rest.

        Never in the middle of planning from a stand: it would begin anew at every scan. A scan is
        spread over the ticks until the next: a few bearings in each, and then what it has found,
        a part of the map in each.
        """
        mapper = self.mapper
        if mapper is None:
            return
        at_rest = _at_rest(supervisor, command)
        begins = self._look_on(mapper, body, command.crab_angle, tick)
        if at_rest or self.range_sensor is None or tick % RENEWING == 0:
            mapper.work_on()
        if self._foot_touches.count_now(supervisor, sensing):
            touch(mapper, sensing)
        elif not (begins and at_rest):
            return
        believed = mapper.publish_worked()
        if believed is not self.belief:
            self._believe(believed.work_out())

    def _look_on(
        self, mapper: ElevationMapper, body: Sequence[float], direction: float, tick: int
    ) -> bool:
        """One tick of looking; True in the tick in which a scan begins."""
        sensor = self.range_sensor
        if sensor is None:
            return False
        begins = tick % sensor.settings.every == 0
        if begins:
            self._scan = sensor.scanning(body, direction)
        if self._scan is not None:
            # the pauses, and what comes after the last, before the next scan begins
            slices = math.ceil((sensor.pauses + 1) / sensor.settings.every)
            self._scan = _scanned(self._scan, slices, mapper)
        return begins

    @property
    def scan_is_over(self) -> bool:
        """True when nothing of a scan of the range sensor is left to be looked at."""
        return self._scan is None

    def keep_up(self, plant: Plant[Ground], supervisor: GaitSupervisor) -> None:
        """A tick on a wide map: what the machine comes near is worked out, and when it has come far
        enough ground and belief go along with it.
        """
        # what feet have felt is told by the cells of the window they felt it in
        if self.wide is None or supervisor.contacts.has_news:
            return
        x, y = plant.body[:2]
        window = self.wide.next_window(x, y)
        if window is None or not self.scan_is_over:
            return
        self._go_on_to(window, self.wide)
        plant.replace_ground(self.ground)

    def _go_on_to(self, window: Window, wide: Surroundings) -> None:
        """Ground, belief and whatever has a value a cell, in another window of a wide map."""
        before, truth = self.ground, self.true_forbidden
        self.ground, forbidden, crests = window_on(wide.tiles, before, window)
        self._marked = wide.marks(window, self._marked)
        self.true_forbidden = forbidden | self._marked
        if self.range_sensor is not None:
            self.range_sensor.replace_ground(self.ground)
        if self.mapper is None:
            seen = Seen(self.ground, self.true_forbidden, crests)
            belief = wide.belief_in(seen, before, truth, self.belief)
        else:
            wide.move_map(self.mapper, window)
            belief = self.mapper.publish_worked()
        wide.go_on_to(window)
        self._believe(belief.work_out())

    def learn(self, felt: Felt) -> None:
        """Cells (row, column) a foot has found to be no ground are forbidden from now on; what it
        has felt beside it stands at least so high.
        """
        if self.mapper is None:
            self._believe(self.belief.told(felt.prohibited, felt.heights))
            return
        self.mapper.learn(felt.prohibited)
        self.mapper.feel(felt.heights)
        self._believe(self.mapper.publish_worked().work_out())

    def give_way(self, plant: Plant[Ground]) -> None:
        """Loose ground goes down under the feet; the belief stays, for feet and eye to find it
        out.
        """
        ground = self.loose.after(plant, self.ground)
        if ground is self.ground:
            return
        self.ground = ground
        if self.wide is None or ground.whole is None:
            forbidden = true_forbidden(ground, self.world.machine)
        else:
            self.wide.truth_changed(ground.whole)
            _, forbidden, _ = self.wide.tiles.over(ground.cells)
        self.true_forbidden = forbidden | self._marked
        if self.range_sensor is not None:
            self.range_sensor.replace_ground(ground)
        self._view = None
        self.revision += 1
        plant.replace_ground(ground)

    def edit(self, edit: Edit) -> None:
        """Change the true ground; raises ``ValueError`` before anything has changed.

        A machine that maps for itself is told only what is forbidden or cleared.
        """
        before = self.ground.heights
        truth = self.true_forbidden
        self.ground = edited(self.ground, edit)
        rows, columns = self._in_window(edit)
        if edit.action in ("forbid", "clear"):
            self._marked = self._marked.copy()
            self._marked[rows, columns] = edit.action == "forbid"
        self.true_forbidden = self._forbidden_after(edit, rows, columns) | self._marked
        if self.mapper is not None:
            self._hear_of(edit, self.mapper, rows, columns)
            return
        if not rows.size:
            return
        heights = self.ground.heights
        learnt = self.belief.forbidden & ~truth
        learnt[rows, columns] = False
        # what feet have felt elsewhere stays
        believed = heights if self.belief.heights is before else self.belief.heights
        now = heights[rows, columns]
        if not np.array_equal(believed[rows, columns], now, equal_nan=True):
            believed = believed.copy()
            believed[rows, columns] = now
        forbidden = self.true_forbidden | learnt
        window = around_cells(rows, columns)
        self._believe(changed_in(self.belief, window, believed, forbidden))

    def _in_window(self, edit: Edit) -> tuple[Index, Index]:
        """The cells of an edit as the ground at hand numbers them; those of a wide map that it does
        not hold are changed beyond it.
        """
        rows, columns = rows_and_columns(edit)
        if self.wide is None or not rows.size:
            return rows, columns
        ground = self.ground
        self._view = None
        self.revision += 1
        if ground.whole is not None:
            self.wide.truth_changed(ground.whole)
        at_row, at_column = rows - ground.corner[0], columns - ground.corner[1]
        here = (at_row >= 0) & (at_row < ground.rows)
        here &= (at_column >= 0) & (at_column < ground.columns)
        self.wide.change_beyond(
            rows[~here], columns[~here], edit.action, maps=self.mapper is not None
        )
        return at_row[here], at_column[here]

    def _forbidden_after(self, edit: Edit, rows: Index, columns: Index) -> NDArray[np.bool_]:
        heights = self.ground.heights
        if self.ground.final:
            return np.isnan(heights)
        if not rows.size or edit.action == "forbid":
            return self.true_forbidden
        machine = self.world.machine
        cells = list(zip(rows.tolist(), columns.tolist(), strict=True))
        return classify_again(heights, self.true_forbidden, self.ground.cell, machine, cells)

    def _hear_of(self, edit: Edit, mapper: ElevationMapper, rows: Index, columns: Index) -> None:
        """The world has changed behind its back; only what is forbidden or cleared is told."""
        if self.range_sensor is not None:
            self.range_sensor.replace_ground(self.ground)
        cells = zip(rows.tolist(), columns.tolist(), strict=True)
        if edit.action == "forbid":
            mapper.learn(cells)
        elif edit.action == "clear":
            mapper.forget(cells)
        self._believe(mapper.publish_worked().work_out())

    def _believe(self, belief: TerrainMap) -> None:
        self.belief = belief
        self._view = None
        self.revision += 1

    def view(self) -> TerrainView:
        """The ground as viewers draw it; a new revision only when something changed."""
        if self._view is None:
            belief = self.belief
            ground = self.ground
            self._view = TerrainView(
                self.revision,
                ground.heights,
                belief.forbidden,
                belief.cell,
                belief.origin,
                ground.corner,
                ground.whole,
            )
        return self._view


def _empty_mapper(world: World) -> ElevationMapper:
    """A map of the ground's cells with nothing known yet; unknown ground is level with the feet."""
    ground = world.ground
    feet = world.stance.feet
    return ElevationMapper(
        (ground.rows, ground.columns),
        ground.cell,
        ground.origin,
        world.machine,
        unknown=world.scenario.unknown,
        final=ground.final,
        level=left_fold_sum(foot[2] for foot in feet) / len(feet),
        edge=ground.edge,
        relief=bool(ground.relief),
    )


def _scanned(
    scan: Generator[None, None, Scan], slices: int, mapper: ElevationMapper
) -> Generator[None, None, Scan] | None:
    """So many slices of a scan; what is left of it, None when the mapper has been told all."""
    try:
        for _ in range(slices):
            next(scan)
    except StopIteration as done:
        mapper.see(*done.value)
        return None
    return scan


def _at_rest(supervisor: GaitSupervisor, command: Command) -> bool:
    return supervisor.stands and (command.holds or supervisor.blocked is not None)


def disc(
    ground: Ground, x: float, y: float, radius: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Rows, columns and true heights of the cells whose centres are within ``radius`` of (x, y)."""
    dx = ground.origin[0] + (np.arange(ground.columns) + 0.5) * ground.cell - x
    dy = ground.origin[1] + (np.arange(ground.rows) + 0.5) * ground.cell - y
    rows, columns = np.nonzero(np.hypot(dx[None, :], dy[:, None]) <= radius)
    return rows, columns, ground.heights[rows, columns]
