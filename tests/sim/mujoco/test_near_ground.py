"""A pool of shapes in place of all boxes of the ground."""

import json
import math

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Stance
from walking_console.sim.mujoco import bodies
from walking_console.sim.mujoco.near_ground import REACH, NearGround, shares
from walking_console.sim.mujoco.plant import PhysicsPlant
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import prepare

TITAN = load_machine("titan3")
STILL = (0.0, 0.0, 0.0)
HIGH = (0.0, 0.0, 5.0)  # of a torso that meets nothing


def riddled(seed: int = 1) -> Ground:
    """Holes everywhere but under the feet of the standard posture, and cells of two heights."""
    heights = np.random.default_rng(seed).choice(
        [0.0, 0.004, np.nan], (160, 160), p=[0.5, 0.2, 0.3]
    )
    ground = Ground(heights, 0.05, (-4.0, -4.0))
    under = [ground.cell_at(*leg.centre) for leg in TITAN.legs]
    return ground.edited(
        (row + dr, column + dc, 0.0)
        for row, column in under
        for dr in range(-1, 2)
        for dc in range(-2, 8)
    )


def stance() -> Stance:
    feet = tuple((*leg.centre, 0.0) for leg in TITAN.legs)
    return Stance((0.0, 0.0, TITAN.height, 0.0), feet)


def standing(ground: Ground) -> PhysicsPlant:
    return PhysicsPlant(TITAN, ground, stance())


def walked(plant: PhysicsPlant, ticks: int) -> list[float]:
    """Body and loads while the legs stride over whatever there is, one after the other."""
    told: list[float] = []
    for k in range(ticks):
        up = 0.3 if k % 60 < 20 else -0.3 if k % 60 < 45 else 0.0
        ahead = 0.3 if 0.0 < up or k % 60 < 30 else -0.05
        velocities = [(-0.05, 0.0, 0.0)] * 4
        velocities[k // 60 % 4] = (ahead, 0.02, up)
        plant.move(velocities, [196.0] * 4)
        told += [*plant.body, *plant.loads]
    return told


def all_numbers(self: NearGround, feet: object, torso: object) -> list[int]:
    """Every box, wherever the machine is."""
    return list(range(len(self.tops)))


def test_a_walk_on_the_boxes_that_are_near_is_the_walk_on_all_of_them(monkeypatch):
    ground = riddled()
    near = walked(standing(ground), 400)
    monkeypatch.setattr(
        NearGround, "numbers", lambda self, feet, torso: list(range(len(self.tops)))
    )
    assert walked(standing(ground), 400) == near


def test_a_body_led_into_a_wall_meets_it_as_among_all_boxes(monkeypatch):
    ahead = TITAN.torso[0] / 2 + 0.1

    def led() -> list[float]:
        ground = riddled()
        row, column = ground.cell_at(ahead, 0.0)
        plant = standing(ground.edited([(row, column, 1.0)]))
        told: list[float] = []
        for _ in range(100):
            plant.move([(-0.1, 0.0, 0.0)] * 4, [196.0] * 4)
            told += [*plant.body, *plant.loads]
        assert plant.state == "fallen"  # its torso is in touch with something
        return told

    near = led()
    monkeypatch.setattr(NearGround, "numbers", all_numbers)
    assert led() == near


def test_every_cell_that_a_foot_can_get_to_in_a_tick_is_there():
    ground = riddled(2)
    near = NearGround(ground, 0.01, 0.5)
    chance = np.random.default_rng(3)
    for x, y in chance.uniform(-4.1, 4.1, (50, 2)):
        numbers = near.numbers([(x, y, 0.0)], HIGH)
        assert numbers == sorted(set(numbers))
        places, sizes = near.places[numbers], near.sizes[numbers]
        for px, py in chance.uniform(-REACH - 0.01, REACH + 0.01, (40, 2)) + (x, y):
            height = ground.height_at(px, py)
            off = np.abs(places[:, :2] - (px, py)) <= sizes[:, :2] + 1e-9
            tops = (places[:, 2] + sizes[:, 2])[off.all(axis=1)]
            assert math.isnan(height) or np.isclose(tops, height).any(), (px, py)


def test_which_boxes_are_near_does_not_depend_on_where_one_was_before():
    ground = riddled(4)
    one = NearGround(ground, 0.01, 0.5)
    for x, y, low in np.random.default_rng(5).uniform((-3, -3, -0.2), (3, 3, 0.4), (60, 3)):
        feet = [(x + dx, y + dy, 0.0) for dx, dy in ((0.6, 0.4), (-0.6, 0.4), (0.0, -0.4))]
        new = NearGround(ground, 0.01, 0.5)
        assert one.numbers(feet, (x, y, low)) == new.numbers(feet, (x, y, low))


def test_a_torso_meets_what_is_as_tall_as_it_is_low():
    heights = np.zeros((80, 80))
    heights[40, 40] = 0.5
    heights[20, 20] = 0.5
    ground = Ground(heights, 0.05, (-2.0, -2.0))
    near = NearGround(ground, 0.01, 0.4)

    def tops(low: float) -> list[float]:
        return near.tops[near.numbers([], (0.0, 0.0, low))].tolist()

    assert tops(0.8) == []
    assert tops(0.55) == [0.5]  # not the one 1.4 m away
    assert len(tops(0.05)) > 1


def test_a_model_of_twenty_thousand_boxes_holds_a_few_dozen_shapes():
    world = prepare(load_scenario("fig14", ["plant=physics"]))
    plant = PhysicsPlant(world.machine, world.ground, world.stance)
    built = plant._bodies.built
    assert len(plant._bodies.near.tops) > 20_000
    assert built.model.ngeom == built.pool + 5
    assert built.pool <= shares(100)


def test_a_checkpoint_is_gone_on_from_on_other_boxes_to_the_last_bit():
    ground = riddled()
    plant = standing(ground)
    walked(plant, 170)
    saved = json.loads(json.dumps(plant.checkpoint()))
    other = standing(ground)
    other.restore(saved)
    assert walked(other, 150) == walked(plant, 150)


def test_a_pool_that_grows_goes_on_to_the_last_bit(monkeypatch):
    ground = riddled()
    whole = walked(standing(ground), 200)
    monkeypatch.setattr(bodies, "SHARE", 1)
    monkeypatch.setattr(bodies, "shares", lambda count: count)
    plant = standing(ground)
    begun = plant._bodies.built.pool
    assert walked(plant, 200) == whole
    assert plant._bodies.built.pool > begun


def test_dug_ground_is_gone_from_under_the_foot_that_stood_there():
    plant = standing(riddled())
    plant.move([STILL] * 4)
    assert all(plant.soles)
    row, column = plant.ground.cell_at(*TITAN.legs[0].centre)
    around = [(row + dr, column + dc, math.nan) for dr in (-1, 0, 1) for dc in (-1, 0, 1)]
    plant.replace_ground(plant.ground.edited(around))
    for _ in range(10):
        plant.move([STILL] * 4)
    assert not plant.soles[0] and plant.soles[1]


def test_where_all_ground_is_gone_nothing_of_it_is_left():
    plant = standing(riddled())
    plant.move([STILL] * 4)
    model = plant._bodies.built.model
    plant.replace_ground(Ground(np.full((160, 160), np.nan), 0.05, (-4.0, -4.0)))
    plant.move([STILL] * 4)
    assert not any(plant.soles)
    assert plant._bodies.built.model is model  # nothing is compiled for an edit of cells
