"""Where Levels B and C meet: walks over ground the map does not show, in one table a kind.

Run: python -m tests.sweeps.seams KIND --seeds 20. The results are kept in docs/touch.md.
"""

from __future__ import annotations

import argparse
import math
import random
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product

from walking_console.planner.geometry.transforms import left_fold_sum
from walking_console.planner.types import TICK, Mode
from walking_console.sim.runs.runner import TimelinePlayer
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

PLACE = 0.02  # m; encounters of one body place are those it has had since it got on by more
STUCK = 0.10  # m; a body that got on by less since is still where it was


@dataclass
class Told:
    """One walk: how it ended and what happened on the way."""

    ending: tuple[str, str] = ("", "")
    distance: float = 0.0  # m
    seconds: float = 0.0
    margin: float = math.inf  # m, least, of the feet meant to carry
    falls: int = 0
    forbidden: int = 0
    encounters: dict[str, int] = field(default_factory=dict)
    at_one_place: int = 0  # encounters at one place of the body, at most
    still: float = (
        0.0  # s the body took to get on by ``STUCK``, at most, from the first encounter on
    )
    slide: float = 0.0  # m a standing foot moved between coming down and rising, at most
    halts: int = 0
    predictions: int = 0

    @property
    def line(self) -> str:
        """The walk in one line."""
        return (
            f"{self.ending[0]} ({self.ending[1]}) {self.distance:.2f} m in {self.seconds:.0f} s, "
            f"margin {1000 * self.margin:.1f} mm, falls {self.falls}, forbidden {self.forbidden}, "
            f"encounters {self.encounters}, at one place {self.at_one_place}, "
            f"still {self.still:.0f} s, "
            f"slide {1000 * self.slide:.1f} mm, halts {self.halts}, "
            f"predictions {self.predictions}"
        )


class Watch:
    """Looks at a simulation after every tick."""

    def __init__(self, simulation: Simulation) -> None:
        self.told = Told()
        self._simulation = simulation
        self._stood = [False] * len(simulation.plant.feet)
        self._feet = [tuple(foot) for foot in simulation.plant.feet]
        self._slides = [0.0] * len(self._feet)
        self._prediction: object = None
        self._stands = True
        self._place = (0.0, 0.0, 0)  # x, y of the body, and encounters until then
        self._stuck = (0.0, 0.0, 0)  # x, y of the body, and the tick it was there first

    def look(self) -> None:
        """One tick."""
        self._look_at_feet()
        told = self.told
        walk = getattr(self._simulation.planner, "walk", None)
        prediction = getattr(walk, "prediction", None)
        told.predictions += prediction is not self._prediction
        self._prediction = prediction
        stands = self._simulation.mode in (Mode.STAND, Mode.SETTLE)
        told.halts += stands and not self._stands and self._simulation.walk.blocked is None
        self._stands = stands
        x, y = self._simulation.plant.body[:2]
        count = int(left_fold_sum(self._simulation.walk.contacts.counts.values()))
        if math.hypot(x - self._place[0], y - self._place[1]) > PLACE:
            self._place = (x, y, count)
        told.at_one_place = max(told.at_one_place, count - self._place[2])
        tick = self._simulation.tick_count
        if not count or math.hypot(x - self._stuck[0], y - self._stuck[1]) > STUCK:
            self._stuck = (x, y, tick)
        told.still = max(told.still, (tick - self._stuck[2]) * TICK)

    def _look_at_feet(self) -> None:
        plant = self._simulation.plant
        carrying = self._simulation.walk.carrying()
        for leg, foot in enumerate(plant.feet):
            stands = carrying[leg] and plant.soles[leg]
            moved = math.dist(foot[:2], self._feet[leg][:2])
            self._slides[leg] = self._slides[leg] + moved if stands and self._stood[leg] else 0.0
            self.told.slide = max(self.told.slide, self._slides[leg])
            self._stood[leg] = stands
            self._feet[leg] = tuple(foot)


