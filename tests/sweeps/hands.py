"""Random hands on the joystick, circles and turns on the spot, through the real console, every tick
looked at.

Run: python -m tests.sweeps.hands hands|circles [--ground flat|cells] [--count N] [--from SEED]
[--seconds S] [--out FILE]
     python -m tests.sweeps.hands answers
     python -m tests.sweeps.hands join FILE ...
One process. ``--out`` appends one line of JSON a walk and leaves out what is in the file already: a
sweep may be broken off and begun again, in pieces; ``join`` makes one table of them. The results
are kept in docs/predictive.md.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from walking_console.planner.stability import MARGIN_SLACK, polygon_margin, support_polygon
from walking_console.planner.types import TICK, Command
from walking_console.sim.margins import true_centre
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

FIRST_SEED = 52_000  # not used for tuning
FORBIDDEN = 0.3  # of the 5 cm cells, ground "cells"
GROUNDS = {
    "flat": 'terrain={kind="flat"}',
    "cells": f'terrain={{kind="holes", fraction={FORBIDDEN}, cell=0.05}}',
}
MAP = 12.0  # m the map reaches at least beyond the start, to every side
BOUND = 8.0  # m from the start, in x or y, beyond which the hand steers back

SPEED_MAX = 0.35  # m/s; no gait here is faster than 0.25
TURN_MAX = 0.3  # rad/s; twice the page's full turn
CHANGE = (0.2, 5.0)  # s between changes of a hand
HOMEWARD = 20.0  # s of one steady command after the last change: it must walk yet

MOVES = {
    "any": 0.2,
    "straight": 0.2,
    "spot": 0.1,
    "release": 0.1,
    "reverse": 0.1,
    "speed": 0.1,
    "turn": 0.1,
    "tremble": 0.1,
}
MOVED = 0.005  # m of body path, turning counted by ρ: the body has moved
STANDS = 8.0  # s; a body commanded to move that has not for so long is dead-locked
# m/s, turning counted by ρ; a command that asks for less does not say whether the body is stuck
CREEPS = 0.01
BLOCKED = 0.5  # s; a hand that stays gets no other answer: on such ground that is a dead-lock too
FEET_STAND = 1e-9  # m a standing foot may move in a tick

RADII = (1.0, 2.0, 5.0)  # m
EVERY = 15  # degrees of crab angle
CIRCLE_SPEED, SPOT_RATE = 0.08, math.radians(8.0)  # m/s, rad/s
STOPS = range(3, 330, 9)  # ticks into a straight walk at which it is stopped
RAMP = 10  # ticks in which a stick is pushed all the way
ANSWERED = 2e-4  # m of body path, turning counted by ρ: seen to move
COURSES = (
    *((angle, 0.08, 0.0) for angle in range(-180, 180, 45)),
    (0, 0.0, 0.1),
    (0, 0.0, -0.1),
    (17, 0.08, 0.08),
    (-115, 0.08, -0.08),
)
PATIENCE = 4.0  # times as long as the commanded pace would take


@dataclass
class Watch:
    """What was seen of one walk."""

    falls: int = 0
    forbidden_steps: int = 0
    feet_moved: float = 0.0  # m, the most a standing foot moved in one tick
    margin: float = math.inf  # m, least longitudinal
    polygon_margin: float = math.inf  # m, least, of the body's own place
    true_margin: float = math.inf  # m, least, of the true centre of gravity
    stood: float = 0.0  # s, longest commanded to move without moving
    stood_at: float = 0.0  # s, when that was over
    blocked: float = 0.0  # s, longest
    reason: str = ""  # of that
    steps: int = 0
    way: float = 0.0  # m of the CoG's path
    turned: float = 0.0  # rad, both ways
    yaw: float = 0.0  # rad, in the end
    seconds: float = 0.0
    emergent: dict[str, int] = field(default_factory=dict)

    @property
    def amiss(self) -> list[str]:
        """What must not be."""
        found = {
            "fell": self.falls > 0,
            "forbidden step": self.forbidden_steps > 0,
            "standing foot moved": self.feet_moved > FEET_STAND,
            "margin": min(self.margin, self.polygon_margin) < -MARGIN_SLACK - 1e-6,
            "dead-lock": self.stood > STANDS,
            "blocked": self.blocked > BLOCKED,
        }
        return [what for what, there in found.items() if there]


def planned_polygon_margin(console: Simulation) -> float:
    """How far the body's own place, which planners go by, is inside the feet meant to carry, m."""
    return console.margins(console.walk.carrying()).polygon


