"""How much is planned in a tick, where the ticks of walks were longest."""

import pytest

from walking_console.planner.config import Planning
from walking_console.planner.control.plan_job import HURRY, SLICE
from walking_console.planner.protocols import Announced
from walking_console.sim.runs.runner import TimelinePlayer
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

TICKS = 300
# what one slice may weigh: a costmap of the whole region is the heaviest
HEAVIEST = 250
# what laying a step that is waited for may weigh beside: it is done at once, however heavy
LAID = 350


class Scales:
    """A planner's jobs, with the weight of every slice noted for the tick it is done in."""

    def __init__(self, simulation: Simulation) -> None:
        self.of_ticks: list[list[int]] = []
        self._plan = simulation.planner.plan
        simulation.planner.plan = self.plan  # type: ignore[method-assign]

    def plan(self, *question):  # type: ignore[no-untyped-def]
        job = self._plan(*question)
        wanted = None
        while True:
            try:
                weight = job.send(wanted)
            except StopIteration as done:
                return done.value
            self.of_ticks[-1].append(SLICE if weight is None else weight)
            wanted = yield weight


@pytest.mark.parametrize(
    ("name", "sensing"),
    [("gap", "known"), ("stepping-stones", "eye"), ("steep", "none"), ("tripod", "known")],
)
def test_no_tick_plans_more_than_it_may_but_for_its_last_slice_and_laying_what_is_waited_for(
    name: str, sensing: str
) -> None:
    simulation = Simulation(prepare(load_scenario(name, (f"sensing={sensing}", "expect={}"))))
    player = TimelinePlayer(simulation)
    scales = Scales(simulation)
    for _ in range(TICKS):
        player.give()
        scales.of_ticks.append([])
        simulation.step()
        player.note()
    most = Planning().work_wanted
    assert max(map(sum, scales.of_ticks)) > most, "it never has to leave anything for the next tick"
    most += most // HURRY
    for weights in scales.of_ticks:
        announced = [weight for weight in weights if isinstance(weight, Announced)]
        others = [weight for weight in weights if not isinstance(weight, Announced)]
        assert sum(others[:-1]) < most and max(others, default=0) <= HEAVIEST
        assert sum(announced) <= LAID
