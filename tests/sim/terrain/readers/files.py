"""Height files for the tests of what reads them."""

from pathlib import Path
from typing import Any

import numpy as np

from walking_console import load_machine, load_scenario
from walking_console.sim.terrain.generators import FileTerrain
from walking_console.sim.terrain.ground import Ground, make_ground
from walking_console.sim.world import prepare

FIXTURES = Path(__file__).parents[3] / "fixtures"
TITAN = load_machine("titan3")
HILL = np.add.outer(np.arange(12) * 0.01, np.arange(16) * 0.002)  # first row lowest


def ground(path: Path, **keys: Any) -> Ground:
    terrain = FileTerrain(kind="file", file=path.name, **keys)
    return make_ground(terrain, TITAN, (0.0, 0.0, 0.0), 1, base=path.parent)


def of_fixture(name: str, *settings: str, scenario: str = "s.toml") -> Ground:
    return prepare(load_scenario(str(FIXTURES / name / scenario), settings)).ground
