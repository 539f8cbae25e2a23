"""The walls between the rooms: planner decides, sim happens, server carries, web shows.

Every module's imports are read from its source (also relative, local and dynamic ones, and those for type checkers only) and held
against one table. Add a row on purpose or not at all.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("planner", "sim", "server", "web")


@dataclass(frozen=True)
class Rule:
    """Who may import whom; a name stands for the module and all below it. The standard library is allowed unless named in `never`."""

    may: frozenset[str]
    never: frozenset[str] = frozenset()   # wins over `may`


def rule(may: str, never: str = "") -> Rule:
    return Rule(frozenset(may.split()), frozenset(never.split()))


# No clock, no sockets, no randomness of its own: seconds come in as ticks, chance as a seeded Generator.
UNREPEATABLE = "asyncio time random datetime secrets uuid socket threading subprocess"
CARRIERS = "fastapi starlette uvicorn websockets pydantic typer click rich anyio numpy mcap"

# A module obeys the row with the longest name that fits it.
TABLE = {
    "planner": rule("planner numpy", f"{UNREPEATABLE} sim server web pymunk viser fastapi"),
    # What the two papers share is below them, and knows neither.
    **{
        f"planner.{shared}": rule("planner numpy", f"{UNREPEATABLE} planner.crab planner.trace planner.walk")
        for shared in ("vocabulary", "machine", "course", "support", "terrain")
    },
    "planner.crab": rule("planner numpy", f"{UNREPEATABLE} planner.trace planner.walk"),
    "planner.trace": rule("planner numpy", f"{UNREPEATABLE} planner.crab planner.walk"),
    "sim": rule(
        "sim planner.vocabulary planner.machine planner.support planner.course numpy pydantic PIL",
        "server web asyncio time random planner.crab planner.trace planner.walk planner.reflex",
    ),
    "sim.contact": rule(
        "sim planner.vocabulary planner.machine planner.support planner.course numpy pymunk",
        "server web asyncio time random planner.crab planner.trace planner.walk planner.reflex",
    ),
    "web": rule(
        "web sim.snapshot planner.vocabulary planner.support planner.machine numpy trimesh",
        "server asyncio fastapi pymunk sim.robot",
    ),
    "web.scene": rule(
        "web sim.snapshot planner.vocabulary planner.support planner.machine numpy trimesh viser",
        "server asyncio fastapi pymunk sim.robot",
    ),
    "server": rule(f"server planner sim web {CARRIERS}"),
    "server.console": rule("server.console planner sim numpy", "web asyncio time viser fastapi"),
    # Drawings of finished walks: the only place that may want matplotlib.
    "server.figures": rule("server planner sim numpy matplotlib", "web asyncio time random fastapi"),
    # The one exception: the bridge that serves viser's stream on our own port lets it open no socket, and so has to know it.
    "server.canvas": rule(f"server web viser {CARRIERS}"),
}

# Libraries that live in one place, so that they can be replaced there.
ONLY_IN = {
    "pymunk": {"sim.contact"},
    "viser": {"web.scene", "server.canvas"},
    "matplotlib": {f"server.figures.{module}" for module in ("ink", "plan", "side", "pages")},  # not what names and walks them
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


def imports(source: str, module: str, known: frozenset[str], is_package: bool = False) -> Iterator[tuple[int, str]]:
    """Line and absolute name of everything the source imports; '?' for a name that only running it would tell."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = origin(node, module, is_package)
            for alias in node.names:
                full = f"{base}.{alias.name}"
                yield node.lineno, (full if full in known else base) or "?"
        elif isinstance(node, ast.Call) and dotted(node.func).rpartition(".")[2] in ("import_module", "__import__"):
            name = node.args[0] if node.args else None
            literal = isinstance(name, ast.Constant) and isinstance(name.value, str) and not name.value.startswith(".")
            yield node.lineno, (name.value if literal else "?")