def true_polygon_margin(console: Simulation) -> float:
    """The same of the centre of gravity of torso and legs, m."""
    plant = console.plant
    feet = zip(plant.feet, console.walk.carrying(), strict=True)
    polygon = support_polygon([foot for foot, carries in feet if carries])
    x, y, _ = true_centre(console.world.machine, plant.body, plant.feet)
    return polygon_margin(polygon, x, y)


class Watched:
    """A console whose every tick is looked at."""

    def __init__(self, console: Simulation) -> None:
        self.console, self.seen = console, Watch()
        self._anchor = self._pose()
        self._standing = self._blocked = 0  # ticks
        self._feet = [tuple(foot) for foot in console.plant.feet]
        self._stood = (True,) * len(self._feet)

    def _pose(self) -> tuple[float, float, float]:
        body = self.console.plant.body
        return body[0], body[1], body[5]

    def _pace(self) -> float:
        command = self.console.command
        return math.hypot(command.speed, self.console.world.machine.yaw_length * command.turn_rate)

    def order(self, command: Command) -> None:
        self.console.order(command)

    def step(self) -> None:
        """One tick, and what it came to."""
        console, seen = self.console, self.seen
        x, y, yaw = self._pose()
        console.step()
        seen.seconds += TICK
        plant, walk = console.plant, console.walk
        seen.way += math.hypot(plant.body[0] - x, plant.body[1] - y)
        seen.turned += abs(plant.body[5] - yaw)
        seen.yaw = plant.body[5]
        seen.steps, seen.emergent = walk.steps_begun, dict(walk.contacts.counts)
        if plant.state != "standing":
            seen.falls = 1
        carrying = walk.carrying()
        margins = console.margins(carrying)
        seen.margin = min(seen.margin, margins.longitudinal)
        seen.polygon_margin = min(seen.polygon_margin, margins.polygon)
        seen.true_margin = min(seen.true_margin, true_polygon_margin(console))
        self._look_at_feet(carrying)
        self._look_at_body()

    def _look_at_feet(self, carrying: tuple[bool, ...]) -> None:
        console, seen, plant = self.console, self.seen, self.console.plant
        stand = tuple(sole and carries for sole, carries in zip(plant.soles, carrying, strict=True))
        feet = [tuple(foot) for foot in plant.feet]
        for foot, before, stands, stood in zip(feet, self._feet, stand, self._stood, strict=True):
            if stands and stood:
                seen.feet_moved = max(
                    seen.feet_moved, *(abs(a - b) for a, b in zip(foot, before, strict=True))
                )
            elif stands:
                cell = console.perception.ground.cell_at(foot[0], foot[1])
                seen.forbidden_steps += cell is None or bool(
                    console.perception.true_forbidden[cell]
                )
        self._feet, self._stood = feet, stand

    def _look_at_body(self) -> None:
        console, seen = self.console, self.seen
        x, y, yaw = self._pose()
        away = math.hypot(
            x - self._anchor[0],
            y - self._anchor[1],
            console.world.machine.yaw_length * (yaw - self._anchor[2]),
        )
        if away >= MOVED:
            self._anchor, self._standing = (x, y, yaw), 0
        # a release ends no dead-lock: time goes on counting when it is driven again
        elif self._pace() >= CREEPS:
            self._standing += 1
            if self._standing * TICK > seen.stood:
                seen.stood, seen.stood_at = self._standing * TICK, seen.seconds
        self._blocked = (
            self._blocked + 1
            if console.walk.blocked is not None and not console.command.holds
            else 0
        )
        if self._blocked * TICK > seen.blocked:
            seen.blocked, seen.reason = self._blocked * TICK, console.reason


