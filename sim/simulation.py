"""``Simulation``: owns the plant, the walk, the belief and the command. No clock, no sockets.

The same object serves the browser, REST, the command line and the tests: ``order`` leaves a command
in the mailbox (the newest wins), ``request`` leaves a request that the next tick drains first,
``tick`` moves the world by 20 ms, ``snapshot`` shows it. Commands may expire: then the machine
holds.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from walking_console.planner import registry, stability
from walking_console.planner.control.foot_controller import Gains
from walking_console.planner.control.supervisor import (
    DT,
    GaitSupervisor,
    Think,
    Thinking,
    feet_absolute,
)
from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.initial_stance import stance_on
from walking_console.planner.navigation.local_planner import RouteState, plan_route
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.terrain.map import TerrainMap, classify, classify_again
from walking_console.planner.terrain.mapping import ElevationMapper
from walking_console.planner.types import (
    Blocked,
    Command,
    Gait,
    GaitPreview,
    Mode,
    Sensing,
    Stance,
    StepPlan,
)
from walking_console.sim.kinematic.plant import KinematicPlant, Noise
from walking_console.sim.range_sensor import RangeSensor
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.snapshot import Snapshot, TerrainView
from walking_console.sim.terrain.ground import HEIGHT_MAX, Ground, make_ground

HOLD = Command()
EDITS = ("dig", "raise", "forbid", "clear")
EDIT_CELLS_MAX = 40_000  # cells one terrain edit may change
COURSES_MAX = 3  # courses Level B1 may offer for one step before the walk is called blocked
# rad; before it sets out the eye has looked everywhere
LOOK_ROUND = (0.0, 2 * math.pi / 3, -2 * math.pi / 3)
# m around the start: ground the machine was set down on, known whatever the eye sees
SET_DOWN = 1.2


@dataclass(frozen=True)
class World:
    """Everything slow, made outside the walking thread: ground, machine, belief, start posture."""

    scenario: Scenario
    machine: Machine
    gait: Gait
    ground: Ground
    belief: TerrainMap
    forbidden: NDArray[np.bool_]  # true ground, for this machine
    stance: Stance
    course: SampledPath | None = None  # a trace walker's given trace


def prepare(scenario: Scenario, machine: Machine | None = None) -> World:
    """Make a scenario's world; raises ``MachineError``, ``GroundError`` or ``ScenarioError`` with
    one clear line.
    """
    machine = machine or load_machine(scenario.robot, scenario.base)
    gait = scenario.gait_for(machine)
    start = scenario.start_pose
    course = given_trace(scenario, machine)
    posture = stance_at_start(scenario, machine, gait, lambda x, y: 0.0)
    ground = make_ground(
        scenario.terrain,
        machine,
        start,
        scenario.seed,
        scenario.span(machine),
        scenario.base,
        stand=[foot[:2] for foot in posture.feet],
    )
    forbidden = true_forbidden(ground, machine)
    belief = TerrainMap(ground.heights, forbidden, ground.cell, ground.origin, machine.foot_radius)
    stance = stance_at_start(scenario, machine, gait, ground.height_at)
    return World(scenario, machine, gait, ground, belief, forbidden, stance, course)


def given_trace(scenario: Scenario, machine: Machine) -> SampledPath | None:
    """The scenario's trace, sampled; None without one. Raises ``ScenarioError``."""
    if scenario.trace is None:
        return None
    try:
        return registry.drawn_trace(scenario.trace.model_dump(), machine, scenario.start_pose)
    except registry.PlannerError as error:
        raise ScenarioError(f"trace: {error}") from None


def stance_at_start(
    scenario: Scenario, machine: Machine, gait: Gait, height_at: Callable[[float, float], float]
) -> Stance:
    """The posture a scenario begins in: that of its planner, or its own feet. Raises
    ``ScenarioError``.
    """
    if scenario.start.feet is None:
        course, pose = first_crab_angle(scenario), scenario.start_pose
        return registry.start_stance(
            scenario.planner, machine, gait, course, pose, height_at, scenario.mode
        )
    try:
        return stance_on(machine, gait, scenario.start.feet, *scenario.start_pose, height_at)
    except ValueError as error:
        raise ScenarioError(f"start.feet: {error}") from None


def first_crab_angle(scenario: Scenario) -> float:
    """α of the first command: the standard posture is that of the first course (0 with no command
    yet).
    """
    return math.radians(scenario.drive[0].crab_angle_deg) if scenario.drive else 0.0


