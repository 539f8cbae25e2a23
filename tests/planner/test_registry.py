"""Planners by name: what there is, what each declares, and how another one comes in."""

import sys
from importlib.metadata import EntryPoint

import pytest

from tests.planner.conftest import TOY
from walking_console.planner import registry
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import Capabilities, PlannerError, PlannerSetup
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Gait

TITAN, HEXAPOD = load_machine("titan3"), load_machine("hexapod")


def setup(machine, mode="", **more):
    gait = Gait(machine.duty_factor, machine.lift_up, machine.lift_down, machine.height)
    return PlannerSetup(machine, gait, mode, **more)


def test_both_papers_are_there_and_the_first_mode_is_the_default():
    assert registry.planner_names()[:2] == ("crab", "trace")
    assert list(registry.planner_entry("crab").modes) == ["predictive", "paper", "naive"]
    assert registry.capabilities("crab") == registry.capabilities("crab", "predictive")


def test_only_the_predictive_crab_leans_and_only_the_trace_walker_previews():
    assert registry.choices_that(lambda c: c.may_lean) == (("crab", "predictive"),)
    assert registry.choices_that(lambda c: c.follows_trace) == (("trace", ""),)
    assert registry.choices_that(lambda c: c.gives_preview) == (("trace", ""),)
    assert [mode for _, mode in registry.choices_that(lambda c: c.takes_detours)] == [
        "predictive",
        "paper",
    ]


def test_a_planner_without_modes_answers_to_every_mode():
    assert registry.capabilities("trace", "paper") is registry.capabilities("trace")


def test_an_unknown_name_or_mode_is_refused_with_those_there_are():
    with pytest.raises(PlannerError, match="unknown planner 'trot'; there are: crab, trace"):
        registry.capabilities("trot")
    with pytest.raises(PlannerError, match="'fast'; there are: predictive, paper, naive"):
        registry.make_planner("crab", setup(TITAN, "fast"))
    with pytest.raises(PlannerError, match="unknown planner"):
        registry.unregister_planner("trot")


def test_a_rigid_gait_that_does_not_exist_is_refused():
    with pytest.raises(PlannerError, match="there are"):
        registry.make_planner("trace", setup(HEXAPOD, rigid_gait="moonwalk"))


def test_one_module_and_one_entry_make_a_planner_known(toy):
    assert "toy" in registry.planner_names()
    assert isinstance(registry.make_planner("toy", setup(HEXAPOD)), toy.ToyPlanner)
    place = Placement((0.0, 0.0, 0.0), lambda x, y: 0.0)
    gait = setup(HEXAPOD).gait
    assert registry.initial_stance("toy", "", HEXAPOD, gait, place) == square_stance(
        HEXAPOD, gait, place
    )


def test_a_name_is_given_once_and_at_least_one_mode(toy):
    with pytest.raises(PlannerError, match="registered already"):
        registry.register_planner("toy", modes={"": Capabilities()})
    with pytest.raises(PlannerError, match="at least one mode"):
        registry.register_planner("other", modes={})


def test_a_package_brings_its_planner_by_an_entry_point(monkeypatch):
    point = EntryPoint("toy", TOY, registry.ENTRY_POINTS)
    asked = []
    monkeypatch.setattr(registry, "entry_points", lambda group: asked.append(group) or [point])
    sys.modules.pop(TOY, None)
    registry._load_installed.cache_clear()
    try:
        assert "toy" in registry.planner_names()
        assert asked == ["walking_console.planners"]
    finally:
        registry.unregister_planner("toy")
        sys.modules.pop(TOY, None)


def test_a_package_that_cannot_be_loaded_is_named(monkeypatch):
    point = EntryPoint("broken", "no_such_module_here", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "entry_points", lambda group: [point])
    registry._load_installed.cache_clear()
    with pytest.raises(PlannerError, match="cannot load planner 'broken'"):
        registry.planner_names()
    monkeypatch.undo()
    registry._load_installed.cache_clear()
    assert "crab" in registry.planner_names()


def test_rigid_gaits_are_those_that_planners_declare():
    assert registry.rigid_gait_names() == ("tripod", "wave", "ripple", "gallop")