def console_on(ground: str, seed: int, robot: str, duty_factor: float) -> Simulation:
    """The console on ground that reaches far enough, as the page has it but for the clock."""
    wide = "drive=[{t=0.0, speed=0.1, turn_rate_deg_s=0.1}]", f"end={{time=1000.0, distance={MAP}}}"
    given = (
        f"robot={robot}",
        f"gait.duty_factor={duty_factor}",
        GROUNDS[ground],
        f"seed={seed}",
        "expect={}",
    )
    return Simulation(prepare(load_scenario("flat", [*given, *wide])))


# hands


def hand(rng: np.random.Generator) -> Iterator[tuple[float, Command]]:
    """What a restless hand does to both axes: seconds it stays, and where the stick is then.
    Without end.
    """
    command = Command()
    while True:
        stays = float(rng.uniform(*CHANGE))
        command = _moved(rng, command)
        yield stays, command


def _moved(rng: np.random.Generator, now: Command) -> Command:
    """The next place of the stick: anywhere, or as hands do: let go, turn about, only faster or
    slower, a little to one side.
    """
    angle, speed, turn = (
        rng.uniform(-math.pi, math.pi),
        rng.uniform(0.0, SPEED_MAX),
        rng.uniform(-TURN_MAX, TURN_MAX),
    )
    kind = rng.choice(list(MOVES), p=list(MOVES.values()))
    if kind == "straight":
        turn = 0.0
    elif kind == "spot":
        speed = 0.0
    elif kind == "release":
        return Command()
    elif now.holds or kind == "any":
        pass
    elif kind == "reverse":
        angle, speed, turn = now.crab_angle + math.pi, now.speed, -now.turn_rate
    elif kind == "speed":
        angle, turn = now.crab_angle, now.turn_rate
        speed = speed if now.speed else 0.0
    elif kind == "turn":
        angle, speed = now.crab_angle, now.speed
    elif kind == "tremble":
        angle, speed, turn = (
            now.crab_angle + rng.normal(0.0, 0.1),
            now.speed * rng.uniform(0.8, 1.2),
            now.turn_rate * rng.uniform(0.8, 1.2),
        )
    return Command(float(math.remainder(angle, 2 * math.pi)), float(speed), float(turn))


def homeward(console: Simulation, command: Command) -> Command:
    """The hand looks where it drives: near the edge of the map it steers back to the middle."""
    x, y, *_, yaw = console.plant.body
    if command.speed == 0.0 or max(abs(x), abs(y)) <= BOUND:
        return command
    return Command(math.remainder(math.atan2(-y, -x) - yaw, 2 * math.pi), command.speed)


def hand_walk(
    seed: int, ground: str, seconds: float, robot: str = "titan3", duty_factor: float = 0.8
) -> tuple[Watch, float]:
    """One hand for so long, then one steady command: what was seen, and how far it got in the end,
    m.
    """
    watched = Watched(console_on(ground, seed, robot, duty_factor))
    console, positions, left = watched.console, hand(np.random.default_rng([seed, 1])), 0
    for _ in range(round(seconds / TICK)):
        if left == 0:
            stays, command = next(positions)
            left = round(stays / TICK)
            watched.order(homeward(console, command))
        left -= 1
        watched.step()
        if watched.seen.falls:
            return watched.seen, 0.0
    x, y = console.plant.body[:2]
    watched.order(
        Command(math.remainder(math.atan2(-y, -x) - console.plant.body[5], 2 * math.pi), 0.08)
    )
    for _ in range(round(HOMEWARD / TICK)):
        watched.step()
    return watched.seen, math.hypot(console.plant.body[0] - x, console.plant.body[1] - y)


# circles