def true_forbidden(ground: Ground, machine: Machine) -> NDArray[np.bool_]:
    """Where this machine must not step on the true ground; on ``final`` ground exactly the holes."""
    return (
        np.isnan(ground.heights) if ground.final else classify(ground.heights, ground.cell, machine)
    )


@dataclass(frozen=True)
class Reset:
    """Back to the start of the scenario."""


@dataclass(frozen=True)
class Load:
    """Another world, made by ``prepare``."""

    world: World


@dataclass(frozen=True)
class Edit:
    """Change cells of the true ground and of the belief: dig, raise (by ``amount`` m), forbid or
    clear.
    """

    action: str  # dig | raise | forbid | clear
    cells: tuple[tuple[int, int], ...]  # (row, column)
    amount: float = 0.0


@dataclass(frozen=True)
class Push:
    """A horizontal force on the torso, N, for a number of ticks."""

    fx: float
    fy: float
    ticks: int = 1


@dataclass(frozen=True)
class Pose:
    """Take a posture: sit, stand, or standard (its feet in the layout of the last course). The
    machine stops first.
    """

    posture: str


@dataclass(frozen=True)
class Halt:
    """Stop in whatever posture it is being taken to; a walking machine holds by its command."""


@dataclass(frozen=True)
class Follow:
    """Keep the body level, or let it follow the ground as far as strides allow, from the next step
    planned on.
    """

    attitude: str  # level | ground


Request = Reset | Load | Edit | Push | Pose | Halt | Follow


