"""What every plant must do, whichever it is; a plant entered in the registry is taken up by itself.

``ToyPlant`` is the second one: forty lines, a machine that stands on level ground for ever.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from walking_console.planner.config import Tolerances
from walking_console.planner.geometry.transforms import point_placed, point_seen
from walking_console.planner.protocols import Plant, PlantState
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.types import TICK, Point, Sensing, Stance
from walking_console.sim.plants import PLANTS, PlantEntry
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.sensor_noise import SensorNoise
from walking_console.sim.simulation import Simulation
from walking_console.sim.terrain.ground import Ground

TITAN = load_machine("titan3")
NEAR = Tolerances().held_back  # m; no plant that can be walked errs by more in a second


class ToyPlant:
    """Carries its body straight on with the feet that are down; level bodies and no falling."""

    tolerances = Tolerances()
    loads = ()
    state: PlantState = "standing"

    def __init__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: SensorNoise | None = None,
        rng: np.random.Generator | None = None,
        physics: object = None,
    ) -> None:
        x, y, z, yaw = stance.body
        self.machine = machine
        self.ground = ground
        self.tick = 0
        self.body = [x, y, z, 0.0, 0.0, yaw]
        self.feet = [list(foot) for foot in stance.feet]
        self.soles = [leg not in stance.lifted for leg in range(len(self.feet))]
        self.whiskers = [0] * len(self.feet)
        self.joints = [(0.0, 0.0, 0.0)] * len(self.feet)

    @property
    def pose(self) -> tuple[float, float, float, float]:
        return self.body[0], self.body[1], self.body[2], self.body[5]

    def sense(self) -> Sensing:
        feet = tuple(point_seen(self.pose, (f[0], f[1], f[2])) for f in self.feet)
        x, y, z, roll, pitch, yaw = self.body
        none = (0,) * len(feet)
        body = x, y, z, roll, pitch, yaw
        return Sensing(self.tick, body, feet, tuple(self.soles), none, (False,) * len(feet))

    def move(self, velocities: Sequence[Point], loads: Sequence[float] | None = None) -> None:
        self.tick += 1
        limits = self.machine.speed
        steps = [
            tuple(max(-most, min(most, v)) * TICK for v, most in zip(velocity, limits, strict=True))
            for velocity in velocities
        ]
        down = [leg for leg, sole in enumerate(self.soles) if sole]
        was = [point_seen(self.pose, (f[0], f[1], f[2])) for f in self.feet]
        mean = [sum(steps[leg][axis] for leg in down) / len(down) for axis in range(3)]
        x, y, z = point_placed(self.pose, (-mean[0], -mean[1], -mean[2]))
        lifts = [leg for leg in down if steps[leg][2] - mean[2] > 1e-6]
        self.body[:3] = x, y, z
        for leg, step in enumerate(steps):
            if leg in down and leg not in lifts:
                continue
            px, py, pz = (a + b for a, b in zip(was[leg], step, strict=True))
            fx, fy, fz = point_placed(self.pose, (px, py, pz))
            height = self.ground.height_at(fx, fy)
            self.soles[leg] = fz <= height + 1e-6
            self.feet[leg] = [fx, fy, max(fz, height)]

    def push(self, fx: float, fy: float, ticks: int) -> None:
        if not (math.isfinite(fx) and math.isfinite(fy)) or ticks < 0:
            raise ValueError(
                f"a push needs finite newtons and ticks, got {fx!r}, {fy!r}, {ticks!r}"
            )

    def replace_ground(self, ground: Ground) -> None:
        self.ground = ground


ENTRIES = {**PLANTS, "toy": PlantEntry(ToyPlant)}
if find_spec("mujoco") is None:  # an extra: a bare install does without
    del ENTRIES["physics"]


@pytest.fixture(params=ENTRIES)
def entry(request) -> PlantEntry:
    return ENTRIES[request.param]


def level(height: float = 0.0) -> Ground:
    return Ground(np.full((200, 200), height), 0.05, (-5.0, -5.0))


def stance(lifted: tuple[int, ...] = (), up: float = 0.05) -> Stance:
    feet = [(*leg.centre, up * (k in lifted)) for k, leg in enumerate(TITAN.legs)]
    return Stance((0.0, 0.0, TITAN.height, 0.0), tuple(feet), lifted=lifted)


def plant_of(entry: PlantEntry, at: Stance | None = None, **more) -> Plant[Ground]:
    return entry.make(TITAN, level(), at or stance(), **more)


def driven(plant: Plant[Ground], velocities: list[Point], ticks: int) -> None:
    for _ in range(ticks):
        plant.move(velocities)


def test_it_stands_where_it_was_set_down(entry):
    plant = plant_of(entry)
    assert plant.state == "standing"
    assert list(plant.body) == pytest.approx([0.0, 0.0, TITAN.height, 0.0, 0.0, 0.0], abs=NEAR)
    assert np.allclose(plant.feet, stance().feet, atol=NEAR)
    assert list(plant.soles) == [True] * 4
    assert isinstance(plant.tolerances, Tolerances)


def test_what_it_senses_has_one_value_a_leg_and_counts_the_ticks(entry):
    plant = plant_of(entry)
    driven(plant, [(0.0, 0.0, 0.0)] * 4, 3)
    sensing = plant.sense()
    assert sensing.tick == 3
    for values in (sensing.feet_b, sensing.soles, sensing.whiskers, sensing.slipping):
        assert len(values) == 4
    assert sensing.rims == () or len(sensing.rims) == 4


def test_its_monitors_say_where_the_feet_are_seen_from_the_body(entry):
    plant = plant_of(entry)
    driven(plant, [(-0.1, 0.05, 0.0)] * 4, 10)
    x, y, z, _, _, yaw = plant.body
    seen = [point_seen((x, y, z, yaw), tuple(foot)) for foot in plant.feet]
    assert np.allclose(plant.sense().feet_b, seen, atol=NEAR)


def test_feet_driven_back_together_carry_the_body_on_and_stay(entry):
    plant = plant_of(entry)
    driven(plant, [(-0.1, 0.05, 0.0)] * 4, 50)
    assert list(plant.body[:2]) == pytest.approx([0.1, -0.05], abs=NEAR)
    assert np.allclose(plant.feet, stance().feet, atol=NEAR)
    assert plant.state == "standing"


def test_a_foot_in_the_air_goes_where_it_is_driven_and_stops_on_the_ground(entry):
    plant = plant_of(entry, stance(lifted=(0,)))
    driven(plant, [(0.2, 0.0, 0.0), *[(0.0, 0.0, 0.0)] * 3], 10)
    assert not plant.soles[0]
    assert plant.feet[0][0] == pytest.approx(TITAN.legs[0].centre[0] + 0.04, abs=NEAR)
    driven(plant, [(0.0, 0.0, -0.2), *[(0.0, 0.0, 0.0)] * 3], 50)
    assert plant.soles[0]
    assert plant.feet[0][2] == pytest.approx(0.0, abs=NEAR)


def test_a_foot_that_is_raised_leaves_the_ground(entry):
    # the body where the three others carry it
    plant = plant_of(entry, replace(stance(), body=(-0.15, -0.15, TITAN.height, 0.0)))
    driven(plant, [(0.0, 0.0, 0.2), *[(0.0, 0.0, 0.0)] * 3], 10)
    assert not plant.soles[0] and all(plant.soles[1:])
    assert plant.feet[0][2] == pytest.approx(0.04, abs=max(NEAR, plant.tolerances.foot_off))


def test_no_foot_is_faster_than_the_machine_allows(entry):
    plant = plant_of(entry, stance(lifted=(0,), up=0.2))
    before = plant.sense().feet_b[0]
    plant.move([(100.0, 0.0, 0.0), *[(0.0, 0.0, 0.0)] * 3])
    assert plant.sense().feet_b[0][0] - before[0] <= TITAN.speed[0] * TICK + 1e-12


def test_the_same_inputs_give_the_same_bits(entry):
    one, other = (
        plant_of(entry, noise=SensorNoise(0.001, 0.001), rng=np.random.default_rng(4))
        for _ in range(2)
    )
    for plant in (one, other):
        driven(plant, [(-0.1, 0.03, 0.0)] * 4, 20)
    assert list(one.body) == list(other.body)
    assert one.sense() == other.sense()


def test_other_ground_leaves_the_machine_where_it_is(entry):
    plant = plant_of(entry)
    plant.replace_ground(level())
    assert list(plant.body) == pytest.approx([0.0, 0.0, TITAN.height, 0.0, 0.0, 0.0], abs=NEAR)
    assert list(plant.soles) == [True] * 4


@pytest.mark.parametrize("push", [(math.nan, 0.0, 1), (0.0, math.inf, 1), (0.0, 0.0, -1)])
def test_it_refuses_a_push_that_is_no_push(entry, push):
    with pytest.raises(ValueError, match="finite newtons"):
        plant_of(entry).push(*push)


@pytest.mark.parametrize("name", ENTRIES)
def test_a_walk_over_level_ground_needs_nothing_else_of_it(name, monkeypatch):
    monkeypatch.setitem(PLANTS, name, ENTRIES[name])
    settings = (f"plant={name}", "end={distance=1.0}", "expect={}")
    simulation = Simulation(load_scenario("flat", settings))
    simulation.drive(speed=0.08)
    simulation.run(seconds=20.0)
    assert simulation.distance > 1.0
    assert simulation.walk.steps_begun >= 4
    assert simulation.plant.state == "standing"


@pytest.mark.parametrize("name", sorted(set(ENTRIES) - {"toy"}))
def test_sensors_that_scatter_and_are_late_do_not_stop_a_walk(name):
    noise = "noise={position=0.005,posture_deg=0.5,delay=0.02}"
    simulation = Simulation(load_scenario("flat", (f"plant={name}", noise)))
    simulation.drive(speed=0.08)
    simulation.run(seconds=20.0)
    # no leg is lifted while a sole is off, so late readings cost up to a fifth of the 1.6 m
    assert simulation.distance > 1.28 and simulation.reason == ""