def own_chance(source: str) -> Iterator[int]:
    """Lines that make random numbers by numpy instead of taking a Generator; naming its type is no chance."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and dotted(node.func).startswith(("np.random.", "numpy.random.")):
            yield node.lineno
        elif isinstance(node, ast.ImportFrom) and node.module == "numpy.random" and [a.name for a in node.names] != ["Generator"]:
            yield node.lineno
        elif isinstance(node, ast.ImportFrom) and node.module == "numpy" and "random" in [a.name for a in node.names]:
            yield node.lineno


def may_import(module: str, target: str) -> bool:
    rule, top = row_for(module), target.partition(".")[0]
    if target == "?" or is_under(target, rule.never) or module not in ONLY_IN.get(top, {module}):
        return False
    return top in sys.stdlib_module_names or is_under(target, rule.may)


def faults(source: str, module: str, known: frozenset[str] = frozenset(), is_package: bool = False) -> list[str]:
    found = [
        f"{module}:{line} may not import {target if target != '?' else 'a name that cannot be read from the source'}"
        for line, target in imports(source, module, known, is_package)
        if not may_import(module, target)
    ]
    if module.partition(".")[0] == "planner":
        found += [f"{module}:{line} makes its own random numbers" for line in own_chance(source)]
    return found


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module_name(path): path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))}
KNOWN = frozenset(FILES)


@pytest.mark.parametrize("module", FILES)
def test_a_module_imports_only_what_its_room_may(module: str) -> None:
    path = FILES[module]
    assert faults(path.read_text(encoding="utf-8"), module, KNOWN, path.name == "__init__.py") == []


WORLD = frozenset(
    """planner planner.machine planner.terrain planner.vocabulary planner.walk planner.reflex planner.crab planner.crab.plan planner.crab.xy
    planner.trace planner.trace.plan sim sim.robot sim.contact sim.snapshot server server.console server.app web web.scene""".split()
)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("planner.walk", "import time"),
        ("planner.walk", "import asyncio as fine"),
        ("planner.walk", "from random import random"),
        ("planner.walk", "import sim.robot"),
        ("planner.walk", "import scipy"),
        ("planner.walk", "def late():\n    from sim import robot"),
        ("planner.walk", "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import viser"),
        ("planner.walk", "try:\n    import pymunk\nexcept ImportError:\n    pass"),
        ("planner.walk", "import importlib\nimportlib.import_module('sim.robot')"),
        ("planner.walk", "from importlib import import_module\nimport_module('sim' + '.robot')"),
        ("planner.walk", "import importlib\nimportlib.import_module('.robot', 'sim')"),
        ("planner.walk", "time = __import__('time')"),
        ("planner.walk", "import builtins\nbuiltins.__import__('random')"),
        ("planner.walk", "from ..sim import robot"),
        ("planner.walk", "import numpy as np\nrng = np.random.default_rng(1)"),
        ("planner.walk", "from numpy.random import default_rng"),
        ("planner.walk", "from numpy import random"),
        ("planner.machine", "from .crab import plan"),
        ("planner.crab.xy", "from planner.trace.plan import plan_step"),
        ("planner.crab.xy", "from planner.trace import plan"),
        ("planner.crab.xy", "from ..trace import plan"),
        ("planner.crab.xy", "from .. import trace"),
        ("planner.crab.xy", "from .. import walk"),
        ("planner.trace.plan", "from ..crab.xy import landing"),
        ("sim.robot", "import asyncio"),
        ("sim.robot", "import planner"),
        ("sim.robot", "from planner import walk"),
        ("sim.robot", "from planner.crab.plan import plan_step"),
        ("sim.robot", "from planner.terrain import TerrainMap"),
        ("sim.robot", "from planner import *"),
        ("sim.robot", "import pymunk"),
        ("sim.contact", "import server.console"),
        ("web.scene", "from sim.robot import Robot"),
        ("web.scene", "from sim import robot"),
        ("web.scene", "import fastapi"),
        ("web.page", "import viser"),
        ("server.app", "import viser"),
        ("server.app", "import viser.transforms as tf"),
        ("server.app", "import pymunk"),
        ("server.app", "import matplotlib"),
        ("server.figures", "import matplotlib"),
        ("server.figures.plan", "import viser"),
        ("server.console", "import time"),
        ("server.console", "from web.scene import Scene"),
        ("server.console", "from . import app"),
        ("server.canvas", "import pymunk"),
    ],
)
def test_the_wall_holds_against(module: str, source: str) -> None:
    assert faults(source, module, WORLD) != []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("planner.walk", "import math\nimport numpy as np\nfrom .crab import plan\nfrom planner.trace.plan import plan_step"),
        ("planner.walk", "import numpy as np\ndef noisy(rng: np.random.Generator) -> float: return rng.normal()"),
        ("planner.walk", "from importlib.resources import files\nimport numpy.typing as npt"),
        ("planner.crab.xy", "from ..machine import Machine\nfrom . import plan\nfrom .. import vocabulary"),
        ("sim.robot", "from planner.vocabulary import Sensing\nfrom .contact import Contact\nimport pydantic"),
        ("sim.robot", "from planner import machine"),
        ("sim.contact", "import pymunk"),
        ("web.scene", "import viser\nfrom sim.snapshot import Snapshot\nfrom planner.support import margin"),
        ("server.console", "from planner.walk import Walk\nfrom sim.robot import Robot\nfrom collections import deque"),
        ("server.app", "import asyncio, time\nimport fastapi\nfrom web.scene import Scene\nfrom .console import Console"),
        ("server.canvas", "import viser\nfrom fastapi import WebSocket"),
    ],
)
def test_the_wall_has_a_door_for(module: str, source: str) -> None:
    assert faults(source, module, WORLD) == []


def test_inside_a_package_one_dot_is_the_package_itself() -> None:
    assert faults("from . import xy", "planner.crab", WORLD, is_package=True) == []
    assert faults("from ..trace import plan", "planner.crab", WORLD, is_package=True) != []


def loaded_after_importing(modules: list[str]) -> set[str]:
    """What a fresh interpreter holds after importing these: catches what no reading of the source can."""
    program = f"import importlib, sys\nfor name in {modules!r}: importlib.import_module(name)\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return {name.partition(".")[0] for name in done.stdout.split()}


def test_the_planner_runs_with_nothing_but_numpy() -> None:
    loaded = loaded_after_importing([m for m in FILES if m.partition(".")[0] == "planner"])
    assert loaded.isdisjoint({"sim", "server", "web", "pymunk", "viser", "fastapi", "pydantic", "asyncio"})


def test_the_console_runs_without_any_server() -> None:
    loaded = loaded_after_importing([m for m in ("server", "server.console") if m in FILES])
    assert loaded.isdisjoint({"web", "viser", "fastapi", "starlette", "uvicorn", "websockets"})
