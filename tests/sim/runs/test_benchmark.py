"""Measuring speed: what is measured, not how much it is."""

import pytest

from walking_console.planner.protocols import run_to_completion
from walking_console.planner.types import StepPlan
from walking_console.sim.runs import benchmark


def test_every_figure_has_a_value_a_unit_and_a_target(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmark, "ROUNDS", 1)
    monkeypatch.setattr(benchmark, "TICKS", 20)
    monkeypatch.setattr(benchmark, "run_speed", lambda: 500.0)
    figures = benchmark.measure()["figures"]
    assert len(figures) == 7
    for figure in figures.values():
        assert figure["value"] > 0.0 and figure["unit"] in ("µs", "x real time")
        assert figure["target"].startswith(("<=", ">=")) or figure["value"] == 500.0


def test_steps_are_planned_in_postures_met_on_broken_ground() -> None:
    planner, ground, stances = benchmark.broken_ground()
    assert 0.4 < ground.forbidden.mean() < 0.6
    plan = run_to_completion(planner.plan(stances[0], benchmark.COMMAND, ground))
    assert isinstance(plan, StepPlan)