def walk(name: str, *settings: str) -> Told:
    """Walk a scenario with ``--set`` settings to its end."""
    simulation = Simulation(load_scenario(name, ["expect={}", *settings]))
    player = TimelinePlayer(simulation)
    watch = Watch(simulation)
    while player.ending is None:
        player.give()
        simulation.step()
        player.note()
        watch.look()
    told = watch.told
    told.ending = player.ending
    told.distance = simulation.distance
    told.seconds = player.ticks * TICK
    told.margin = player.recorder.margin_min
    told.falls = player.recorder.falls
    told.forbidden = player.recorder.forbidden_steps
    told.encounters = dict(sorted(simulation.walk.contacts.counts.items()))
    return told


Walks = Iterator[tuple[str, tuple[str, ...]]]  # scenario, settings


def predictions(seeds: range) -> Walks:
    """K requirement 3 on ``k-curve``: predictions are kept, nothing halts it."""
    for fraction in (0.10, 0.04):
        for seed in seeds:
            yield "k-curve", (f"terrain.fraction={fraction}", f"seed={seed}")


def fields(seeds: range) -> Walks:
    """``k-curve`` by eye and by touch, unknown ground taken for flat."""
    for sensing, fraction in product(("eye", "none"), (0.30, 0.10, 0.06, 0.04)):
        for seed in seeds:
            yield (
                "k-curve",
                (
                    f"sensing={sensing}",
                    f"terrain.fraction={fraction}",
                    "end={distance=8.0, time=900.0}",
                    f"seed={seed}",
                ),
            )


def walls(seeds: range) -> Walks:
    """A block, 0.2 to 1.0 m tall, met at every 15 degrees; the seed is where it stands. Nearer, one
    that stands aslant would stand under the machine at the start.
    """
    for sensing in ("none", "eye"):
        for mode in ("predictive", "paper"):
            for height in (0.2, 0.4, 0.6, 1.0):
                for angle in range(0, 90, 15):
                    for seed in seeds:
                        yield (
                            "block",
                            (
                                f"sensing={sensing}",
                                f"mode={mode}",
                                f"terrain.height={height}",
                                f"terrain.angle_deg={angle}",
                                f"terrain.at={2.4 + 0.05 * seed}",
                                "drive=[{t=0.0, speed=0.08}]",
                                "end={time=240.0, distance=6.0}",
                            ),
                        )


def stairs(seeds: range) -> Walks:
    """H fig. 15, 17 and 19 by touch alone, as TITAN III had them, with risers of 0.10 to 0.20 m."""
    for name in ("fig15", "fig17-up", "fig17-down"):
        for rise in (0.10, 0.15, 0.20):
            for seed in seeds:
                for mode in ("paper", "predictive"):
                    yield (
                        name,
                        (
                            "sensing=none",
                            f"mode={mode}",
                            f"terrain.rise={rise}",
                            f"seed={seed}",
                        ),
                    )


def treads(seeds: range) -> Walks:
    """The same in the paper's mode, the first edge at nine places 2.5 cm apart."""
    for name in ("fig15", "fig17-up", "fig17-down"):
        for place in range(9):
            at = f"terrain.at={1.2 + 0.025 * place}"
            yield name, ("sensing=none", "mode=paper", at, "seed=1")


def banks(seeds: range) -> Walks:
    """H fig. 13 with its river at 41 places 2.5 cm apart, at its own crab angle and straight
    ahead.
    """
    for mode in ("paper", "predictive"):
        for degrees in (0, 16):
            drive = f"drive=[{{t=0.0, crab_angle_deg={degrees}, speed=0.08}}]"
            for place in range(41):
                yield (
                    "fig13",
                    (f"mode={mode}", drive, f"terrain.at={1.2 + 0.025 * place}", "seed=1"),
                )


def rivers(seeds: range) -> Walks:
    """Rivers of 0.30 to 0.60 m before the hexapod, 1 cm apart."""
    for width in range(30, 61):
        yield (
            "river",
            (
                "robot=hexapod",
                "planner=trace",
                "end={time=120.0, distance=4.0}",
                f"terrain.width={width / 100}",
                "seed=1",
            ),
        )


def noise(seeds: range) -> Walks:
    """Sensors that scatter by 5 mm and 0.5 degrees, on four and six legs, flat and rough."""
    for name in ("flat", "rough"):
        for robot in (("robot=titan3",), ("robot=hexapod", "planner=trace")):
            for seed in seeds:
                scatter = "noise={position=0.005, posture_deg=0.5}"
                yield name, (*robot, scatter, "end={time=60.0}", f"seed={seed}")


