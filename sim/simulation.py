"""``Simulation``: a machine, its planner and its ground, stepped together. No clock, no sockets.

The same object serves the browser, REST, the command line, notebooks and the tests: ``drive``
leaves a command (the newest wins), ``request`` leaves what the next step serves first, ``step``
moves the world by 20 ms, ``snapshot`` shows it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from walking_console.planner import registry
from walking_console.planner.control.execution import Execution
from walking_console.planner.control.supervisor import GaitSupervisor
from walking_console.planner.geometry.transforms import XY, direction
from walking_console.planner.protocols import (
    Planner,
    PlannerError,
    PlannerSetup,
    Plant,
    checked_attitude,
)
from walking_console.planner.types import (
    TICK,
    Blocked,
    Command,
    GaitPreview,
    Mode,
    StepPlan,
)

from .margins import Margins, margins_of
from .observation import take_snapshot
from .perception import Perception
from .plants import plant_entry
from .requests import Edit, Follow, Halt, Load, Push, Request, Reset, TakePosture
from .scenario import Scenario
from .sensor_noise import SensorNoise
from .snapshot import Snapshot
from .terrain.ground import Ground
from .world import World, first_crab_angle, prepare

HOLD = Command()


class Simulation:
    """One machine walking in one world; a step is 20 ms of simulated time.

    ``scenario_or_world`` is a ``Scenario``, or the ``World`` that ``prepare`` made of one (making
    it is slow; a world can be used again). ``explain`` fills the decision log of every step. Raises
    what ``prepare`` raises.

    Read freely, change only through the methods: ``plant`` (the machine), ``planner``, ``walk``
    (its gait supervisor), ``perception`` (the ground, and what is believed of it), ``command``,
    ``tick_count``, ``distance`` (m walked along the commanded course) and ``refused`` (why the last
    refused request was). ``on_input`` is called with the tick and every command or request served.

    >>> from walking_console import Simulation, load_scenario
    >>> sim = Simulation(load_scenario("holes"))
    >>> sim.drive(crab_angle=0.3, speed=0.1)
    >>> sim.run(seconds=10)
    >>> round(sim.distance, 2), sim.snapshot().step
    (0.76, 6)
    """

    def __init__(self, scenario_or_world: Scenario | World, *, explain: bool = False) -> None:
        given = scenario_or_world
        self.explain = explain
        self.refused = ""
        self.on_input: Callable[[int, object], None] | None = None
        self._inbox: deque[Request] = deque()
        self._set_up(prepare(given) if isinstance(given, Scenario) else given)

    def _set_up(self, world: World, revision: int = 1) -> None:
        self.world = world
        self.plant = _plant_in(world)
        self.planner = self._planner(world)
        self.walk = self._supervisor(world)
        self.perception = Perception(world, self.plant.body, revision)
        self.command = HOLD
        self._mailbox: tuple[Command, int | None] = (HOLD, None)  # and the tick it lapses at
        self.tick_count = 0
        self.distance = 0.0
        self._course: tuple[float, XY] = (0.0, direction(0.0))  # absolute, and its cosine, sine
        self.velocity = (0.0, 0.0)  # of the body in the last tick, absolute, m/s

    def _supervisor(self, world: World) -> GaitSupervisor:
        scenario, machine, gait = world.scenario, world.machine, world.gait
        layout = partial(registry.initial_stance, scenario.planner, scenario.mode, machine, gait)
        run = Execution(machine, gait, world.stance, scenario.planner_config, self.plant.tolerances)
        return GaitSupervisor(self.planner, run, layout, first_crab_angle(scenario))

    def _planner(self, world: World) -> Planner:
        scenario = world.scenario
        setup = PlannerSetup(
            world.machine,
            world.gait,
            scenario.mode,
            attitude=scenario.attitude,
            detours=scenario.detours,
            cautious=scenario.sensing == "eye",
            path=world.course,
            rigid_gait=scenario.gait.rigid,
            explain=self.explain,
            config=scenario.planner_config,
        )
        return registry.make_planner(scenario.planner, setup)

    # -- what anybody may leave for the next step

    def drive(
        self,
        crab_angle: float = 0.0,
        speed: float = 0.0,
        turn_rate: float = 0.0,
        ttl_ticks: int | None = None,
    ) -> None:
        """Walk from the next step on: towards ``crab_angle`` (rad, from straight ahead, positive to
        the left) at ``speed`` (m/s), turning by ``turn_rate`` (rad/s).

        The newest command wins. After ``ttl_ticks`` steps without another the machine holds; None
        is never. ``drive()`` holds at once.
        """
        self.order(Command(crab_angle, speed, turn_rate), ttl_ticks)

    def order(self, command: Command, ttl_ticks: int | None = None) -> None:
        """``drive`` with a ``Command``."""
        self._mailbox = (command, None if ttl_ticks is None else self.tick_count + ttl_ticks)

    def request(self, request: Request) -> None:
        """Leave a request for the next step, from any thread; they are served in order."""
        self._inbox.append(request)

    @property
    def requests_waiting(self) -> int:
        """How many requests the next step will serve."""
        return len(self._inbox)

    # -- the world moves

    def run(self, seconds: float) -> None:
        """Step through so many seconds of simulated time."""
        for _ in range(round(seconds / TICK)):
            self.step()

    def step(self) -> None:
        """20 ms of the world: requests, command, planner and supervisor, plant."""
        if self._inbox:
            self.serve_requests()
        command, lapses = self._mailbox
        if command is not self.command or lapses is not None:
            command = self._newest_command()
        plant, walk, perception = self.plant, self.walk, self.perception
        if plant.state == "fallen":
            self.tick_count += 1
            return
        readings = perception.readings
        readings.append(plant.sense())
        sensing = readings[0]  # an old one where sensors are late
        velocities = walk.advance(sensing, command, perception.belief)
        x, y = plant.body[:2]
        plant.move(velocities, walk.loads)
        if perception.loose.holding:
            perception.give_way(plant)
        body = plant.body
        dx, dy = body[0] - x, body[1] - y
        self.velocity = dx / TICK, dy / TICK
        if not command.holds:
            self._count_distance(dx, dy, command)
        if not walk.plays and walk.contacts.has_news:
            perception.learn(walk.contacts.take_felt())
        if perception.mapper is not None:
            perception.perceive(sensing, walk, plant.body, self.command, self.tick_count)
        perception.keep_up(plant, walk)
        self.tick_count += 1

    def _newest_command(self) -> Command:
        command, lapses = self._mailbox
        if lapses is not None and self.tick_count >= lapses:
            command = HOLD
        if command is not self.command and command != self.command:
            if self.on_input is not None:
                self.on_input(self.tick_count, command)
            self.command = command
        return command

    def _count_distance(self, dx: float, dy: float, command: Command) -> None:
        """Planar path of the centre along the commanded direction; turning alone is no way."""
        if dx == 0.0 and dy == 0.0:
            return
        if self.world.scenario.trace is not None:  # the commanded direction is the trace's own
            self.distance += math.hypot(dx, dy)
            return
        heading = self.plant.body[5] + command.crab_angle
        if heading != self._course[0]:
            self._course = heading, direction(heading)
        c, s = self._course[1]
        self.distance += dx * c + dy * s

    # -- requests

    def serve_requests(self) -> None:
        """Serve what was requested until now; ``step`` does it first, a paused clock does it alone.

        A request that cannot be served is dropped whole and ``refused`` says why: an edit, when
        another world came first. What comes meanwhile waits, so that a step always ends.
        """
        for _ in range(len(self._inbox)):
            request = self._inbox.popleft()
            tick = self.tick_count
            try:
                served = self._serve(request)
            except ValueError as refusal:
                served, self.refused = False, str(refusal)
            if served and self.on_input is not None:
                self.on_input(tick, request)

    def _serve(self, request: Request) -> bool:
        """Do what is requested; False when there was nothing to do. Raises ``ValueError``."""
        match request:
            case Reset():
                self._set_up(self.world, self.perception.revision + 1)
            case Load(world):
                self._set_up(world, self.perception.revision + 1)
            case Edit():
                self.perception.edit(request)
                self.plant.replace_ground(self.perception.ground)
            case Push(fx, fy, ticks):
                self.plant.push(fx, fy, ticks)
            case TakePosture(posture):
                self._take_posture(posture)
            case Follow(attitude):
                self._take_attitude(attitude)
            case Halt():
                if not self.walk.posing:
                    return False
                self.walk.halt()
        return True

    def _take_attitude(self, attitude: str) -> None:
        if checked_attitude(attitude) != "level" and not self.planner.capabilities.may_lean:
            raise PlannerError(registry.only_leans_with())
        self.planner.take_attitude(attitude)

    def _take_posture(self, posture: str) -> None:
        """Refused with a reason, or taken from the next standstill on; the command it walks by ends
        here.
        """
        why = self.reason if self.plant.state != "standing" else self.walk.pose(posture)
        if why:
            raise ValueError(why)
        if not self._mailbox[0].holds:
            self._mailbox = (HOLD, None)

    # -- what anybody may see

    @property
    def mode(self) -> Mode:
        """What the walker is doing; that it tips or has fallen comes first."""
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
        return blocked.text if blocked.leg is None else f"leg {blocked.leg + 1}: {blocked.text}"

    def margins(self, carrying: Iterable[bool]) -> Margins:
        """How far the machine is from tipping on the feet meant to carry."""
        plant = self.plant
        on = [foot for foot, carries in zip(plant.feet, carrying, strict=True) if carries]
        return margins_of(
            self.world.machine, plant.body, plant.feet, on, self.walk.heading, self.velocity
        )

    def preview(self, running: StepPlan | None) -> GaitPreview | None:
        """What the planner foresees from the last N_k on; None for one that does not."""
        return self.planner.preview(self.walk.kept_stance, running)

    def snapshot(self, *, paused: bool = False, rate: float = 1.0, late: float = 0.0) -> Snapshot:
        """The world at this instant, frozen; ``paused``, ``rate`` (times real time) and ``late``
        (s) are for a clock to say.
        """
        return take_snapshot(self, paused=paused, rate=rate, late=late)


def _plant_in(world: World) -> Plant[Ground]:
    """The machine on its ground, in the posture it begins in."""
    scenario = world.scenario
    wanted = scenario.noise
    noise = None
    if wanted is not None:
        noise = SensorNoise(wanted.position, wanted.posture, delay=wanted.late)
    rng = np.random.default_rng(scenario.seed)
    make = plant_entry(scenario.plant).make
    physics = None if scenario.physics is None else scenario.physics.settings()
    return make(world.machine, world.ground, world.stance, noise=noise, rng=rng, physics=physics)
