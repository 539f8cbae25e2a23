"""How long Level C waits on standing feet for a first step: two ticks, then the best step thought of so far will do."""

import pytest

from planner.crab.plan import plan_step
from planner.vocabulary import Command
from planner.walk import PIECES_WANTED, WAIT_MAX
from server.console import Console, prepare
from sim.scenarios import load_scenario

WALK = Command(0.0, 0.08)


def thinker(console, pieces):
    """A planner that thinks for so many pieces, and answers early when the best so far is wanted; ``asked`` counts how often it was."""
    asked = []

    def think(stance, command, terrain):
        for _ in range(pieces):
            if (yield):
                asked.append(console.tick_count)
                break
        return plan_step(stance, command, terrain, console.world.machine, console.world.gait)

    return think, asked


def ticks_to_the_first_step(pieces):
    console = Console(prepare(load_scenario("flat", ["detours=false"])))
    console.walk.think, asked = thinker(console, pieces)
    console.order(WALK)
    for tick in range(1, 12):
        console.tick()
        if console.walk.kind == "step":
            return tick, len(asked)
    pytest.fail("it does not begin to walk")


def test_a_thought_without_an_end_is_waited_for_two_ticks():
    assert ticks_to_the_first_step(10**9) == (WAIT_MAX, 1)
    assert WAIT_MAX * 0.02 <= 0.1, "the stick is to be answered within a tenth of a second"


@pytest.mark.parametrize(("pieces", "ticks"), [(0, 1), (PIECES_WANTED - 1, 1), (PIECES_WANTED + 1, 2)])
def test_a_thought_that_comes_to_its_end_is_not_waited_for_longer_than_it_takes(pieces, ticks):
    assert ticks_to_the_first_step(pieces) == (ticks, 0)
