"""The walls between the rooms: planner decides, sim happens, server carries, web shows.

Every module's imports are read from its source (also relative, local and dynamic ones, and those
for type checkers only) and held against one table. Add a row on purpose or not at all.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 900.0  # s a child may take on a machine that has much else to do
ROOMS = ("planner", "sim", "server", "web")


@dataclass(frozen=True)
class Rule:
    """Who may import whom; a name stands for the module and all below it. The standard library is
    allowed unless named in `never`.
    """

    may: frozenset[str]
    never: frozenset[str] = frozenset()  # wins over `may`


def rule(may: str, never: str = "") -> Rule:
    return Rule(frozenset(may.split()), frozenset(never.split()))


# No clock, no sockets, no randomness of its own: seconds come in as ticks, chance as a seeded
# Generator.
UNREPEATABLE = "asyncio time random datetime secrets uuid socket threading subprocess"
CARRIERS = "fastapi starlette uvicorn websockets pydantic typer click rich anyio numpy mcap segno"
OUTSIDE = (
    "walking_console.sim walking_console.server walking_console.web pymunk mujoco viser fastapi"
)


def within(room: str, parts: str) -> str:
    """Module names of parts of a room, in full."""
    return " ".join(f"walking_console.{room}.{part}" for part in parts.split())


def planner_row(may: str, never: str = "") -> Rule:
    """A row of the planner: numpy and the named parts of it, nothing that is not repeatable,
    nothing outside.
    """
    return rule(
        f"{within('planner', may)} numpy", f"{UNREPEATABLE} {OUTSIDE} {within('planner', never)}"
    )


# The planner from the ground up: each folder may import those before it.
FLOORS = (
    "lazy types geometry config robot terrain protocols stability simplex statics search "
    "decision_log motion initial_stance navigation control"
)


def below(folder: str) -> str:
    names = FLOORS.split()
    return " ".join(names[: names.index(folder) + 1])


SIM_SEES = within(
    "planner",
    "types protocols config geometry robot terrain stability statics registry initial_stance"
    " control",
)
WEB_SEES = (
    f"walking_console.sim.snapshot {within('planner', 'types config stability robot geometry')}"
)

# A module obeys the row with the longest name that fits it.
TABLE = {
    "walking_console": rule("walking_console"),
    "walking_console.planner": planner_row(below("control"), "crab trace"),
    **{f"walking_console.planner.{name}": planner_row(below(name)) for name in FLOORS.split()},
    # Whether a leg meets the ground needs both.
    "walking_console.planner.robot.collision": planner_row(below("terrain")),
    # The only module of the planner's root that knows both papers.
    "walking_console.planner.registry": planner_row(f"{below('control')} crab trace"),
    "walking_console.planner.calls": planner_row(f"{below('control')} registry"),
    "walking_console.planner.crab": planner_row(f"{below('navigation')} crab", "trace control"),
    "walking_console.planner.trace": planner_row(f"{below('navigation')} trace", "crab control"),
    "walking_console.sim": rule(
        f"walking_console.sim {SIM_SEES} numpy pydantic pydantic_core PIL",
        "walking_console.server walking_console.web asyncio random",
    ),
    # Formats of other people are read by other people's libraries.
    "walking_console.sim.terrain.readers": rule(
        f"walking_console.sim {SIM_SEES} numpy PIL png tifffile trimesh",
        "walking_console.server walking_console.web asyncio random",
    ),
    # Tables for notebooks, and clusters: either only where it is installed.
    "walking_console.sim.runs.sweep": rule(
        f"walking_console.sim {SIM_SEES} numpy pyarrow distributed",
        "walking_console.server walking_console.web asyncio random",
    ),
    "walking_console.sim.kinematic.contact": rule(
        f"walking_console.sim {SIM_SEES} numpy pymunk",
        "walking_console.server walking_console.web asyncio random",
    ),
    "walking_console.sim.mujoco": rule(
        f"walking_console.sim {SIM_SEES} numpy mujoco",
        "walking_console.server walking_console.web asyncio random",
    ),
    "walking_console.web": rule(
        f"walking_console.web {WEB_SEES} numpy", "walking_console.server asyncio fastapi pymunk"
    ),
    "walking_console.web.scene": rule(
        f"walking_console.web {WEB_SEES} numpy viser",
        "walking_console.server asyncio fastapi pymunk",
    ),
    # Drawings of finished walks: the only place that may want matplotlib.
    "walking_console.web.figures": rule(
        "walking_console.web.figures walking_console.web.scene.palette walking_console.sim "
        f"walking_console.planner {WEB_SEES} numpy matplotlib",
        "walking_console.server asyncio time random fastapi",
    ),
    "walking_console.server": rule(f"walking_console {CARRIERS}"),
    # The one exception: the bridge that serves viser's stream on our own port lets it open no
    # socket, and so has to know it.
    "walking_console.server.viser_bridge": rule(
        f"walking_console.server walking_console.web viser {CARRIERS}"
    ),
    # And the recording that a replay page is made of.
    "walking_console.server.viser_recording": rule("viser msgspec zstandard"),
    # And what leaves snapshots for the child that draws it.
    "walking_console.server.snapshot_files": rule("walking_console.sim msgspec numpy"),
}

# Libraries that live in one place, so that they can be replaced there.
ONLY_IN = {
    "pymunk": ("walking_console.sim.kinematic.contact",),
    "mujoco": ("walking_console.sim.mujoco",),
    "viser": (
        "walking_console.web.scene",
        "walking_console.server.viser_bridge",
        "walking_console.server.viser_recording",
    ),
    "png": ("walking_console.sim.terrain.readers",),
    "tifffile": ("walking_console.sim.terrain.readers",),
    "trimesh": ("walking_console.sim.terrain.readers",),
    "matplotlib": ("walking_console.web.figures",),
}


def is_under(name: str, roots: frozenset[str]) -> bool:
    return any(name == root or name.startswith(root + ".") for root in roots)


def row_for(module: str) -> Rule:
    return TABLE[max((row for row in TABLE if is_under(module, frozenset({row}))), key=len)]


def dotted(node: ast.expr) -> str:
    """`a.b.c` for an attribute chain on a plain name, else the empty string."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and (left := dotted(node.value)):
        return f"{left}.{node.attr}"
    return ""