def circle_walk(
    radius: float,
    degrees: float,
    sense: int,
    ground: str,
    seed: int,
    robot: str = "titan3",
    duty_factor: float = 0.8,
) -> Watch:
    """Once round at one crab angle (radius 0: on the spot) until the torso has turned by 360
    degrees.
    """
    watched = Watched(console_on(ground, seed, robot, duty_factor))
    speed, rate = (CIRCLE_SPEED, CIRCLE_SPEED / radius) if radius else (0.0, SPOT_RATE)
    start = watched.console.plant.body[5]
    watched.order(Command(math.radians(degrees), speed, sense * rate))
    for _ in range(round(PATIENCE * 2 * math.pi / rate / TICK)):
        watched.step()
        if watched.seen.falls or abs(watched.seen.yaw - start) >= 2 * math.pi:
            break
    return watched.seen


# answers


def answers(given: argparse.Namespace) -> None:
    """A walk stopped at every phase, all feet down, then the stick pushed some way: how long until
    the body moves.
    """
    print(
        "| ground | stick | pushes | within 0.1 s | within 0.5 s | within 1 s | most, s | feet"
        " first |"
    )
    print("|---" * 8 + "|")
    for ground in given.ground:
        for ramp, how in ((1, "at once"), (RAMP, f"within {RAMP * TICK:g} s")):
            times, waits = [], 0
            for stop in STOPS:
                for degrees, speed, turn in COURSES:
                    seconds, moves = answer(
                        ground, stop, Command(math.radians(degrees), speed, turn), ramp
                    )
                    times.append(seconds)
                    waits += not moves
            shares = [
                f"{sum(t <= limit + 1e-9 for t in times) / len(times):.1%}"
                for limit in (0.1, 0.5, 1.0)
            ]
            print(
                "| "
                + " | ".join(
                    [ground, how, str(len(times)), *shares, f"{max(times):.2f}", str(waits)]
                )
                + " |",
                flush=True,
            )


def answer(ground: str, stop: int, command: Command, ramp: int) -> tuple[float, bool]:
    """Seconds until the body moves, and whether it does so in its first step (else a foot has to be
    put elsewhere first).
    """
    console = console_on(ground, FIRST_SEED, "titan3", 0.8)
    console.order(Command(0.0, 0.08))
    for _ in range(stop):
        console.step()
    console.order(Command())
    for _ in range(50):
        console.step()
    x, y, *_, yaw = console.plant.body
    begun = console.walk.steps_begun
    for ticks in range(1, 500):
        share = min(1.0, ticks / ramp)
        console.order(Command(command.crab_angle, share * command.speed, share * command.turn_rate))
        console.step()
        body = console.plant.body
        if (
            math.hypot(body[0] - x, body[1] - y, console.world.machine.yaw_length * (body[5] - yaw))
            > ANSWERED
        ):
            break
    return ticks * TICK, console.walk.steps_begun == begun + 1


# pieces and tables


def hands(given: argparse.Namespace) -> None:
    for seed in range(given.first, given.first + given.count):
        for ground in given.ground:
            key = f"hand {given.robot} {given.beta} {ground} {given.seconds:g} s seed {seed}"
            if given.done(key):
                seen, last = hand_walk(seed, ground, given.seconds, given.robot, given.beta)
                given.keep(
                    key, seen, {"sweep": "hands", "ground": ground, "seed": seed, "last": last}
                )


def circles(given: argparse.Namespace) -> None:
    for ground in given.ground:
        for radius in given.radius:
            for degrees in range(-180, 180, EVERY) if radius else (0,):
                for sense in (1, -1):
                    key = (
                        f"circle {given.robot} {given.beta} {ground} {radius:g} m {degrees}°"
                        f" {'left' if sense > 0 else 'right'}"
                    )
                    if given.done(key):
                        seed = given.first + round(10 * radius) + degrees % 360 * 100 + (sense > 0)
                        seen = circle_walk(
                            radius, degrees, sense, ground, seed, given.robot, given.beta
                        )
                        told = {
                            "sweep": "circles",
                            "ground": ground,
                            "radius": radius,
                            "round": math.degrees(abs(seen.yaw)),
                        }
                        given.keep(key, seen, told)


