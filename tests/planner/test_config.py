"""The tunables: set from a scenario by theme and name, refused with what there is otherwise."""

import math
from dataclasses import fields, is_dataclass

import pytest

from walking_console.planner.config import (
    DEFAULT,
    Gains,
    PlannerConfig,
    Tolerances,
    TraceSearch,
    Tracking,
    configured,
)
from walking_console.planner.types import Command
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


def test_nothing_set_is_the_default():
    assert configured({}) == DEFAULT == PlannerConfig()


def test_one_setting_changes_and_the_others_stay():
    config = configured({"tracking": {"held_back": 0.05}, "planning": {"work": 8}})
    assert config.tracking == Tracking(held_back=0.05)
    assert config.planning.work == 8 and config.planning.work_wanted == 240
    assert config.gains == Gains()


def test_an_unknown_theme_or_name_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="'track' in config; there are: tracking, planning, gains"):
        configured({"track": {}})
    with pytest.raises(ValueError, match="'held' in config.tracking; there are: same_place"):
        configured({"tracking": {"held": 1.0}})


@pytest.mark.parametrize("bad", [True, "0.1", None, [0.1], math.nan, math.inf, -0.1])
def test_settings_are_numbers(bad):
    with pytest.raises(ValueError, match="config.tracking.held_back should be"):
        configured({"tracking": {"held_back": bad}})


def test_counts_are_whole():
    with pytest.raises(ValueError, match="config.planning.work should be an integer"):
        configured({"planning": {"work": 1.5}})
    with pytest.raises(ValueError, match="config.tracking should be a table"):
        configured({"tracking": 3})


def test_what_a_scenario_does_not_set_is_the_plants_to_say():
    rough = Tolerances(same_place=1e-3, held_back=0.03)
    within = Tracking(held_back=0.05).within(rough)
    assert within == Tolerances(same_place=1e-3, held_back=0.05)


def test_every_theme_is_a_frozen_value_of_numbers():
    for theme in fields(PlannerConfig):
        settings = getattr(DEFAULT, theme.name)
        assert is_dataclass(settings)
        with pytest.raises(AttributeError):
            setattr(settings, fields(settings)[0].name, 1.0)
        for each in fields(settings):
            value = getattr(settings, each.name)
            assert value is None or isinstance(value, int | float | str)


def test_a_scenario_sets_them_and_says_what_it_cannot():
    scenario = load_scenario("flat", ["config.tracking.held_back=0.05"])
    run = Simulation(scenario).walk.run
    assert run.tolerances.held_back == 0.05 and run.tolerances.same_place == 1e-6
    with pytest.raises(ScenarioError, match="unknown key 'held' in config.tracking; there are:"):
        load_scenario("flat", ["config.tracking.held=0.05"])


@pytest.mark.parametrize(("held_back", "stops"), [(0.01, True), (0.03, False)])
def test_how_far_a_body_may_be_pushed_aside_before_the_step_stops_is_a_setting(held_back, stops):
    simulation = Simulation(load_scenario("flat", [f"config.tracking.held_back={held_back}"]))
    simulation.order(Command(0.0, 0.1))
    simulation.run(seconds=2)
    sensing = simulation.plant.sense()
    x, y, *rest = sensing.body
    aside = sensing._replace(body=(x, y + 0.02, *rest))
    assert not simulation.walk.run.held_back(sensing)
    assert simulation.walk.run.held_back(aside) is stops


def test_a_law_is_one_of_those_there_are():
    assert configured({"gains": {"law": "printed"}}).gains.law == "printed"
    assert configured({"trace": {"aim": "margin", "sway": 0}}).trace == TraceSearch(0, "margin")
    with pytest.raises(ValueError, match="aim should be one of soonest, states, margin, speed"):
        configured({"trace": {"aim": "exact"}})
    with pytest.raises(
        ValueError, match="config.gains.law should be one of exact, inertia, printed"
    ):
        configured({"gains": {"law": "stiff"}})


def test_a_scenario_chooses_the_law_instead_of_the_plant():
    law = ("config.gains.law=inertia",)
    assert Simulation(load_scenario("flat")).walk.loads is None
    assert len(Simulation(load_scenario("flat", law)).walk.loads or ()) == 4
