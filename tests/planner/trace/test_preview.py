"""What a prediction tells viewers: the trace ahead, the footholds, the bars of the
existence-segment chart.
"""

import math
from typing import Any

import pytest

from walking_console.planner.types import Command, GaitPreview, Mode
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

WALKED = Command(speed=0.1)


def walking(ticks: int, fraction: float = 0.1, **more: Any) -> Simulation:
    terrain = {"kind": "footholds", "fraction": fraction}
    console = Simulation(
        prepare(
            scenario_from(
                {"name": "six", "robot": "hexapod", "planner": "trace", "terrain": terrain, **more},
                None,
            )
        )
    )
    walk_on(console, ticks)
    return console


def walk_on(console: Simulation, ticks: int) -> None:
    for _ in range(ticks):
        console.order(WALKED)
        console.step()


def foreseen(console: Simulation) -> GaitPreview:
    ahead = console.snapshot().ahead
    assert ahead is not None
    return ahead


@pytest.fixture(scope="module")
def on_its_way() -> Simulation:
    return walking(400, trace={"kind": "sine", "speed": 0.1})


def test_a_given_trace_is_seen_before_the_first_step_and_nothing_is_planned_yet() -> None:
    ahead = foreseen(walking(0, trace={"kind": "sine"}))
    assert len(ahead.line) > 2 and ahead.line[0] == (0.0, 0.0, 0.0)
    assert not any(ahead.footholds) and ahead.complete


def test_a_joystick_walker_foresees_nothing_until_it_is_told_to_walk() -> None:
    console = walking(0)
    assert console.snapshot().ahead is None
    walk_on(console, 60)
    assert any(foreseen(console).footholds)


def test_a_crab_walker_foresees_no_trace() -> None:
    assert Simulation(prepare(scenario_from({"name": "flat"}, None))).snapshot().ahead is None


def test_the_line_goes_on_from_the_machine(on_its_way: Simulation) -> None:
    snapshot, ahead = on_its_way.snapshot(), foreseen(on_its_way)
    near = min(ahead.line, key=lambda point: abs(point[0] - snapshot.course))
    assert math.hypot(near[1] - snapshot.body[0], near[2] - snapshot.body[1]) < 0.15
    assert ahead.line[0][0] <= snapshot.course <= ahead.reached <= ahead.goal + 1e-9


def test_a_foot_stands_on_a_foothold_only_while_it_exists(on_its_way: Simulation) -> None:
    for bars in foreseen(on_its_way).bars:
        for s1, s2, placed, lifted in bars[1:]:
            assert s1 - 0.02 <= placed <= lifted <= s2 + 0.02


def test_successive_states_overlap_as_far_as_the_walk_is_sure(on_its_way: Simulation) -> None:
    states = foreseen(on_its_way).states
    assert len(states) > 5 and len(states) % 2 == 1
    for before, after in zip(states, states[1:], strict=False):
        assert max(before[0], after[0]) <= min(before[1], after[1]) + 1e-9


def test_footholds_are_allowed_ground(on_its_way: Simulation) -> None:
    for footholds in foreseen(on_its_way).footholds:
        assert all(on_its_way.perception.belief.allows(x, y) for x, y, _ in footholds)


def test_it_is_the_same_object_until_something_else_is_foreseen(on_its_way: Simulation) -> None:
    assert on_its_way.snapshot().ahead is on_its_way.snapshot().ahead


@pytest.mark.parametrize("body", ["straight", "sway"])
def test_a_dead_end_says_how_far_the_way_is_sure_before_it_is_reached_and_there(body: str) -> None:
    exact = {"kind": "sine", "detour": 0}
    console = walking(400, 0.004, seed=1, trace=exact, gait={"body": body})
    for ticks, is_there in ((0, False), (300, True)):
        walk_on(console, ticks)
        ahead = foreseen(console)
        assert (console.mode is Mode.BLOCKED) == is_there
        assert not ahead.complete and ahead.reached < ahead.goal and ahead.reason


def test_the_distance_on_the_trace_never_jumps_back_while_it_walks_on() -> None:
    console, before = walking(0, trace={"kind": "sine", "speed": 0.1}), 0.0
    for _ in range(600):
        console.order(WALKED)
        console.step()
        course = console.snapshot().course
        assert course >= before - 0.02
        before = course
    assert before > 0.5
