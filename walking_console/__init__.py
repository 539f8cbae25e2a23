"""Statically stable walking: planners of two classic gait papers, a simulated machine, and a
console to drive it.

These names are the library; what they are made of lives in ``walking_console.planner``, ``.sim``,
``.server`` and ``.web``. Lengths are metres, angles radians, times seconds. Body axes are x ahead,
y left, z up. Legs are numbered from 0 in code and from 1 in files and on screens, counter-clockwise
from front-left.
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from walking_console.planner.calls import StepPlanner
    from walking_console.planner.protocols import Planner, Plant
    from walking_console.planner.registry import register_planner
    from walking_console.planner.robot.model import load_machine
    from walking_console.planner.terrain.map import TerrainMap
    from walking_console.planner.types import Blocked, Command, Stance, StepPlan
    from walking_console.sim.runs.reader import open_run
    from walking_console.sim.runs.runner import run_scenario
    from walking_console.sim.scenario_files import load_scenario
    from walking_console.sim.simulation import Simulation
    from walking_console.sim.snapshot import Snapshot

__all__ = [
    "Blocked",
    "Command",
    "Planner",
    "Plant",
    "Simulation",
    "Snapshot",
    "Stance",
    "StepPlan",
    "StepPlanner",
    "TerrainMap",
    "load_machine",
    "load_scenario",
    "open_run",
    "register_planner",
    "run_scenario",
]

# Imported when first asked for (PEP 562): ``import walking_console`` is quick, and whoever plans
# only never waits for the simulation.
_HOMES: dict[str, Callable[[], ModuleType]] = {
    "Blocked": lambda: import_module("walking_console.planner.types"),
    "Command": lambda: import_module("walking_console.planner.types"),
    "Planner": lambda: import_module("walking_console.planner.protocols"),
    "Plant": lambda: import_module("walking_console.planner.protocols"),
    "Simulation": lambda: import_module("walking_console.sim.simulation"),
    "Snapshot": lambda: import_module("walking_console.sim.snapshot"),
    "Stance": lambda: import_module("walking_console.planner.types"),
    "StepPlan": lambda: import_module("walking_console.planner.types"),
    "StepPlanner": lambda: import_module("walking_console.planner.calls"),
    "TerrainMap": lambda: import_module("walking_console.planner.terrain.map"),
    "load_machine": lambda: import_module("walking_console.planner.robot.model"),
    "load_scenario": lambda: import_module("walking_console.sim.scenario_files"),
    "open_run": lambda: import_module("walking_console.sim.runs.reader"),
    "register_planner": lambda: import_module("walking_console.planner.registry"),
    "run_scenario": lambda: import_module("walking_console.sim.runs.runner"),
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(_HOMES[name](), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
