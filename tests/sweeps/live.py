"""Every shipped walk on the physics plant, Level C closing the loop: on machines that are other
than their file says, with sensors that scatter, and pushed.

Run: python -m tests.sweeps.live matrix [--rows ROW ...] [--walks SCENARIO ...] [--body sway]
     python -m tests.sweeps.live pushes [--walks SCENARIO ...] [--newtons N ...] [--directions K]
     python -m tests.sweeps.live hands|circles|grounds [--count N] [--from SEED]
     python -m tests.sweeps.live postures [--robots ROBOT ...] [--count N] [--from SEED]

``matrix`` prints a line for each walk and row: how it ended, the most the body leant against its
plan, how far off its odometry is at the end as a share of the way, and what its feet met that was
not in its map; then a summary of each row. ``pushes`` pushes the torso for 0.1 s and prints a line
for each force. ``hands`` leaves the stick to a restless hand for a while and then asks for one
steady course; ``circles`` goes once round on the spot and on circles of 1 m; ``grounds`` walks the
16 kinds of ground of docs/predictive.md; ``postures`` takes the standard posture from random ones,
on level and on rough ground. A SCENARIO is a name, or name:key=value;key=value. Needs MuJoCo.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tests.sweeps import foresight
from tests.sweeps.hands import (
    CIRCLE_SPEED,
    FORBIDDEN,
    HOMEWARD,
    PATIENCE,
    SPOT_RATE,
    hand,
    homeward,
)
from tests.sweeps.postures import MACHINES, gait_of, random_stance
from walking_console.planner.geometry.transforms import attitude_of, turned_back
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import TICK, Command
from walking_console.sim.requests import Push, TakePosture
from walking_console.sim.runs.runner import TimelinePlayer, long_lived_objects_kept
from walking_console.sim.scenario_files import load_scenario, scenario_names
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

PHYSICS = "plant=physics"
NOISE = "noise={position=0.005,posture_deg=0.5,delay=0.02}"
# name of a row: what is set for it
ROWS: dict[str, tuple[str, ...]] = {
    "sag 5": (PHYSICS, "physics={sag=0.005}"),
    "sag 2": (PHYSICS, "physics={sag=0.002}"),
    "sag 0.5": (PHYSICS, "physics={sag=0.0005}"),
    "light": (PHYSICS, "physics={mass_error=-0.1}"),
    "heavy": (PHYSICS, "physics={mass_error=0.2}"),
    "cog +x": (PHYSICS, "physics={cog_offset=[0.02,0.0,0.0]}"),
    "cog -x": (PHYSICS, "physics={cog_offset=[-0.02,0.0,0.0]}"),
    "cog +y": (PHYSICS, "physics={cog_offset=[0.0,0.02,0.0]}"),
    "cog -y": (PHYSICS, "physics={cog_offset=[0.0,-0.02,0.0]}"),
    "mu 0.5": (PHYSICS, "physics={friction=0.5}"),
    "mu 0.8": (PHYSICS, "physics={friction=0.8}"),
    "worst heavy": (
        PHYSICS,
        "physics={sag=0.005,mass_error=0.2,cog_offset=[0.02,0.02,0.0],friction=0.5}",
    ),
    "worst light": (
        PHYSICS,
        "physics={sag=0.0005,mass_error=-0.1,cog_offset=[-0.02,-0.02,0.0],friction=0.5}",
    ),
    "noise physics": (PHYSICS, NOISE),
    "noise kinematic": (NOISE,),
}
GROUNDS = {
    "level": 'terrain={kind="flat"}',
    "30 % holes": f'terrain={{kind="holes", fraction={FORBIDDEN}, cell=0.05}}',
}
END_MAX = 0.02  # of the way
PUSH_TICKS = 5
STARTED = 6.0  # s of walking before the first push
AFTER = 8.0  # s of walking after it
HANDS_COUNT = 40
GROUNDS_COUNT = 5
POSTURES_COUNT = 1000
POSTURE_GROUNDS = ("level", "rough")
ROUGHNESS = 0.1 / 0.85  # m up and down at most, for each m of standing height
POSED = 90.0  # s in which a posture is to be taken
SEED = 52_000
HOME_MIN = 0.3  # m that a steady course gets on at least
HELD = 40.0  # s a hand has the stick
CIRCLE_RADII = (0.0, 1.0)  # m; 0 is on the spot
CIRCLE_EVERY = 30  # degrees of crab angle
HEAD = (
    f"{'row':<16} {'walk':<18} {'result':<10} {'s':>6} {'m':>6} {'tilt °':>6} {'end %':>6} "
    "enc reason"
)


@dataclass
class Walked:
    """How a walk went: ``tilt`` the most its body leant against its plan, deg, ``way`` what it
    truly walked, m, ``off`` how far its odometry is from where it is, m.
    """

    tilt: float = 0.0
    way: float = 0.0
    off: float = 0.0
    result: str = ""
    reason: str = ""
    seconds: float = 0.0
    distance: float = 0.0
    met: int = 0
    falls: list[str] = field(default_factory=list)

    @property
    def end(self) -> float:
        """How far off its odometry is, as a share of the way; of at least a metre."""
        return self.off / max(self.way, 1.0)

    @property
    def good(self) -> bool:
        """It ended as its scenario has it end, and knows where it is."""
        return self.result == "completed" and self.end <= END_MAX


def scenario_of(entry: str, more: tuple[str, ...]) -> Simulation:
    """The simulation of ``name`` or ``name:key=value;key=value``, with ``more`` set."""
    name, _, settings = entry.partition(":")
    return Simulation(load_scenario(name, [*more, *(settings.split(";") if settings else [])]))


def tilt_against_plan(simulation: Simulation) -> float:
    """How far the body leans beside what its plan has, rad."""
    run = simulation.walk.run
    _, _, _, roll, pitch, yaw = simulation.plant.body
    if run.tracker.leans:
        wanted = attitude_of(run.tracker.lean_at(run.t), yaw)
        roll -= wanted[0]
        pitch -= wanted[1]
    return math.hypot(roll, pitch)


def walked(entry: str, more: tuple[str, ...]) -> Walked:
    """Walk a scenario to its end."""
    simulation = scenario_of(entry, more)
    player = TimelinePlayer(simulation)
    got = Walked()
    with long_lived_objects_kept():
        while player.ending is None:
            x, y, *_ = simulation.plant.body
            player.give()
            simulation.step()
            player.note()
            body = simulation.plant.body
            got.way += math.hypot(body[0] - x, body[1] - y)
            got.tilt = max(got.tilt, math.degrees(tilt_against_plan(simulation)))
    sensed = simulation.perception.readings[-1].body
    got.off = math.hypot(sensed[0] - body[0], sensed[1] - body[1])
    got.result, got.reason = player.ending
    got.seconds = player.ticks * TICK
    got.distance = simulation.distance
    got.met = sum(simulation.walk.contacts.counts.values())
    return got


def line(row: str, entry: str, got: Walked) -> str:
    """One line of the matrix."""
    return (
        f"{row:<16} {entry:<18} {got.result:<10} {got.seconds:6.1f} {got.distance:6.2f} "
        f"{got.tilt:6.2f} {100 * got.end:6.2f} {got.met:3d} {got.reason}"
    )


def matrix(rows: list[str], walks: list[str], body: str) -> None:
    """Walk every walk in every row."""
    summary = []
    print(HEAD)
    for row in rows:
        came = {}
        for entry in walks:
            came[entry] = walked(entry, (f"gait.body={body}", *ROWS[row]))
            print(line(row, entry, came[entry]), flush=True)
        falls = [entry for entry, got in came.items() if got.result == "fell"]
        rest = [entry for entry, got in came.items() if not got.good and entry not in falls]
        worst = max(came, key=lambda entry: came[entry].tilt)
        summary.append(
            f"{row:<16} walks {len(came)}, fell {len(falls)} {falls}, not completed or off {rest}, "
            f"tilt at most {came[worst].tilt:.2f}° ({worst}), "
            f"end at most {100 * max(got.end for got in came.values()):.2f} %, "
            f"encounters {sum(got.met for got in came.values())}"
        )
    print("\n".join(summary))


def pushed(entry: str, more: tuple[str, ...], newtons: float, way: float, phase: float) -> Walked:
    """Walk, and push the torso by so many newtons towards ``way`` (rad) at ``phase``, s."""
    simulation = scenario_of(entry, more)
    player = TimelinePlayer(simulation)
    at = round((STARTED + phase) / TICK)
    got = Walked()
    for tick in range(at + round(AFTER / TICK)):
        if player.ending is not None:
            break
        if tick == at:
            fx = newtons * math.cos(way)
            fy = newtons * math.sin(way)
            simulation.request(Push(fx, fy, PUSH_TICKS))
        player.give()
        simulation.step()
        player.note()
        if tick >= at:
            got.tilt = max(got.tilt, math.degrees(tilt_against_plan(simulation)))
    got.met = sum(simulation.walk.contacts.counts.values())
    got.result = "walks" if player.ending is None else player.ending[0]
    got.reason = simulation.reason
    if got.result == "walks" and not simulation.walk.steps:
        got.result = "stands"
    return got


def phases(count: int, period: float) -> Iterator[float]:
    """So many instants of a period, s."""
    return (k * period / count for k in range(count))


def pushes(given: argparse.Namespace) -> None:
    """Push every walk in every direction at every phase."""
    print(f"{'walk':<44} {'N':>5} pushes outcomes; tilt at most, encounters")
    more = (f"gait.body={given.body}", PHYSICS, "end={time=60}", f"physics={{sag={given.sag}}}")
    for entry in given.walks:
        for newtons in given.newtons:
            came = {}
            for k in range(given.directions):
                way = math.tau * k / given.directions
                for phase in phases(given.phases, given.period):
                    came[k, phase] = pushed(entry, more, newtons, way, phase)
            counts = Counter(got.result for got in came.values())
            worst = max(got.tilt for got in came.values())
            met = sum(got.met for got in came.values())
            print(f"{entry:<44} {newtons:5.0f} {len(came)} {dict(counts)}; {worst:.2f}°, {met}")
            for (k, phase), got in came.items():
                if got.result != "walks":
                    degrees = 360 * k / given.directions
                    print(f"    {degrees:.1f}° at {phase:.2f} s: {got.result} {got.reason}")


def on_ground(ground: str, seed: int, body: str) -> Simulation:
    """A machine on wide ground, for a hand to drive."""
    wide = ("drive=[{t=0.0, speed=0.1, turn_rate_deg_s=0.1}]", "end={time=1000.0, distance=6.0}")
    more = (PHYSICS, GROUNDS[ground], f"seed={seed}", f"gait.body={body}", "expect={}", *wide)
    return scenario_of("flat", more)


def stepped(simulation: Simulation, got: Walked) -> bool:
    """One tick, and what it came to; False when it fell."""
    simulation.step()
    got.tilt = max(got.tilt, math.degrees(tilt_against_plan(simulation)))
    got.met = sum(simulation.walk.contacts.counts.values())
    got.reason = simulation.reason
    if simulation.plant.state == "fallen":
        got.result = "fell"
        return False
    return True


def handed(seed: int, ground: str, body: str) -> Walked:
    """One restless hand on the stick, then one steady course for ``HOMEWARD`` seconds."""
    simulation = on_ground(ground, seed, body)
    positions = hand(np.random.default_rng([seed, 1]))
    changes = 0
    got = Walked()
    for tick in range(round((HELD + HOMEWARD) / TICK)):
        if tick == round(HELD / TICK):
            x, y, *_, yaw = simulation.plant.body
            home = math.remainder(math.atan2(-y, -x) - yaw, 2 * math.pi)
            simulation.order(Command(home, 0.08))
        elif tick == changes and tick < round(HELD / TICK):
            stays, command = next(positions)
            changes += max(1, round(stays / TICK))
            simulation.order(homeward(simulation, command))
        if not stepped(simulation, got):
            return got
    got.distance = math.dist(simulation.plant.body[:2], (x, y))
    got.result = "walks" if got.distance > HOME_MIN else "stuck"
    return got


def hands(given: argparse.Namespace) -> None:
    """So many hands on each ground."""
    for ground in GROUNDS:
        came = {
            f"seed {given.seed + k}": handed(given.seed + k, ground, given.body)
            for k in range(given.count or HANDS_COUNT)
        }
        _tell(f"hands, {ground}", came)


def circled(radius: float, degrees: int, sense: int, simulation: Simulation) -> Walked:
    """Once round at one crab angle, on the spot where the radius is 0."""
    speed, rate = (CIRCLE_SPEED, CIRCLE_SPEED / radius) if radius else (0.0, SPOT_RATE)
    simulation.order(Command(math.radians(degrees), speed, sense * rate))
    got = Walked()
    turned = 0.0
    yaw = simulation.plant.body[5]
    for _ in range(round(PATIENCE * math.tau / rate / TICK)):
        if not stepped(simulation, got):
            return got
        now = simulation.plant.body[5]
        turned += math.remainder(now - yaw, math.tau)
        yaw = now
        if abs(turned) >= math.tau:
            got.result = "round"
            return got
    got.result = "not round"
    return got


def circles(given: argparse.Namespace) -> None:
    """Circles and turns on the spot, left and right, on each ground."""
    for ground in GROUNDS:
        came = {}
        for radius in CIRCLE_RADII:
            for degrees in range(-180, 180, CIRCLE_EVERY) if radius else (0,):
                for sense in (1, -1):
                    name = f"{radius:g} m {degrees}° {'left' if sense > 0 else 'right'}"
                    seed = given.seed + degrees % 360
                    simulation = on_ground(ground, seed, given.body)
                    came[name] = circled(radius, degrees, sense, simulation)
        _tell(f"circles, {ground}", came)


def grounds(given: argparse.Namespace) -> None:
    """Walks of 4 m over every kind of ground of docs/predictive.md."""
    first = foresight.FIRST_SEED
    for kind in foresight.GROUNDS:
        came = {}
        for seed in range(first, first + (given.count or GROUNDS_COUNT)):
            ground = foresight.settings_for(kind, "predictive", seed)
            more = (PHYSICS, f"gait.body={given.body}", *ground)
            came[f"seed {seed}"] = walked("flat", more)
        _tell(kind, came)


def posed(name: str, ground: str, rng: np.random.Generator, body: str) -> Walked:
    """From random feet to the standard posture."""
    machine = load_machine(name)
    relief = ROUGHNESS * machine.height
    rough = f'terrain={{kind="rough", amplitude={relief:.4f}, length={max(0.2, 3 * relief):.3f}}}'
    more = [
        PHYSICS,
        f"robot={name}",
        f"planner={MACHINES[name]}",
        f"gait.body={body}",
        "expect={}",
        rough if ground == "rough" else GROUNDS["level"],
        f"seed={rng.integers(1_000_000)}",
    ]
    world = prepare(load_scenario("flat", more))
    stance = random_stance(machine, gait_of(machine), world.belief, rng)
    yaw = stance.body[3]
    feet = [list(turned_back(x, y, yaw)) for x, y, _ in stance.feet]
    start = f"start={{feet={feet}, yaw_deg={math.degrees(yaw)}}}"
    simulation = Simulation(load_scenario("flat", [*more, start]))
    simulation.run(0.5)
    simulation.request(TakePosture("standard"))
    got = Walked()
    for _ in range(round(POSED / TICK)):
        if not stepped(simulation, got):
            return got
        if simulation.refused or (simulation.walk.stands and not simulation.walk.posing):
            break
    taken = simulation.walk.stands and simulation.walk.posture == "standard"
    got.reason = simulation.refused or got.reason
    got.result = "taken" if taken and not simulation.refused else "not taken"
    return got


def postures(given: argparse.Namespace) -> None:
    """So many postures of each robot on each ground."""
    count = given.count or POSTURES_COUNT
    for name in given.robots:
        for ground in POSTURE_GROUNDS:
            rng = np.random.default_rng(given.seed)
            came = {str(k): posed(name, ground, rng, given.body) for k in range(count)}
            _tell(f"postures, {name}, {ground}", came)


def _tell(what: str, came: dict[str, Walked]) -> None:
    counts = Counter(got.result for got in came.values())
    tilts = sorted(got.tilt for got in came.values())
    met = sum(got.met for got in came.values())
    print(
        f"{what}: {len(came)} {dict(counts)}; tilt at most {tilts[-1]:.2f}°, in 95 of 100 "
        f"{tilts[int(0.95 * (len(tilts) - 1))]:.2f}°, encounters {met}",
        flush=True,
    )
    for name, got in came.items():
        if got.result not in ("completed", "walks", "round", "taken"):
            print(f"    {name}: {got.result} {got.reason}", flush=True)


SWEEPS = {
    "pushes": pushes,
    "hands": hands,
    "circles": circles,
    "grounds": grounds,
    "postures": postures,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("what", choices=["matrix", *SWEEPS])
    parser.add_argument("--rows", nargs="+", default=list(ROWS), choices=list(ROWS))
    parser.add_argument("--walks", nargs="+", default=None, metavar="SCENARIO")
    parser.add_argument("--body", default="sway", choices=["sway", "straight"])
    parser.add_argument("--newtons", type=float, nargs="+", default=[150.0, 300.0])
    parser.add_argument("--directions", type=int, default=16)
    parser.add_argument("--phases", type=int, default=12)
    parser.add_argument("--period", type=float, default=10.0, help="s the phases are spread over")
    parser.add_argument("--sag", type=float, default=0.005, help="m a leg gives, of pushes")
    parser.add_argument(
        "--count", type=int, default=None, help="hands, postures, seeds of a ground"
    )
    parser.add_argument("--robots", nargs="+", default=["titan3"], choices=list(MACHINES))
    parser.add_argument("--from", type=int, default=SEED, dest="seed")
    given = parser.parse_args()
    if given.what == "matrix":
        matrix(given.rows, given.walks or list(scenario_names()), given.body)
        return
    given.walks = given.walks or ["flat"]
    SWEEPS[given.what](given)


if __name__ == "__main__":
    main()
