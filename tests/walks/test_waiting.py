"""How long Level C waits on standing feet for a first step: two ticks, then the best step thought
of so far will do.
"""

import pytest

from walking_console.planner.config import Planning
from walking_console.planner.control.plan_job import SLICE
from walking_console.planner.crab.planner import plan_step
from walking_console.planner.crab.steps import StepRequest
from walking_console.planner.types import Command
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

SLICES, WAIT = Planning().work_wanted // SLICE, Planning().wait_max
WALK = Command(0.0, 0.08)


def thinker(console, slices):
    """A planner that thinks for so many slices, and answers early when the best so far is wanted;
    ``asked`` counts how often it was.
    """
    asked = []

    def think(stance, command, terrain):
        for _ in range(slices):
            if (yield):
                asked.append(console.tick_count)
                break
        world = console.world
        return plan_step(StepRequest(stance, command, terrain, world.machine, world.gait))

    return think, asked


def ticks_to_the_first_step(slices):
    console = Simulation(prepare(load_scenario("flat", ["detours=false"])))
    console.planner.plan, asked = thinker(console, slices)
    console.order(WALK)
    for tick in range(1, 12):
        console.step()
        if console.walk.steps:
            return tick, len(asked)
    pytest.fail("it does not begin to walk")


def test_a_thought_without_an_end_is_waited_for_two_ticks():
    assert ticks_to_the_first_step(10**9) == (WAIT, 1)
    assert WAIT * 0.02 <= 0.1, "the stick is to be answered within a tenth of a second"


@pytest.mark.parametrize(("slices", "ticks"), [(0, 1), (SLICES - 1, 1), (SLICES + 1, 2)])
def test_a_thought_that_comes_to_its_end_is_not_waited_for_longer_than_it_takes(slices, ticks):
    assert ticks_to_the_first_step(slices) == (ticks, 0)
