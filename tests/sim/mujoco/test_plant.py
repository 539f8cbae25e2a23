"""The physics plant: it stands, walks as it is driven, falls when it must, and repeats itself."""

import json
import math
import subprocess
import sys
from hashlib import blake2b

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Stance
from walking_console.sim.mujoco.plant import PhysicsPlant
from walking_console.sim.mujoco.settings import Physics, ServoSettings
from walking_console.sim.sensor_noise import SensorNoise
from walking_console.sim.terrain.ground import Ground

STILL = (0.0, 0.0, 0.0)
TITAN = load_machine("titan3")


def level(cells: int = 80, height: float = 0.0) -> Ground:
    return Ground(np.full((cells, cells), height), 0.05, (-cells * 0.025, -cells * 0.025))


def stance_of(machine, yaw: float = 0.0) -> Stance:
    c, s = math.cos(yaw), math.sin(yaw)
    feet = tuple(
        (c * x - s * y, s * x + c * y, 0.0) for x, y in (leg.centre for leg in machine.legs)
    )
    return Stance((0.0, 0.0, machine.height, yaw), feet)


def plant_of(name: str = "titan3", **options) -> PhysicsPlant:
    machine = load_machine(name)
    return PhysicsPlant(machine, level(), stance_of(machine), **options)


def drive(plant: PhysicsPlant, ticks: int, velocity=STILL, **options) -> PhysicsPlant:
    for _ in range(ticks):
        plant.move([velocity] * len(plant.feet), **options)
    return plant


@pytest.mark.parametrize("name", ["titan3", "hexapod", "phantomx"])
@pytest.mark.parametrize("sag", [0.0005, 0.002, 0.005])
def test_every_shipped_robot_stands_still_on_every_servo(name, sag):
    machine = load_machine(name)
    plant = drive(plant_of(name, physics=Physics(ServoSettings(sag=sag))), 100)
    assert plant.state == "standing"
    assert all(plant.soles)
    assert plant.body[2] == pytest.approx(machine.height, abs=1e-3)
    assert max(abs(plant.body[3]), abs(plant.body[4])) < 1e-3
    assert sum(plant.loads) == pytest.approx(machine.mass * 9.81, rel=1e-2)


def test_a_leg_gives_by_its_sag_under_a_quarter_of_the_weight():
    plant = plant_of(physics=Physics(ServoSettings(sag=0.005)))
    feet_b = list(plant.sense().feet_b)
    for _ in range(100):
        plant.follow(feet_b)  # the targets as they are, nothing pressing
    assert plant.body[2] == pytest.approx(TITAN.height - 0.005 * (1 - 0.12), abs=5e-4)


def test_with_planned_loads_pressed_it_does_not_sag():
    plant = plant_of(physics=Physics(ServoSettings(sag=0.005)))
    feet_b = list(plant.sense().feet_b)
    for _ in range(100):
        plant.follow(feet_b, [80.0 * 9.81 / 4] * 4)
    assert plant.body[2] == pytest.approx(TITAN.height, abs=3e-4)


def test_the_body_goes_where_its_carrying_feet_are_driven():
    plant = drive(plant_of(), 50, (-0.1, 0.05, 0.0))
    assert plant.body[:2] == pytest.approx([0.1, -0.05], abs=3e-3)
    assert plant.sense().body[:2] == pytest.approx(plant.body[:2], abs=1e-3)


def test_a_swinging_foot_loses_its_load_and_finds_the_ground_again():
    plant = drive(plant_of(), 20)
    for _ in range(20):
        plant.move([(0.0, 0.0, 0.2), STILL, STILL, STILL])
    assert not plant.soles[0] and plant.loads[0] == 0.0
    assert plant.sense().feet_b[0][2] > -TITAN.height + 0.06
    for _ in range(30):
        plant.move([(0.0, 0.0, -0.2), STILL, STILL, STILL])
    assert plant.soles[0]


def test_feet_are_not_driven_faster_or_further_than_the_machine_can():
    plant = drive(plant_of(), 5)
    start = plant.sense().feet_b[0]
    for _ in range(10):
        plant.move([(0.0, 0.0, 50.0), STILL, STILL, STILL])
    assert plant.sense().feet_b[0][2] - start[2] <= 0.8 * 0.2 + 0.02
    for _ in range(200):
        plant.move([(50.0, 0.0, 0.0), STILL, STILL, STILL])
    assert plant.sense().feet_b[0][0] <= 0.75 + 0.01
    plant.move([(math.nan, 0.0, 0.0), STILL, STILL, STILL])
    assert all(math.isfinite(value) for value in plant.body)


def test_ground_that_is_not_there_carries_nothing():
    ground = level().edited(
        (row, column, math.nan) for row in range(80) for column in range(40, 80)
    )
    plant = PhysicsPlant(TITAN, ground, stance_of(TITAN))
    assert plant.soles == [False, True, True, False]
    drive(plant, 150)
    assert plant.state == "fallen"


def test_a_push_moves_it_and_a_strong_one_throws_it_over_where_it_stays():
    plant = drive(plant_of(), 10)
    plant.push(0.0, 300.0, 5)
    drive(plant, 60)
    assert plant.state == "standing"
    plant.push(0.0, 1500.0, 25)
    drive(plant, 100)
    assert plant.state == "fallen"
    at = list(plant.body)
    drive(plant, 3)
    assert plant.body == at


