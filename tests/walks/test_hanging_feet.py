"""Two feet in the air at once: one stands again, the other has found no ground, and the stick asks
for more. A body that sways keeps its margin in physics and comes to none of this; straight it does.
"""

from dataclasses import replace

import pytest

from walking_console.planner.types import Mode
from walking_console.sim.runs.runner import TimelinePlayer
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare


def test_ordered_on_with_one_foot_set_down_it_searches_for_the_one_that_hangs() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")
    # its first step is planned in one tick: a tick later it meets the ground otherwise
    settings = ["plant=physics", "gait.body=straight", "config.planning.work_wanted=1000"]
    world = prepare(load_scenario("fig12", settings))
    # a ground that is not what is believed of it: holes of a height field begin too early
    simulation = Simulation(replace(world, ground=replace(world.ground, relief=True)))
    player = TimelinePlayer(simulation)
    modes = []
    for _ in range(300):
        player.give()
        simulation.step()
        player.note()
        modes.append(simulation.mode)
    turns = list(zip(modes, modes[1:], strict=False))
    assert (Mode.EMERGENT, Mode.BLOCKED) in turns, "no foot was left hanging: this tells nothing"
    assert (Mode.BLOCKED, Mode.EMERGENT) in turns
