"""Walks over ground the map does not show: touch decides (H §9)."""

from dataclasses import replace

import numpy as np
import pytest

from walking_console.planner.control.encounter import TABLE, ContactEvent, FootState
from walking_console.planner.stability import MARGIN_SLACK
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Command, Mode
from walking_console.sim.requests import Edit
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import HOLD, Simulation
from walking_console.sim.world import prepare

SLOW = Command(0.0, 0.05)


def blind(scenario, *settings):
    """A console whose belief is flat ground at height 0, whatever the world is."""
    world = prepare(load_scenario(scenario, settings))
    known = world.belief
    flat = TerrainMap(
        np.zeros_like(known.heights), np.zeros_like(known.forbidden), known.cell, known.origin
    )
    return Simulation(replace(world, belief=flat))


def states_met(console, command, ticks):
    """Walk on and collect the emergent states passed; the margin and the machine must hold
    throughout.
    """
    met, console_states = set(), []
    console.order(command)
    for _ in range(ticks):
        console.step()
        state = (
            console.walk.contacts.encounter.state
            if console.walk.contacts.encounter
            else FootState.NORMAL
        )
        if state not in met or not console_states or console_states[-1] is not state:
            console_states.append(state)
        met.add(state)
        assert console.mode not in (Mode.TIPPING, Mode.FALLEN), console.reason
        assert console.margins(console.walk.carrying())[0] >= -MARGIN_SLACK
    return console_states


def test_every_state_has_a_way_in_and_a_way_out():
    into, out = {after for after in TABLE.values()}, {state for state, _ in TABLE}
    assert into == out == set(FootState)


def test_every_event_is_known_somewhere():
    assert {event for _, event in TABLE} == set(ContactEvent)


@pytest.mark.parametrize(
    ("scenario", "ticks", "way"),
    [("stairs-up", 5000, 3.0), ("block", 5000, 3.0), ("holes", 4000, 2.5)],
)
def test_it_walks_blind_over_ground_it_has_no_map_of(scenario, ticks, way):
    console = blind(scenario)
    states_met(console, SLOW, ticks)
    assert console.distance > way, console.reason
    assert sum(console.walk.contacts.counts.values()) > 0


def test_a_hit_stops_the_body_within_one_tick_and_the_foot_goes_back_up_and_over():
    console = blind("stairs-up", 'gait.body="straight"')
    x = hit(console)
    assert console.mode is Mode.EMERGENT
    assert console.plant.body[0] == pytest.approx(x, abs=1e-9)
    sequence = states_met(console, SLOW, 400)
    assert sequence[:2] == [FootState.RETRACE, FootState.RETRY]
    assert FootState.NORMAL in sequence


def hit(console):
    """Walk until a whisker touches, and a tick on, in which it is sensed: where the body was."""
    console.order(SLOW)
    for _ in range(5000):
        before = console.plant.whiskers[:]
        console.step()
        if any(console.plant.whiskers) and not any(before):
            break
    x = console.plant.body[0]
    console.step()
    return x


def test_a_hit_brings_a_swaying_body_to_rest_as_soon_as_its_margin_allows():
    console = blind("stairs-up", 'gait.body="sway"')
    x = hit(console)
    assert console.mode is Mode.EMERGENT
    for _ in range(20):
        console.step()
    rest = console.plant.body[0]
    assert rest - x < 0.01
    for _ in range(10):
        console.step()
        assert console.mode is Mode.EMERGENT
        assert console.plant.body[0] == pytest.approx(rest, abs=1e-9)


def test_a_higher_obstacle_is_climbed_in_steps():
    console = blind("block", "terrain.height=0.25")
    assert FootState.CLIMB in states_met(console, SLOW, 4000)


def test_missing_ground_is_searched_below_marked_and_the_foot_put_elsewhere():
    console = blind("holes", "terrain.fraction=0.2")
    begun = console.perception.belief.forbidden.sum()
    sequence = states_met(console, SLOW, 4000)
    assert FootState.DESCEND in sequence and FootState.PLACE in sequence
    assert console.perception.belief.forbidden.sum() > begun
    assert console.walk.contacts.counts.get("no ground", 0) > 0


def test_a_pole_in_the_way_is_marked_on_the_map():
    console = blind("poles")
    sequence = states_met(console, SLOW, 6000)
    assert FootState.RETRACE in sequence


def test_what_was_learnt_stays_learnt():
    console = blind("holes", "terrain.fraction=0.2")
    console.order(SLOW)
    known = 0
    for _ in range(4000):
        console.step()
        forbidden = int(console.perception.belief.forbidden.sum())
        assert forbidden >= known
        known = forbidden


def test_a_foothold_on_an_edge_is_left_again_and_a_strip_along_the_edge_is_marked():
    # here a foot comes down on the very edge of a step
    console = blind("stairs-up", "terrain.at=1.0")
    begun = int(console.perception.belief.forbidden.sum())
    met = set(states_met(console, SLOW, 1600))
    assert FootState.WITHDRAW in met
    assert (
        int(console.perception.belief.forbidden.sum()) - begun > 6
    )  # more than the cells under a sole


def test_a_foot_without_any_ground_waits_with_a_reason_and_goes_on_when_there_is_some():
    console = blind("flat")
    console.order(SLOW)
    while console.mode is not Mode.RETURN:
        console.step()
    leg = console.walk.plan.swing[0]
    x, y, _ = console.walk.plan.landing
    standing = [foot[:2] for i, foot in enumerate(console.plant.feet) if i != leg]
    ground = console.perception.ground
    row, column = ground.cell_at(x, y)
    hole = tuple(
        (r, c)
        for r in range(row - 14, row + 15)
        for c in range(column - 22, column + 23)
        if all(
            max(abs(ground.centre(r, c)[0] - fx), abs(ground.centre(r, c)[1] - fy)) > 0.1
            for fx, fy in standing
        )
    )
    belief = console.perception.belief
    console.request(Edit("dig", hole))
    console.serve_requests()
    console.perception.belief = belief  # the machine does not know
    for _ in range(1500):
        console.step()
        if console.mode is Mode.BLOCKED:
            break
    assert console.walk.contacts.encounter.state is FootState.STRANDED
    assert "no ground within reach" in console.reason
    console.request(Edit("clear", hole))
    console.order(HOLD)
    console.step()
    console.order(SLOW)
    states = states_met(console, SLOW, 1500)
    assert FootState.NORMAL in states
    assert console.mode not in (Mode.BLOCKED, Mode.EMERGENT)
