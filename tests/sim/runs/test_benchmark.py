"""Measuring speed: what is measured, not how much it is."""

import json

import pytest

from walking_console.planner.protocols import run_to_completion
from walking_console.planner.types import StepPlan
from walking_console.sim.runs import benchmark
from walking_console.sim.runs.tick_times import SENSINGS, time_walks


def test_every_figure_has_a_value_a_unit_and_a_target(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmark, "ROUNDS", 1)
    monkeypatch.setattr(benchmark, "TICKS", 20)
    monkeypatch.setattr(benchmark, "run_speed", lambda: 500.0)
    monkeypatch.setattr(benchmark, "start_up", lambda: 0.25)
    figures = benchmark.measure()["figures"]
    assert len(figures) == 8
    for figure in figures.values():
        assert figure["value"] > 0.0 and figure["unit"] in ("µs", "ms", "x real time")
        assert figure["target"].startswith(("<=", ">=")) or figure["value"] in (500.0, 250.0)


def test_microseconds_and_factor_are_of_one_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    spans = iter([2e-5, 4e-5])
    monkeypatch.setattr(benchmark, "tick_time", lambda recorded: next(spans))
    for name in ("plan_time", "reflex_time", "run_speed", "start_up"):
        monkeypatch.setattr(benchmark, name, lambda: 1.0)
    found = {name: entry["value"] for name, entry in benchmark.measure()["figures"].items()}
    assert found["headless tick, recorded"] == 40.0
    assert found["headless speed, not recorded"] == 1000.0
    assert found["headless speed, recorded"] == 500.0


def test_starting_costs_processor_time_of_a_child(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmark, "ROUNDS", 1)
    assert 0.02 < benchmark.start_up() < 20.0


def test_walks_that_were_timed_are_plain_data() -> None:
    measured = benchmark.measured_walks(time_walks((), 0.2, ["flat"]))
    assert json.loads(json.dumps(measured)) == measured
    assert [walk["sensing"] for walk in measured["walks"]] == list(SENSINGS)
    assert {walk["seconds"] for walk in measured["walks"]} == {0.2}


def test_steps_are_planned_in_postures_met_on_broken_ground() -> None:
    planner, ground, stances = benchmark.broken_ground()
    assert 0.4 < ground.forbidden.mean() < 0.6
    plan = run_to_completion(planner.plan(stances[0], benchmark.COMMAND, ground))
    assert isinstance(plan, StepPlan)
