"""Machines on grounds, for the tests of the kinematic plant."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from pydantic import TypeAdapter

from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.types import Point, Stance
from walking_console.sim.kinematic.plant import KinematicPlant
from walking_console.sim.terrain.generators import AnyTerrain
from walking_console.sim.terrain.ground import Ground, make_ground

TITAN = load_machine("titan3")


HEXAPOD = load_machine("hexapod")


STILL: list[Point] = [(0.0, 0.0, 0.0)] * 4


CELL = 0.05


def flat(machine: Machine = TITAN, level: float = 0.0) -> Ground:
    return Ground(np.full((200, 200), level), CELL, (-5.0, -5.0))


def shaped(height: Callable[[float, float], float]) -> Ground:
    centres = (np.arange(200) + 0.5) * CELL - 5.0
    return Ground(np.array([[height(x, y) for x in centres] for y in centres]), CELL, (-5.0, -5.0))


def made(kind: str, **parameters: object) -> Ground:
    terrain = TypeAdapter(AnyTerrain).validate_python({"kind": kind, **parameters})
    return make_ground(
        terrain, TITAN, (0.0, 0.0, 0.0), 1, 4.0, None, [leg.centre for leg in TITAN.legs]
    )


def standing(
    machine: Machine = TITAN,
    ground: Ground | None = None,
    x: float = 0.0,
    y: float = 0.0,
    up: dict[int, float] | None = None,
) -> KinematicPlant:
    """On the middles of its reach, body moved to (x, y); ``up`` are feet in the air with their
    height.
    """
    ground, up = ground or flat(), up or {}
    feet = []
    for leg, (fx, fy) in enumerate(leg.centre for leg in machine.legs):
        height = ground.height_at(fx, fy)
        feet.append((fx, fy, (0.0 if math.isnan(height) else height) + up.get(leg, 0.0)))
    return KinematicPlant(
        machine, ground, Stance((x, y, machine.height, 0.0), tuple(feet), lifted=tuple(up))
    )


def all_legs(vx: float, vy: float = 0.0, vz: float = 0.0) -> list[Point]:
    return [(vx, vy, vz)] * 4


def one_leg(leg: int, velocity: Point) -> list[Point]:
    return [velocity if i == leg else (0.0, 0.0, 0.0) for i in range(4)]


def feet_of(plant: KinematicPlant) -> list[tuple[float, ...]]:
    return [tuple(foot) for foot in plant.feet]


def run(plant: KinematicPlant, velocities: Sequence[Point], ticks: int) -> KinematicPlant:
    for _ in range(ticks):
        plant.move(velocities)
    return plant


def standing_stance() -> Stance:
    return Stance((0.0, 0.0, TITAN.height, 0.0), tuple((*leg.centre, 0.0) for leg in TITAN.legs))


def wild(ground: Ground, seed: int) -> list[object]:
    """Random velocities and pushes; what holds at every tick, checked; what happened."""
    rng, plant, happened = np.random.default_rng(seed), standing(ground=ground), []
    velocities = np.zeros((4, 3))
    for tick in range(1000):
        if tick % 7 == 0:
            velocities = rng.normal(0, 0.2, (4, 3)) * (rng.random((4, 1)) < 0.5) + rng.normal(
                0, 0.1, (1, 3)
            )
        if rng.random() < 0.01:
            plant.push(*(float(f) for f in rng.normal(0, 200, 2)), int(rng.integers(1, 20)))
        plant.move([tuple(v) for v in velocities.tolist()])
        sensing = plant.sense()
        assert all(math.isfinite(v) for v in plant.body)
        if plant.state == "fallen":
            break
        for foot in plant.feet:
            assert not foot[2] < ground.height_at(foot[0], foot[1]) - 1e-9, (
                "a foot is below the ground"
            )
        happened.append((tuple(plant.body), feet_of(plant), sensing, plant.state))
    return happened