def origin(node: ast.ImportFrom, module: str, is_package: bool) -> str:
    """The absolute module named after `from`; '' where the dots lead out of the room."""
    if not node.level:
        return node.module or ""
    parts = module.split(".")
    parts = parts[: len(parts) - node.level + is_package]
    return ".".join(parts + ([node.module] if node.module else [])) if parts else ""


@lru_cache(maxsize=1)
def nodes_of(source: str) -> list[ast.AST]:
    """Everything in a source, that of the module looked at last read once."""
    return list(ast.walk(ast.parse(source)))


def imports(
    source: str, module: str, known: frozenset[str], is_package: bool = False
) -> Iterator[tuple[int, str]]:
    """Line and absolute name of everything the source imports; '?' for a name that only running it
    would tell.
    """
    for node in nodes_of(source):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = origin(node, module, is_package)
            for alias in node.names:
                full = f"{base}.{alias.name}"
                yield node.lineno, (full if full in known else base) or "?"
        elif isinstance(node, ast.Call) and dotted(node.func).rpartition(".")[2] in (
            "import_module",
            "__import__",
        ):
            name = node.args[0] if node.args else None
            literal = (
                isinstance(name, ast.Constant)
                and isinstance(name.value, str)
                and not name.value.startswith(".")
            )
            yield node.lineno, (name.value if literal else "?")


def own_chance(source: str) -> Iterator[int]:
    """Lines that make random numbers by numpy instead of taking a Generator; naming its type is no
    chance.
    """
    for node in nodes_of(source):
        if isinstance(node, ast.Call) and dotted(node.func).startswith(
            ("np.random.", "numpy.random.")
        ):
            yield node.lineno
        elif (
            isinstance(node, ast.ImportFrom)
            and node.module == "numpy.random"
            and [a.name for a in node.names] != ["Generator"]
        ):
            yield node.lineno
        elif (
            isinstance(node, ast.ImportFrom)
            and node.module == "numpy"
            and "random" in [a.name for a in node.names]
        ):
            yield node.lineno