def test_a_push_must_be_finite():
    with pytest.raises(ValueError, match="finite newtons"):
        plant_of().push(math.inf, 0.0, 1)


def test_other_ground_is_stood_on_in_the_same_motion():
    plant = drive(plant_of(), 25, (-0.1, 0.0, 0.0))
    before = list(plant.body)
    plant.replace_ground(level(height=0.0).edited([(5, 5, 0.3)]))
    assert plant.body == pytest.approx(before, abs=1e-12)
    plant.replace_ground(level(height=0.05))
    assert min(foot[2] for foot in plant.feet) > 0.045
    drive(plant, 50)
    assert plant.state == "standing"


def test_a_foot_against_a_riser_feels_it_on_the_side_it_was_going_to():
    # a step of 0.2 m, 0.15 m ahead of the front feet
    ground = level().edited((row, column, 0.2) for row in range(80) for column in range(52, 80))
    plant = drive(PhysicsPlant(TITAN, ground, stance_of(TITAN)), 5)
    for _ in range(15):
        plant.move([(0.0, 0.0, 0.4), STILL, STILL, STILL])
    for _ in range(80):
        plant.move([(0.6, 0.0, 0.0), STILL, STILL, STILL])
        if plant.whiskers[0]:
            break
    assert plant.whiskers[0] == 1  # ahead
    assert plant.feet[0][0] == pytest.approx(0.6, abs=0.02)


def test_the_inertial_sensor_says_how_fast_the_body_turns():
    plant = drive(plant_of(), 5)
    for _ in range(10):
        plant.move([(-0.1 * y, 0.1 * x, 0.0) for x, y, _ in plant.sense().feet_b])
    assert plant.sense().rates[2] == pytest.approx(-0.1, abs=0.03)


def test_odometry_drifts_from_the_truth_where_feet_slip_and_says_which():
    ice = Physics(friction=0.02)
    plant = drive(plant_of(physics=ice), 5)
    slipped = False
    for k in range(100):
        way = 0.3 if k % 20 < 10 else -0.3
        plant.move([(way, 0.0, 0.0), (-way, 0.0, 0.0), (way, 0.0, 0.0), (-way, 0.0, 0.0)])
        slipped = slipped or any(plant.sense().slipping)
    assert slipped


def test_it_says_that_its_odometry_drifts_and_how_late_its_sensors_are():
    noisy = plant_of(noise=SensorNoise(0.005, delay=2), rng=np.random.default_rng(1))
    assert plant_of().tolerances.drift > 0.0 == plant_of().tolerances.late
    assert noisy.tolerances.late == 2 and noisy.tolerances.scatters


def test_sensors_without_noise_say_what_is_so_and_with_noise_something_near_it():
    plant = drive(plant_of(), 5)
    noisy = drive(
        plant_of(noise=SensorNoise(0.002, 0.004, 0.01, 5.0), rng=np.random.default_rng(1)), 5
    )
    exact, blurred = plant.sense(), noisy.sense()
    assert exact.loads == tuple(plant.loads)
    for a, b in zip(exact.feet_b, blurred.feet_b, strict=True):
        assert 0.0 < math.dist(a, b) < 0.02
    assert blurred.body[:3] == exact.body[:3]
    assert blurred.body[3] != exact.body[3]


def walked_hash(ticks: int = 120) -> str:
    plant, digest = plant_of(), blake2b(digest_size=8)
    for k in range(ticks):
        up = 0.3 if 20 <= k < 40 else -0.3 if 60 <= k < 80 else 0.0
        plant.move([(-0.05, 0.0, up), *[(-0.05, 0.0, 0.0)] * 3], [196.0] * 4)
        digest.update(np.array([*plant.body, *plant.loads]).tobytes())
    return digest.hexdigest()


def test_it_repeats_to_the_last_bit_in_a_process_and_across_processes():
    here = walked_hash()
    assert walked_hash() == here
    code = "from tests.sim.mujoco.test_plant import walked_hash; print(walked_hash())"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == here


def test_it_goes_on_from_a_checkpoint_to_the_last_bit():
    plant = drive(plant_of(), 30, (-0.1, 0.0, 0.0))
    plant.push(50.0, 20.0, 10)
    drive(plant, 4, (-0.1, 0.0, 0.0))
    saved = json.loads(json.dumps(plant.checkpoint()))
    other = plant_of()
    other.restore(saved)
    for one in (plant, other):
        drive(one, 40, (-0.05, 0.05, 0.0))
    assert other.body == plant.body
    assert other.sense() == plant.sense()


def test_a_heavier_machine_than_the_card_says_weighs_more():
    plant = drive(plant_of(physics=Physics(mass_factor=1.2)), 80)
    assert sum(plant.loads) == pytest.approx(1.2 * 80.0 * 9.81, rel=1e-2)


def test_a_stance_of_another_number_of_feet_is_refused():
    stance = stance_of(TITAN)
    with pytest.raises(ValueError, match="has 4 feet, got 3"):
        PhysicsPlant(TITAN, level(), Stance(stance.body, stance.feet[:3]))