def poles(seeds: range) -> Walks:
    """Twelve poles on the map, before six legs."""
    for seed in seeds:
        yield (
            "poles",
            ("robot=hexapod", "planner=trace", "end={time=120.0, distance=5.0}", f"seed={seed}"),
        )


def giving(seeds: range) -> Walks:
    """Level ground with twelve loose patches in 5 m, on both plants, before four and six legs."""
    for plant in ("kinematic", "physics"):
        for robot in (("robot=titan3",), ("robot=hexapod", "planner=trace")):
            for seed in seeds:
                terrain = f'terrain={{kind="flat", cell=0.025, gives_way=[{_loose(seed)}]}}'
                drive = "drive=[{t=0.0, speed=0.08}]"
                end = "end={time=130.0, distance=6.0}"
                yield "flat", (f"plant={plant}", *robot, drive, end, terrain)


def _loose(seed: int) -> str:
    """Patches as a list in TOML: where they lie, what they bear and how far they go down."""
    chance = random.Random(seed)
    patches = []
    for _ in range(12):
        x = chance.uniform(1.2, 6.0)
        y = chance.uniform(-1.0, 0.7)
        side = chance.uniform(0.15, 0.5)
        sinks = chance.uniform(0.03, 0.2)
        bears = chance.choice((0, 150, 230, 300))  # N
        place = f"x=[{x:.3f}, {x + side:.3f}], y=[{y:.3f}, {y + side:.3f}]"
        patches.append(f"{{{place}, sinks={sinks:.3f}, bears={bears}}}")
    return ", ".join(patches)


# settings that differ from walk to walk of one row
VARIED = ("seed=", "terrain.at=", "terrain.angle_deg=", "terrain={")
KINDS: dict[str, Callable[[range], Walks]] = {
    "predictions": predictions,
    "fields": fields,
    "walls": walls,
    "stairs": stairs,
    "treads": treads,
    "banks": banks,
    "rivers": rivers,
    "noise": noise,
    "poles": poles,
    "giving": giving,
}


def main() -> None:
    """Walk a kind and print every walk, then a row for each of its settings without the seed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=tuple(KINDS))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", action="append", default=[], help="text of walks to walk, all")
    parser.add_argument("--set", action="append", default=[], help="KEY=VALUE for every walk")
    options = parser.parse_args()
    rows: dict[str, list[Told]] = {}
    for name, settings in KINDS[options.kind](range(options.first, options.first + options.seeds)):
        if not all(text in (name, *settings) for text in options.only):
            continue
        settings = (*settings, *options.set)
        told = walk(name, *settings)
        print(name, *settings, told.line, flush=True)
        kept = (each for each in settings if not each.startswith(VARIED))
        rows.setdefault(" ".join((name, *kept)), []).append(told)
    for title, walks in rows.items():
        print("|", title, "|", summary(walks), "|")


def _ended(told: Told) -> str:
    """How a walk ended: the first clause of its reason, without its numbers."""
    result, why = told.ending
    why = re.sub(r"^leg \d+: ", "", why).split(":")[0]
    return f"{result} ({re.sub(r'[0-9.]+', 'n', why)})"


def summary(walks: list[Told]) -> str:
    """One row of a table."""
    n = len(walks)
    ends = Counter(_ended(told) for told in walks)
    return " | ".join(
        (
            ", ".join(f"{count} {end}" for end, count in ends.most_common()),
            f"{sum(told.falls for told in walks)}",
            f"{1000 * min(told.margin for told in walks):.0f}",
            f"{max(told.at_one_place for told in walks)}",
            f"{max(told.still for told in walks):.0f}",
            f"{1000 * max(told.slide for told in walks):.1f}",
            f"{left_fold_sum(told.halts for told in walks) / n:.1f}",
            f"{left_fold_sum(told.predictions for told in walks) / n:.1f}",
            f"{sum(told.forbidden for told in walks)}",
        )
    )


if __name__ == "__main__":
    main()