def may_import(module: str, target: str) -> bool:
    rule, top = row_for(module), target.partition(".")[0]
    if target == "?" or is_under(target, rule.never):
        return False
    if top in ONLY_IN and not is_under(module, frozenset(ONLY_IN[top])):
        return False
    return top in sys.stdlib_module_names or is_under(target, rule.may)


def faults(
    source: str, module: str, known: frozenset[str] = frozenset(), is_package: bool = False
) -> list[str]:
    found = [
        f"{module}:{line} may not import"
        f" {target if target != '?' else 'a name that cannot be read from the source'}"
        for line, target in imports(source, module, known, is_package)
        if not may_import(module, target)
    ]
    if is_under(module, frozenset({"walking_console.planner"})):
        found += [f"{module}:{line} makes its own random numbers" for line in own_chance(source)]
    return found


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    names = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join(names if names[0] == "walking_console" else ("walking_console", *names))


FILES = {
    module_name(path): path
    for room in (*ROOMS, "walking_console")
    for path in sorted((ROOT / room).rglob("*.py"))
}
KNOWN = frozenset(FILES)


@pytest.mark.parametrize("module", FILES)
def test_a_module_imports_only_what_its_room_may(module: str) -> None:
    path = FILES[module]
    source = path.read_text(encoding="utf-8")
    assert faults(source, module, KNOWN, path.name == "__init__.py") == []


