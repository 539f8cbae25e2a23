"""Walks over ground that gives way under a foot, on both plants."""

from __future__ import annotations

import math

import pytest

from tests.sweeps.seams import giving, walk
from walking_console.planner.types import Command, Mode
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

AHEAD = Command(0.0, 0.08)


def walked(plant: str, robot: str, bears: float, seconds: float) -> Simulation:
    if plant == "physics":
        pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")
    patch = f"{{x=[0.9,1.3], y=[0.1,0.9], sinks=0.1, bears={bears}}}"
    settings = [
        "expect={}",
        f"plant={plant}",
        'gait.body="straight"',
        f'terrain={{kind="flat", cell=0.025, gives_way=[{patch}]}}',
        "drive=[{t=0.0, speed=0.08}]",
        f"robot={robot}",
    ]
    if robot == "hexapod":
        settings.append("planner=trace")
    simulation = Simulation(load_scenario("flat", settings))
    simulation.order(AHEAD)
    for _ in range(round(seconds / 0.02)):
        simulation.step()
        assert simulation.mode is not Mode.FALLEN
        roll, pitch = simulation.plant.body[3:5]
        assert math.hypot(roll, pitch) < math.radians(4.0)
    return simulation


@pytest.mark.parametrize("plant", ["kinematic", "physics"])
@pytest.mark.parametrize("bears", [20.0, 230.0])  # less than a quarter, more than a quarter
def test_a_foothold_that_gives_way_is_left_for_another_and_the_walk_goes_on(
    plant: str, bears: float
) -> None:
    simulation = walked(plant, "titan3", bears, 20.0)
    assert simulation.perception.ground is not simulation.world.ground
    assert simulation.walk.contacts.counts == {"gave way": 1}
    assert simulation.distance > 1.3 and simulation.walk.blocked is None
    marked = simulation.perception.belief.forbidden
    assert marked.any() and not simulation.world.forbidden.any()


@pytest.mark.parametrize("plant", ["kinematic", "physics"])
def test_so_it_is_on_six_legs(plant: str) -> None:
    simulation = walked(plant, "hexapod", 20.0, 27.0)
    assert simulation.walk.contacts.counts == {"gave way": 1}
    assert simulation.distance > 1.7 and simulation.walk.blocked is None


# ground that is needed breaks: as a foot comes down, as another is on its way, as it just rises
@pytest.mark.parametrize(
    ("seed", "body"),
    [(18, "sway"), (12, "sway"), (2, "straight"), (48, "straight")],
)
def test_no_standing_foot_is_dragged_where_ground_breaks(seed: int, body: str) -> None:
    [(name, settings)] = (
        (name, settings)
        for name, settings in giving(range(seed, seed + 1))
        if "plant=kinematic" in settings and "robot=titan3" in settings
    )
    told = walk(name, *settings, f"gait.body={body}")
    assert told.ending == ("completed", "distance") and told.falls == 0
    assert told.slide <= 0.005