class Simulation:
    """The walking console without a clock: one ``tick`` is 20 ms of simulated time."""

    def __init__(self, world: World, *, explain: bool = False) -> None:
        self.explain = explain
        self.inbox: deque[Request] = deque()
        self.refused = ""  # why the last refused request was refused
        self.revision = 0
        self._mailbox: tuple[Command, int | None] = (HOLD, None)
        self.on_input: Callable[[int, object], None] | None = None
        self._set_up(world)

    def _set_up(self, world: World) -> None:
        self.world = world
        self.ground = world.ground
        self.belief = world.belief
        self.true_forbidden = world.forbidden
        # cells an operator has forbidden, whatever their height
        self.marked = np.zeros_like(world.forbidden)
        wanted = world.scenario.noise
        noise = None if wanted is None else Noise(wanted.position, wanted.posture)
        self.plant = KinematicPlant(
            world.machine,
            world.ground,
            world.stance,
            noise=noise,
            rng=np.random.default_rng(world.scenario.seed),
        )
        layout = partial(
            registry.start_stance,
            world.scenario.planner,
            world.machine,
            world.gait,
            mode=world.scenario.mode,
        )
        course = first_crab_angle(world.scenario)
        self.walk = GaitSupervisor(
            world.machine,
            world.gait,
            world.stance,
            self._thinker(world),
            Gains(),
            layout=layout,
            crab_angle=course,
        )
        self.command = HOLD
        self.route = RouteState()
        self._mailbox = (HOLD, None)
        self.tick_count = 0
        self.distance = 0.0
        self.revision += 1
        self._drawn_terrain: TerrainView | None = None
        self._foreseen: tuple[tuple[object, ...], GaitPreview | None] = ((), None)
        self._begin_to_know(world)

    def _thinker(self, world: World) -> Think:
        scenario = world.scenario
        if scenario.planner == "trace":
            return registry.trace_brain(
                world.machine, world.gait, world.course, scenario.gait.rigid, explain=self.explain
            )
        via = self._along_a_route if scenario.detours and scenario.mode != "naive" else None
        return registry.crab_brain(
            scenario.mode, world.machine, world.gait, scenario.attitude, via, explain=self.explain
        )

    def _along_a_route(
        self, think: Think, machine: Machine, stance: Stance, command: Command, terrain: TerrainMap
    ) -> Thinking:
        """Level B1, then B2 to B4 on the course it gives; where they find no step B1 is asked for
        another.
        """
        command = replace(command, speed=self.command.speed)
        scenario, refused, first = self.world.scenario, list[float](), None
        cautious, stretches = scenario.sensing == "eye", scenario.mode == "predictive"
        for _ in range(COURSES_MAX):
            steered, route, why = plan_route(
                self.route, command, stance, terrain, machine, refused, cautious, stretches
            )
            answer = why or (yield from think(stance, steered, terrain))
            first = first or (route, answer)
            if isinstance(answer, StepPlan):
                self.route = route
                return answer
            if why is not None or command.turn_rate != 0.0:
                break
            refused.append(route.offset)
        assert first is not None
        self.route, answer = replace(first[0], speed_limit=math.inf), first[1]
        return answer

    # what it knows of the ground

    def _begin_to_know(self, world: World) -> None:
        """With ``sensing = "known"`` the map is the truth; else it begins with the ground the
        machine was set down on.
        """
        self.memory: ElevationMapper | None = None
        self.eye: RangeSensor | None = None
        self._steps_known = -1
        scenario, ground = world.scenario, world.ground
        if scenario.sensing == "known":
            return
        level = sum(foot[2] for foot in world.stance.feet) / len(world.stance.feet)
        shape, machine = ground.heights.shape, world.machine
        self.memory = ElevationMapper(
            (shape[0], shape[1]),
            ground.cell,
            ground.origin,
            machine,
            unknown=scenario.unknown,
            final=ground.final,
            level=level,
        )
        self.memory.touch(world.stance.feet)
        if scenario.sensing == "eye":
            self.eye = RangeSensor(
                machine, ground, np.random.default_rng([scenario.seed, 9]), scenario.eye
            )
            self.memory.see(*disc(ground, world.stance.body[0], world.stance.body[1], SET_DOWN))
            for direction in LOOK_ROUND:
                self.memory.see(*self.eye.look(self.plant.body, direction))
        self._believe(self.memory.publish())

    def _perceive(self, memory: ElevationMapper, sensing: Sensing) -> None:
        """What the feet touch and the eye sees goes into the memory; planning gets a new map at
        step switches and at rest.

        Never in the middle of a thought from standing: it would begin anew at every look.
        """
        eye, walk = self.eye, self.walk
        looks = eye is not None and self.tick_count % eye.settings.every == 0
        if eye is not None and looks:
            memory.see(*eye.look(self.plant.body, self.command.crab_angle))
        if walk.steps_begun != self._steps_known:
            self._steps_known = walk.steps_begun
            standing = [
                foot
                for foot, sole in zip(feet_absolute(sensing), sensing.soles, strict=True)
                if sole
            ]
            memory.touch(standing)
            if standing:
                memory.suppose(standing)
        elif not (
            looks and walk.kind == "stand" and (walk.blocked is not None or self.command.holds)
        ):
            return
        believed = memory.publish()
        if believed is not self.belief:
            self._believe(believed)

    # what anybody may leave for the next tick

    def order(self, command: Command, ttl_ticks: int | None = None) -> None:
        """The newest command wins; after ``ttl_ticks`` ticks without another the machine holds."""
        self._mailbox = (command, None if ttl_ticks is None else self.tick_count + ttl_ticks)

    def request(self, request: Request) -> None:
        """Any thread; drained first in the next tick, in order."""
        self.inbox.append(request)

    # the world moves

    def drain(self) -> None:
        """Serve what was requested. An edit that no longer fits the ground (another world came
        first) is dropped whole, and said.
        """
        while self.inbox:
            try:
                self._serve(self.inbox.popleft())
            except ValueError as refusal:
                self.refused = str(refusal)

    def tick(self) -> None:
        """20 ms of the world: requests, command, Level B and C, plant."""
        self.drain()
        command, expires = self._mailbox
        if expires is not None and self.tick_count >= expires:
            command = HOLD
        if command is not self.command and command != self.command:
            if self.on_input is not None:
                self.on_input(self.tick_count, command)
            self.command = command
        plant, walk = self.plant, self.walk
        if plant.state == "fallen":
            self.tick_count += 1
            return
        sensing = plant.sense()
        if command.holds:
            self.route = RouteState()
        elif self.route.speed_limit < command.speed:
            command = replace(command, speed=self.route.speed_limit)
        velocities = walk.advance(sensing, command, self.belief)
        x, y = plant.body[0], plant.body[1]
        plant.move(velocities)
        if not command.holds:
            self._count_distance(plant.body[0] - x, plant.body[1] - y, command)
        if walk.executed is not None:
            learnt = walk.take_learnt()
            if learnt and self.memory is None:
                self._believe(self.belief.forbid(learnt))
            elif learnt and self.memory is not None:
                self.memory.learn(learnt)
                self._believe(self.memory.publish())
        if self.memory is not None:
            self._perceive(self.memory, sensing)
        self.tick_count += 1

    def _count_distance(self, dx: float, dy: float, command: Command) -> None:
        """Planar path of the centre of gravity along the commanded direction; turning alone is no
        way.
        """
        if dx == 0.0 and dy == 0.0:
            return
        if self.world.scenario.trace is not None:  # the commanded direction is the trace's own
            self.distance += math.hypot(dx, dy)
            return
        heading = self.plant.body[5] + command.crab_angle
        self.distance += dx * math.cos(heading) + dy * math.sin(heading)

    def _serve(self, request: Request) -> None:
        if isinstance(request, Edit):
            self._edit(request)  # raises before anything has changed
        elif isinstance(request, Pose):
            self._pose(request)
        elif isinstance(request, Halt):
            if not self.walk.posing:
                return
            self.walk.halt()
        elif isinstance(request, Follow):
            registry.take_attitude(self.walk.think, request.attitude)
        if self.on_input is not None:
            self.on_input(self.tick_count, request)
        if isinstance(request, Reset):
            self._set_up(self.world)
        elif isinstance(request, Load):
            self._set_up(request.world)
        elif isinstance(request, Push):
            self.plant.push(request.fx, request.fy, request.ticks)

    def _pose(self, wanted: Pose) -> None:
        """Refused with a reason, or taken from the next standstill on; the command it walks by ends
        here.
        """
        why = self.reason if self.plant.state != "standing" else self.walk.pose(wanted.posture)
        if why:
            raise ValueError(why)
        if not self._mailbox[0].holds:
            self._mailbox = (HOLD, None)

    def _edit(self, edit: Edit) -> None:
        heights = edited(self.ground.heights, edit)
        rows, columns = (
            np.array([cell[axis] for cell in edit.cells], dtype=np.intp) for axis in (0, 1)
        )
        if edit.action in ("forbid", "clear"):
            self.marked = self.marked.copy()
            self.marked[rows, columns] = edit.action == "forbid"
        self.ground = replace(self.ground, heights=heights)
        if self.ground.final:
            forbidden = np.isnan(heights)
        elif edit.cells:
            forbidden = classify_again(
                heights, self.true_forbidden, self.ground.cell, self.world.machine, edit.cells
            )
        else:
            forbidden = self.true_forbidden
        self.true_forbidden = forbidden | self.marked
        self.plant.replace_ground(self.ground)
        if self.memory is not None:
            self._hear_of(edit, self.memory)
            return
        known = self.belief.forbidden & ~self.world.forbidden
        known[rows, columns] = False
        self._believe(replace(self.belief, heights=heights, forbidden=self.true_forbidden | known))

    def _hear_of(self, edit: Edit, memory: ElevationMapper) -> None:
        """The world has changed behind its back; only what is forbidden or cleared is told to it."""
        if self.eye is not None:
            self.eye.replace_ground(self.ground)
        if edit.action == "forbid":
            memory.learn(edit.cells)
        elif edit.action == "clear":
            memory.forget(edit.cells)
        self._believe(memory.publish())

    def _believe(self, belief: TerrainMap) -> None:
        self.belief = belief
        self._drawn_terrain = None
        self.revision += 1

    # what anybody may see

    @property
    def mode(self) -> Mode:
        """What the walker is doing; the plant's own state comes first."""
        if self.plant.state == "fallen":
            return Mode.FALLEN
        if self.plant.state == "tipping":
            return Mode.TIPPING
        return self.walk.mode

    @property
    def reason(self) -> str:
        """Why it is blocked, tipping or fallen; empty otherwise."""
        if self.plant.state == "fallen":
            return "the machine has fallen over"
        if self.plant.state == "tipping":
            return "the centre of gravity has left the support polygon"
        blocked: Blocked | None = self.walk.blocked
        if blocked is None:
            return ""
        return blocked.reason if blocked.leg is None else f"leg {blocked.leg + 1}: {blocked.reason}"

    def margins(self, carrying: Iterable[bool]) -> tuple[float, float]:
        """Longitudinal and polygon margin of the feet meant to carry, m."""
        feet = self.plant.feet
        polygon = stability.support_polygon(
            [foot for foot, carries in zip(feet, carrying, strict=True) if carries]
        )
        x, y, heading = self.plant.body[0], self.plant.body[1], self.walk.heading
        longitudinal = stability.longitudinal_margin(
            polygon, x, y, math.cos(heading), math.sin(heading)
        )
        return longitudinal, stability.polygon_margin(polygon, x, y)

    def terrain_view(self) -> TerrainView:
        """The ground as viewers draw it; a new revision only when something changed."""
        if self._drawn_terrain is None:
            belief = self.belief
            self._drawn_terrain = TerrainView(
                self.revision, self.ground.heights, belief.forbidden, belief.cell, belief.origin
            )
        return self._drawn_terrain

    def _ahead(self, running: StepPlan | None) -> GaitPreview | None:
        """What a trace walker foresees; worked out again only when it foresees something else."""
        walk = self.walk
        key = (getattr(walk.think, "prediction", None), walk.stance, running)
        if len(key) != len(self._foreseen[0]) or any(
            a is not b for a, b in zip(key, self._foreseen[0], strict=True)
        ):
            self._foreseen = key, registry.foreseen(walk.think, walk.stance, running)
        return self._foreseen[1]

    def snapshot(self, *, paused: bool = False, rate: float = 1.0, late: float = 0.0) -> Snapshot:
        """The world at this instant; ``paused``, ``rate`` and ``late`` are the clock's to say."""
        plant, walk, world = self.plant, self.walk, self.world
        carrying = walk.carrying()
        longitudinal, polygon = self.margins(carrying)
        feet = tuple((f[0], f[1], f[2]) for f in plant.feet)
        x, y, z, roll, pitch, yaw = plant.body
        standing = [foot for foot, carries in zip(feet, carrying, strict=True) if carries]
        stepping = walk.kind == "step"
        running = walk.plan if stepping else None
        return Snapshot(
            tick=self.tick_count,
            time=self.tick_count * DT,
            machine=world.machine,
            scenario=world.scenario.name,
            planner=world.scenario.planner,
            planner_mode=world.scenario.mode,
            body=(x, y, z, roll, pitch, yaw),
            feet=feet,
            contact=tuple(plant.soles),
            support=carrying,
            mode=self.mode,
            reason=self.reason,
            command=self.command,
            speed=walk.speed,
            speed_max=walk.plan.speed_max if stepping else 0.0,
            margin=longitudinal,
            polygon_margin=polygon,
            energy_margin=stability.energy_margin(standing, (x, y, z)),
            step=walk.steps_begun,
            distance=self.distance,
            plan=walk.plan if walk.kind not in ("stand", "hover") else None,
            plan_time=walk.t,
            ready=walk.ready,
            terrain=self.terrain_view(),
            flags=walk.flags,
            whiskers=tuple(plant.whiskers),
            paused=paused,
            rate=rate,
            late=late,
            course=registry.course_of(
                walk.think, walk.stance, running, (x, y, z, yaw), world.machine.yaw_length
            ),
            ahead=self._ahead(running),
            posture=walk.posture,
            attitude=registry.attitude_of(walk.think),
            decision=walk.blocked.decision
            if walk.blocked is not None
            else walk.plan.decision
            if walk.kind != "stand"
            else None,
        )


