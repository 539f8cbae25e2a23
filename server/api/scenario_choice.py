"""The scenario that a body names or holds, checked, and its world."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from walking_console.planner import registry
from walking_console.planner.robot.model import MachineError, load_machine, machine_names
from walking_console.planner.robot.toml_files import names_toml_file
from walking_console.sim.runs.sweep.grid import sweep_of
from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import (
    load_scenario,
    scenario_from,
    scenario_names,
    with_settings,
)
from walking_console.sim.terrain.ground import GroundError
from walking_console.sim.world import World, prepare

from ..schemas import RunBody, ScenarioBody, SweepBody
from ..sweep_jobs import SweepOrder
from ..uploads import Uploads
from .errors import HTTPProblem

DETAIL_MAX = 4000  # letters of all faults together
SWEEP_RUNS_MAX = 100_000
COMBINATIONS_MAX = 1000
SETTINGS_NEED_A_NAME = "settings change a scenario by name; put them into the inline one"


def chosen_scenario(body: ScenarioBody, uploads: Uploads) -> Scenario:
    """The scenario a body names or holds; raises ``HTTPProblem``. Over HTTP only files that were
    uploaded may be named.
    """
    settings = body.settings if isinstance(body, RunBody) else []
    _refuse_unknown_robot(body.robot)
    try:
        data = _shipped(body, settings) if body.name is not None else _inline(body, settings)
        replaced = {"robot": body.robot, "mode": body.mode, "plant": body.plant}
        data |= {key: value for key, value in replaced.items() if value is not None}
        if body.body_way is not None and isinstance(data.get("gait", {}), dict):
            data["gait"] = {**data.get("gait", {}), "body": body.body_way}
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


def _refuse_unknown_robot(name: str | None) -> None:
    known = machine_names()
    if name is not None and name not in known and not names_toml_file(name):
        there_are = f"unknown robot {name!r:.80}; there are: {', '.join(known)}"
        raise HTTPProblem(422, there_are, field="robot", value=name)


def _base_of(data: dict[str, Any], uploads: Uploads) -> Path | None:
    """The folder of uploads where a scenario names files of it; None where it names none. Raises
    ``ScenarioError`` for any other file.
    """
    files = _files_named(data)
    for name in files:
        if not uploads.holds(name):
            kept = ", ".join(uploads.names()) or "none"
            raise ScenarioError(
                "a scenario that is not a file itself cannot name files (terrain.file, robot, "
                f"drive) but those that were sent to PUT /api/v1/uploads/NAME: {kept}; got "
                f"{name!r:.80}"
            )
    return uploads.folder if files else None


def _files_named(data: Mapping[str, Any]) -> list[str]:
    terrain = data.get("terrain")
    robot = data.get("robot")
    named = [terrain.get("file")] if isinstance(terrain, dict) else []
    named.append(data.get("drive"))  # a name where it is no timeline
    if isinstance(robot, str) and names_toml_file(robot):
        named.append(robot)
    return [name for name in named if isinstance(name, str)]


def sweep_order(body: SweepBody, uploads: Uploads) -> SweepOrder:
    """The sweep a body asks for, every combination of its settings checked: slow. Raises
    ``HTTPProblem``.
    """
    name = body.name or "inline"
    try:
        sweep = sweep_of(name, body.settings, body.seeds)
    except ScenarioError as error:
        raise HTTPProblem(422, str(error), field="settings", value=body.settings) from None
    combinations = sweep.combinations
    for limit, got in ((SWEEP_RUNS_MAX, len(sweep)), (COMBINATIONS_MAX, len(combinations))):
        if got > limit:
            too_many = f"a sweep over HTTP has at most {COMBINATIONS_MAX} combinations and "
            too_many += f"{SWEEP_RUNS_MAX} runs"
            raise HTTPProblem(422, too_many, field="settings", value=got, limit=limit)
    files = set(_files_named(body.scenario or {}))
    for values in combinations:
        _check_combination(body, sweep.settings(values), uploads)
    found = tuple(uploads.folder / file for file in sorted(files))
    return SweepOrder(name, body.scenario, tuple(body.settings), body.seeds, body.keep, found)


def _check_combination(body: SweepBody, settings: list[str], uploads: Uploads) -> None:
    """One scenario of a sweep, as a run would have it; its settings may name no files."""
    if body.scenario is None:
        chosen_scenario(RunBody(name=body.name, settings=settings), uploads)
        return
    try:
        changed = with_settings(body.scenario, settings)
    except ScenarioError as error:
        raise HTTPProblem(422, str(error), field="settings", value=settings) from None
    if _files_named(changed) != _files_named(body.scenario):
        no_files = "settings of a sweep over HTTP cannot name files"
        raise HTTPProblem(422, no_files, field="settings", value=settings)
    chosen_scenario(ScenarioBody(scenario=changed), uploads)


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
