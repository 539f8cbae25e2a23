"""Figures of merit of a finished walk."""

from types import SimpleNamespace

import numpy as np
import pytest

from walking_console.planner.geometry.paths import SampledPath
from walking_console.sim.runs.metrics import (
    average_height,
    average_rule,
    courses,
    courses_unsettled,
    measured,
    off_line,
    off_trace,
    roughness,
    stability_figures,
    standard_steps,
)
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


def command(tick: int, speed: float = 0.1, crab_angle: float = 0.0, turn_rate: float = 0.0):
    return {
        "tick": tick,
        "input": "command",
        "speed": speed,
        "crab_angle": crab_angle,
        "turn_rate": turn_rate,
    }


def recorded(inputs, ticks=100, steps=()):
    return SimpleNamespace(inputs=inputs, ticks=ticks, steps=list(steps))


def step(tick: int, off: float | None):
    return {"tick": tick, "off_standard": off}


def test_only_the_steps_at_the_end_count_as_standard() -> None:
    steps = [step(10, 0.01), step(20, 0.3), step(30, 0.05), step(40, 0.0)]
    assert standard_steps(steps, 0.05) == 2
    assert standard_steps([*steps, step(50, None)], 0.05) == 0


def test_a_course_lasts_until_the_next_command_and_holding_is_none() -> None:
    walk = recorded(
        [command(0), command(30, speed=0.0), command(60), {"input": "halt", "tick": 70}]
    )
    assert [(begin, end) for begin, end, _ in courses(walk)] == [(0, 30), (60, 100)]


def test_a_course_is_unsettled_when_its_last_step_was_or_there_was_none() -> None:
    steps = [step(20, 0.2), step(40, 0.0), step(80, 0.2)]
    walk = recorded([command(0), command(50), command(90)], steps=steps)
    assert courses_unsettled(walk, 0.05) == 2


def test_distance_off_the_line_is_square_to_the_last_course() -> None:
    body = np.zeros((100, 6))
    body[:, 0] = np.linspace(0.0, 1.0, 100)
    body[-1, 1] = 0.25
    assert off_line(recorded([command(0)]), {"body": body}) == pytest.approx(0.25)
    sideways = recorded([command(0, crab_angle=np.pi / 2)])
    assert off_line(sideways, {"body": body}) == pytest.approx(1.0)
    assert off_line(recorded([command(0, turn_rate=0.1)]), {"body": body}) is None
    assert off_line(recorded([]), {"body": body}) is None


def test_a_path_of_one_slope_is_not_rough_and_a_kink_is() -> None:
    course = np.linspace(0.0, 2.0, 201)
    assert roughness(course, 0.3 * course) == pytest.approx(0.0, abs=1e-12)
    assert roughness(course, np.abs(course - 1.0)) > 0.01
    assert roughness(course[:5], course[:5]) == 0.0


def test_the_average_rule_is_the_height_above_the_mean_of_the_feet() -> None:
    assert average_height([(0, 0, 0.1), (0, 0, 0.3)], 0.8) == pytest.approx(1.0)
    feet = np.zeros((50, 4, 3))
    feet[20:, 0, 2] = 0.4
    log = {"body": np.column_stack([np.linspace(0, 1, 50), np.zeros(50)]), "feet": feet}
    course, rows, heights = average_rule(log, [21, 50], 0.5)
    assert rows.tolist() == [0, 20, 49] and course[-1] == pytest.approx(1.0)
    assert heights == pytest.approx([0.5, 0.6, 0.6])


def test_a_planner_without_a_standard_layout_is_not_measured_against_one() -> None:
    simulation = Simulation(load_scenario("k-curve"))
    recorder = Recorder(simulation)
    simulation.step()
    recorder.note()
    figures = measured(simulation, recorder)
    stable = stability_figures(recorder.columns())
    others = set(figures) - set(stable) - {"off_trace"}
    assert {figures[name] for name in others} == {None}


def test_the_least_margins_and_the_most_the_body_leant_are_figures() -> None:
    body = np.zeros((3, 6))
    body[1, 3:5] = 0.03, -0.04
    log = {"body": body, "polygon_margin": np.array([0.3, 0.1, 0.2])}
    log["capture_margin"] = np.array([0.3, -np.inf, 0.2])
    figures = stability_figures(log)
    assert figures["polygon_margin_min"] == 0.1 and figures["capture_margin_min"] is None
    assert figures["tilt_deg"] == pytest.approx(np.degrees(0.05))


def test_the_way_off_a_trace_is_its_largest_and_where_the_trace_crosses_itself_the_nearer_part():
    s = np.arange(629) * 0.01
    eight = SampledPath(0.01, np.sin(s), np.sin(2 * s) / 2, s)
    body = np.zeros((629, 6))
    body[:, 0] = eight.x
    body[:, 1] = eight.y + np.where(np.arange(629) == 315, 0.05, 0.0)
    assert off_trace(eight, body) == pytest.approx(0.05 / np.sqrt(2), rel=0.02)
    assert off_trace(None, body) is None


@pytest.mark.parametrize(("sway", "most"), [(0.0, 1e-3), (0.08, 0.08)])
@pytest.mark.parametrize("body", ["straight", "sway"])
def test_a_body_leaves_its_trace_by_no_more_than_it_may(body, sway, most):
    settings = [f"trace.sway={sway}", "terrain.fraction=0.04", "end={time=30.0}", "seed=3"]
    settings += [f'gait.body="{body}"', "expect={off_trace_max=0.08}"]
    summary = run_scenario(load_scenario("k-curve", settings))
    # a body that sways into its supports is 50 mm beside its reference at most
    assert summary["off_trace"] <= most + 1e-3 + (0.05 if body == "sway" else 0.0)
    assert summary["expect"]["off_trace_max"]["got"] == summary["off_trace"]