def disc(
    ground: Ground, x: float, y: float, radius: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Rows, columns and true heights of the cells around a point."""
    dx = ground.origin[0] + (np.arange(ground.columns) + 0.5) * ground.cell - x
    dy = ground.origin[1] + (np.arange(ground.rows) + 0.5) * ground.cell - y
    rows, columns = np.nonzero(np.hypot(dx[None, :], dy[:, None]) <= radius)
    return rows, columns, ground.heights[rows, columns]


def edited(heights: NDArray[np.float64], edit: Edit) -> NDArray[np.float64]:
    """Heights after an edit; raises ``ValueError`` before anything has changed."""
    if edit.action not in EDITS:
        raise ValueError(f"unknown terrain edit {edit.action!r}; there are: {', '.join(EDITS)}")
    if len(edit.cells) > EDIT_CELLS_MAX:
        raise ValueError(f"an edit changes at most {EDIT_CELLS_MAX} cells, got {len(edit.cells)}")
    rows, columns = (
        np.array([cell[axis] for cell in edit.cells], dtype=np.intp) for axis in (0, 1)
    )
    ny, nx = heights.shape
    if rows.size and not (
        rows.min() >= 0 and rows.max() < ny and columns.min() >= 0 and columns.max() < nx
    ):
        raise ValueError(f"cells must be within {ny} rows and {nx} columns")
    heights = heights.copy()
    if edit.action == "dig":
        heights[rows, columns] = np.nan
    elif edit.action == "raise":
        heights[rows, columns] += edit.amount
        if np.nanmax(np.abs(heights[rows, columns]), initial=0.0) > HEIGHT_MAX:
            raise ValueError(f"heights must be within {HEIGHT_MAX:g} m of 0")
    elif edit.action == "clear":
        heights[rows, columns] = np.where(
            np.isnan(heights[rows, columns]), 0.0, heights[rows, columns]
        )
    return heights
