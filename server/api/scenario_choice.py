"""The scenario that a body names or holds, checked, and its world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from walking_console.planner import registry
from walking_console.planner.robot.model import MachineError, load_machine
from walking_console.planner.robot.toml_files import names_toml_file
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_from, scenario_names
from walking_console.sim.terrain.ground import GroundError
from walking_console.sim.world import World, prepare

from ..schemas import RunBody, ScenarioBody
from ..uploads import Uploads
from .errors import HTTPProblem

DETAIL_MAX = 4000  # letters of all faults together
SETTINGS_NEED_A_NAME = "settings change a scenario by name; put them into the inline one"


def chosen_scenario(body: ScenarioBody, uploads: Uploads) -> Scenario:
    """The scenario a body names or holds; raises ``HTTPProblem``. Over HTTP only files that were
    uploaded may be named.
    """
    settings = body.settings if isinstance(body, RunBody) else []
    try:
        data = _shipped(body, settings) if body.name is not None else _inline(body, settings)
        replaced = {"robot": body.robot, "mode": body.mode}
        data |= {key: value for key, value in replaced.items() if value is not None}
        if body.free_stick:
            data.pop("trace", None)
        if body.robot is not None:
            _let_planner_follow(data)
        scenario = scenario_from(data, _base_of(data, uploads))
        scenario.machine()
    except (ScenarioError, MachineError) as error:
        field = "name" if body.name else "scenario"
        raise HTTPProblem(
            422,
            "; ".join(error.faults)[:DETAIL_MAX],
            field=field,
            value=body.name or "inline",
            faults=error.faults,
        ) from None
    return scenario


def _base_of(data: dict[str, Any], uploads: Uploads) -> Path | None:
    """The folder of uploads where a scenario names files of it; None where it names none. Raises
    ``ScenarioError`` for any other file.
    """
    terrain = data.get("terrain")
    robot = data.get("robot")
    named = [terrain.get("file")] if isinstance(terrain, dict) else []
    named.append(data.get("drive"))  # a name where it is no timeline
    if isinstance(robot, str) and names_toml_file(robot):
        named.append(robot)
    files = [name for name in named if isinstance(name, str)]
    for name in files:
        if not uploads.holds(name):
            kept = ", ".join(uploads.names()) or "none"
            raise ScenarioError(
                "a scenario that is not a file itself cannot name files (terrain.file, robot, "
                f"drive) but those that were sent to PUT /api/v1/uploads/NAME: {kept}; got "
                f"{name!r:.80}"
            )
    return uploads.folder if files else None


def _let_planner_follow(data: dict[str, Any]) -> None:
    """Another robot may have more legs than the scenario's planner walks with: take the first that
    does, from the standard posture. Raises ``MachineError``.
    """
    legs = len(load_machine(data["robot"]).legs)
    start = data.get("start", {})
    if len(start.get("feet") or [None] * legs) != legs:
        del start["feet"]
    if _walks(data.get("planner", registry.DEFAULT_PLANNER), legs):
        return
    data["planner"] = next(name for name in registry.planner_names() if _walks(name, legs))
    data.pop("mode", None)
    data.pop("attitude", None)


def _walks(planner: str, legs: int) -> bool:
    counts = registry.capabilities(planner).leg_counts
    return not counts or legs in counts


def _shipped(body: ScenarioBody, settings: list[str]) -> dict[str, Any]:
    """A scenario that came with the program, with settings and a seed of the body's own."""
    assert body.name is not None
    names = scenario_names()
    if body.name not in names:
        raise ScenarioError(f"unknown scenario {body.name!r}; there are: {', '.join(names)}")
    return load_scenario(body.name, settings, body.seed).as_data()


def _inline(body: ScenarioBody, settings: list[str]) -> dict[str, Any]:
    """The scenario a body holds itself."""
    if settings:
        raise HTTPProblem(422, SETTINGS_NEED_A_NAME, field="settings", value=settings)
    seed = {} if body.seed is None else {"seed": body.seed}
    return {"name": "inline", **(body.scenario or {})} | seed


def world_of(body: ScenarioBody, uploads: Uploads) -> World:
    """The world of the scenario a body names or holds: slow; raises ``HTTPProblem``."""
    scenario = chosen_scenario(body, uploads)
    try:
        return prepare(scenario)
    except (ScenarioError, MachineError, GroundError) as error:
        raise HTTPProblem(422, str(error), field="scenario", value=scenario.name) from None
