"""The scenario that a body names or holds, checked, and its world."""

from __future__ import annotations

from typing import Any

from walking_console.planner.robot.model import MachineError, load_machine
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_from, scenario_names
from walking_console.sim.terrain.ground import GroundError
from walking_console.sim.world import World, prepare

from ..schemas import RunBody, ScenarioBody
from .errors import HTTPProblem

SETTINGS_NEED_A_NAME = "settings change a scenario by name; put them into the inline one"


def chosen_scenario(body: ScenarioBody) -> Scenario:
    """The scenario a body names or holds; raises ``HTTPProblem``. Over HTTP no file may be
    named.
    """
    settings = body.settings if isinstance(body, RunBody) else []
    try:
        data = _shipped(body, settings) if body.name is not None else _inline(body, settings)
        replaced = {"robot": body.robot, "mode": body.mode}
        data |= {key: value for key, value in replaced.items() if value is not None}
        scenario = scenario_from(data, None)
        load_machine(scenario.robot)
    except (ScenarioError, MachineError) as error:
        field = "name" if body.name else "scenario"
        raise HTTPProblem(422, str(error), field=field, value=body.name or "inline") from None
    return scenario


def _shipped(body: ScenarioBody, settings: list[str]) -> dict[str, Any]:
    """A scenario that came with the program, with settings and a seed of the body's own."""
    assert body.name is not None
    names = scenario_names()
    if body.name not in names:
        raise ScenarioError(f"unknown scenario {body.name!r}; there are: {', '.join(names)}")
    return load_scenario(body.name, settings, body.seed).as_data()


def _inline(body: ScenarioBody, settings: list[str]) -> dict[str, Any]:
    """The scenario a body holds itself."""
    given = scenario_from({"name": "inline", **(body.scenario or {})}, None)
    if settings:
        raise HTTPProblem(422, SETTINGS_NEED_A_NAME, field="settings", value=settings)
    seed = {} if body.seed is None else {"seed": body.seed}
    return given.as_data() | seed


def world_of(body: ScenarioBody) -> World:
    """The world of the scenario a body names or holds: slow; raises ``HTTPProblem``."""
    scenario = chosen_scenario(body)
    try:
        return prepare(scenario)
    except (ScenarioError, MachineError, GroundError) as error:
        raise HTTPProblem(422, str(error), field="scenario", value=scenario.name) from None