class Kept:
    """The walks of a sweep so far: in a file when there is one, told one line each."""

    def __init__(self, out: Path | None) -> None:
        self.out = out
        self.rows = rows_of(out) if out is not None and out.exists() else []
        self.keys = {row["key"] for row in self.rows}

    def done(self, key: str) -> bool:
        """True when that walk is still to be made."""
        return key not in self.keys

    def keep(self, key: str, seen: Watch, told: dict[str, Any]) -> None:
        row = {"key": key, **told, **asdict(seen), "amiss": [*seen.amiss, *short_of(told)]}
        self.rows.append(row)
        self.keys.add(key)
        if self.out is not None:
            with self.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        print(
            f"{key}: {row['amiss'] or 'well'}; {seen.steps} steps, {seen.way:.1f} m,"
            f" {math.degrees(seen.turned):.0f}°, least margin {1e3 * seen.polygon_margin:.1f} mm"
            f" ({1e3 * seen.true_margin:.1f} of the true centre), stood {seen.stood:.1f} s"
            f" (till {seen.stood_at:.1f} s), blocked {seen.blocked:.1f} s"
            f" {seen.reason}",
            flush=True,
        )


def short_of(told: dict[str, Any]) -> list[str]:
    """A walk that did not come to where it was to."""
    if told["sweep"] == "hands":
        return [] if told["last"] > 0.5 else ["did not walk on in the end"]
    return [] if told["round"] >= 360.0 - 1e-6 else ["not round"]


def rows_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def table(rows: list[dict[str, Any]]) -> None:
    """One row of figures a ground, and a radius."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in {row["key"]: row for row in rows}.values():
        robot, beta = row["key"].split()[1:3]
        what = (
            "random hands"
            if row["sweep"] == "hands"
            else f"circle of {row['radius']:g} m"
            if row["radius"]
            else "on the spot"
        )
        groups.setdefault((robot, beta, row["ground"], what), []).append(row)
    print(
        "| robot, β | ground | what | walks | with nothing amiss | simulated, min | steps "
        "| falls | forbidden steps | least margin, mm: body, true centre |"
        " longest stand while driven, s: median, most | longest blocked, s |"
    )
    print("|---" * 12 + "|")
    for (robot, beta, ground, what), walks in groups.items():
        stood = sorted(walk["stood"] for walk in walks)
        figures = [
            f"{robot}, {beta}",
            ground,
            what,
            len(walks),
            sum(not walk["amiss"] for walk in walks),
            f"{sum(walk['seconds'] for walk in walks) / 60:.0f}",
            sum(walk["steps"] for walk in walks),
            sum(walk["falls"] for walk in walks),
            sum(walk["forbidden_steps"] for walk in walks),
            f"{1e3 * min(walk['polygon_margin'] for walk in walks):.1f}, "
            f"{1e3 * min(walk['true_margin'] for walk in walks):.1f}",
            f"{stood[len(stood) // 2]:.1f}, {stood[-1]:.1f}",
            f"{max(walk['blocked'] for walk in walks):.1f}",
        ]
        print("| " + " | ".join(map(str, figures)) + " |", flush=True)
    for row in rows:
        if row["amiss"]:
            print(f"{row['key']}: {', '.join(row['amiss'])}; {row['reason']}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sweep", choices=("hands", "circles", "answers", "join"))
    parser.add_argument("files", nargs="*", type=Path, help="for join")
    parser.add_argument("--ground", nargs="+", choices=GROUNDS, default=list(GROUNDS))
    parser.add_argument("--count", type=int, default=200, help="hands")
    parser.add_argument("--from", dest="first", type=int, default=FIRST_SEED, help="the first seed")
    parser.add_argument("--seconds", type=float, default=300.0, help="of each hand")
    parser.add_argument(
        "--radius",
        nargs="+",
        type=float,
        default=[0.0, *RADII],
        help="of the circles, m; 0 is on the spot",
    )
    parser.add_argument("--robot", default="titan3")
    parser.add_argument("--beta", type=float, default=0.8)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    if given.sweep == "join":
        table([row for path in given.files for row in rows_of(path)])
        return
    if given.sweep == "answers":
        answers(given)
        return
    kept = Kept(given.out)
    given.done, given.keep = kept.done, kept.keep
    {"hands": hands, "circles": circles}[given.sweep](given)
    table(kept.rows)


if __name__ == "__main__":
    main()
