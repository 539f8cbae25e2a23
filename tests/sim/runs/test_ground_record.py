"""The ground of a run comes back as it was."""

import numpy as np
import pytest

from walking_console.sim.perception import Perception
from walking_console.sim.requests import Edit
from walking_console.sim.runs.ground_record import ground_arrays, ground_from
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.terrain.generators import Obstacle
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import prepare

BODY = (0.0, 0.0, 0.85, 0.0, 0.0, 0.0)


def level(obstacles: tuple[Obstacle, ...] = ()) -> Ground:
    return Ground(np.zeros((40, 40)), 0.1, (-2.0, -2.0), obstacles=obstacles)


@pytest.mark.parametrize("name", ["rough", "holes", "poles", "stairs-up", "block", "dem"])
def test_every_bit_and_every_obstacle_comes_back(name: str) -> None:
    simulation = Simulation(load_scenario(name))
    ground = simulation.world.ground
    arrays = ground_arrays(ground, simulation.perception)
    again = ground_from(arrays, ground.kind, ground.final)
    assert again.heights.tobytes() == ground.heights.tobytes()
    assert (again.cell, again.origin) == (ground.cell, ground.origin)
    assert (again.kind, again.final) == (ground.kind, ground.final)
    assert again.obstacles == ground.obstacles


def test_round_and_cornered_obstacles_may_stand_together() -> None:
    round_one = Obstacle(1.0, 2.0, 0.0, 0.5, 0.1)
    corners = ((0.0, 0.0), (1.0, 0.0), (0.5, 1.0))
    cornered = Obstacle(0.5, 0.3, -0.1, 0.2, corners=corners)
    ground = level(obstacles=(round_one, cornered))
    perception = Perception(prepare(load_scenario("flat"), ground=ground), BODY)
    arrays = ground_arrays(ground, perception)
    assert ground_from(arrays, "flat", False).obstacles == (round_one, cornered)


def test_after_an_edit_the_ground_of_the_start_is_kept_beside_that_of_the_end() -> None:
    ground = level()
    perception = Perception(prepare(load_scenario("flat"), ground=ground), BODY)
    perception.edit(Edit("raise", ((1, 1),), 0.5))
    arrays = ground_arrays(ground, perception)
    assert arrays["heights"][1, 1] == 0.5 and arrays["start_heights"][1, 1] == 0.0
    assert ground_from(arrays, "flat", False).heights[1, 1] == 0.0