WORLD = frozenset(
    f"walking_console.{name}"
    for name in """planner planner.types planner.stability planner.registry planner.terrain
    planner.terrain.map planner.robot planner.robot.model planner.motion planner.motion.timing
    planner.control planner.control.supervisor planner.crab planner.crab.gait planner.crab.planner
    planner.trace planner.trace.planner sim sim.simulation sim.snapshot sim.kinematic
    sim.kinematic.plant sim.kinematic.contact server server.api server.api.app web web.scene
    web.figures""".split()
) | {"walking_console"}


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("planner.control.supervisor", "import time"),
        ("planner.control.supervisor", "import asyncio as fine"),
        ("planner.control.supervisor", "from random import random"),
        ("planner.control.supervisor", "import walking_console.sim.simulation"),
        ("planner.control.supervisor", "import scipy"),
        ("planner.control.supervisor", "def late():\n    from walking_console.sim import snapshot"),
        (
            "planner.control.supervisor",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import viser",
        ),
        (
            "planner.control.supervisor",
            "try:\n    import pymunk\nexcept ImportError:\n    pass",
        ),
        (
            "planner.control.supervisor",
            "import importlib\nimportlib.import_module('walking_console.sim')",
        ),
        (
            "planner.control.supervisor",
            "from importlib import import_module\nimport_module('walking_console' + '.sim')",
        ),
        ("planner.control.supervisor", "import importlib\nimportlib.import_module('.x', 'sim')"),
        ("planner.control.supervisor", "time = __import__('time')"),
        ("planner.control.supervisor", "import builtins\nbuiltins.__import__('random')"),
        ("planner.control.supervisor", "from ...sim import simulation"),
        ("planner.control.supervisor", "import numpy as np\nrng = np.random.default_rng(1)"),
        ("planner.control.supervisor", "from numpy.random import default_rng"),
        ("planner.control.supervisor", "from numpy import random"),
        ("planner.control.supervisor", "from ..crab import planner"),
        ("planner.control.supervisor", "from .. import registry"),
        ("planner.stability", "from .crab import planner"),
        ("planner.terrain.map", "from ..motion.timing import timing"),
        ("planner.robot.model", "from ..terrain.map import TerrainMap"),
        ("planner.crab.gait", "from walking_console.planner.trace.planner import plan_step"),
        ("planner.crab.gait", "from walking_console.planner.trace import planner"),
        ("planner.crab.gait", "from ..trace import planner"),
        ("planner.crab.gait", "from .. import trace"),
        ("planner.crab.gait", "from ..control import supervisor"),
        ("planner.trace.planner", "from ..crab.gait import landing"),
        ("sim.kinematic.plant", "import asyncio"),
        ("sim.kinematic.plant", "import walking_console.planner"),
        ("sim.kinematic.plant", "from walking_console.planner.crab.planner import plan_step"),
        ("sim.kinematic.plant", "from walking_console.planner import *"),
        ("sim.kinematic.plant", "import pymunk"),
        ("sim.kinematic.plant", "import mujoco"),
        ("sim.kinematic.contact", "import walking_console.server.api"),
        ("web.scene", "from walking_console.sim.kinematic.plant import Robot"),
        ("web.scene", "from walking_console.sim import simulation"),
        ("web.scene", "import fastapi"),
        ("web.page", "import viser"),
        ("server.api.app", "import viser"),
        ("server.api.app", "import viser.transforms as tf"),
        ("server.api.app", "import pymunk"),
        ("server.api.app", "import matplotlib"),
        ("sim.simulation", "import asyncio"),
        ("sim.simulation", "from walking_console.web.scene import Scene"),
        ("server.viser_bridge", "import pymunk"),
    ],
)
def test_the_wall_holds_against(module: str, source: str) -> None:
    assert faults(source, f"walking_console.{module}", WORLD) != []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (
            "planner.registry",
            (
                "import math\nimport numpy\nfrom .crab import planner\nfrom .trace.planner import"
                " plan_step"
            ),
        ),
        (
            "planner.control.supervisor",
            "import numpy as np\ndef noisy(rng: np.random.Generator) -> float: return rng.normal()",
        ),
        (
            "planner.control.supervisor",
            "from importlib.resources import files\nimport numpy.typing as npt",
        ),
        (
            "planner.crab.gait",
            "from ..robot.model import Machine\nfrom . import planner\nfrom .. import types",
        ),
        (
            "sim.kinematic.plant",
            (
                "from walking_console.planner.types import Sensing\nfrom .contact import"
                " Contact\nimport pydantic"
            ),
        ),
        ("sim.kinematic.plant", "from walking_console.planner.robot import model"),
        ("sim.kinematic.contact", "import pymunk"),
        (
            "web.scene",
            (
                "import viser\nfrom walking_console.sim.snapshot import Snapshot\nfrom"
                " walking_console.planner.stability import margin"
            ),
        ),
        (
            "sim.simulation",
            (
                "from walking_console.planner.control.supervisor import GaitSupervisor\nfrom"
                " collections import deque"
            ),
        ),
        (
            "server.api.app",
            "import asyncio, time\nimport fastapi\nfrom walking_console.web.scene import Scene",
        ),
        ("server.viser_bridge", "import viser\nfrom fastapi import WebSocket"),
        ("web.figures.style", "import matplotlib"),
    ],
)
def test_the_wall_has_a_door_for(module: str, source: str) -> None:
    assert faults(source, f"walking_console.{module}", WORLD) == []


def test_inside_a_package_one_dot_is_the_package_itself() -> None:
    crab = "walking_console.planner.crab"
    assert faults("from . import gait", crab, WORLD, is_package=True) == []
    assert faults("from ..trace import planner", crab, WORLD, is_package=True) != []


def loaded_after_importing(modules: list[str]) -> set[str]:
    """What a fresh interpreter holds after importing these: catches what no reading of the source
    can.
    """
    program = (
        f"import importlib, sys\nfor name in {modules!r}:"
        " importlib.import_module(name)\nprint(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


HEAVY = {"pymunk", "viser", "fastapi", "pydantic", "asyncio", "starlette", "uvicorn", "websockets"}


def test_the_planner_runs_with_nothing_but_numpy() -> None:
    loaded = loaded_after_importing([m for m in FILES if m.startswith("walking_console.planner")])
    rooms = {f"walking_console.{room}" for room in ("sim", "server", "web")}
    assert loaded.isdisjoint(HEAVY | rooms)


def test_the_simulation_runs_without_any_server() -> None:
    loaded = loaded_after_importing(["walking_console.sim.simulation"])
    rooms = {"walking_console.server", "walking_console.web"}
    assert loaded.isdisjoint(HEAVY - {"pymunk", "pydantic", "asyncio"} | rooms)
