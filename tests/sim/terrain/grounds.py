"""Grounds as scenarios name them, for the tests of the terrain."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from walking_console.planner.robot.model import load_machine
from walking_console.sim.terrain.generators import (
    KINDS,
    AnyTerrain,
)
from walking_console.sim.terrain.ground import Ground, make_ground

TITAN = load_machine("titan3")


GENERATED = [kind for kind in KINDS if kind not in ("file", "heights")]


SMOOTH = ("slope", "rough", "wave", "dem")


FEET = [(0.5, 0.475), (-0.4, 0.475), (-0.6, -0.475), (0.3, -0.475)]


START = (0.0, 0.0, 0.0)


def terrain(kind: str, **parameters: Any) -> Any:
    return TypeAdapter(AnyTerrain).validate_python({"kind": kind, **parameters})


def ground(
    kind: str,
    *,
    span: Any = 0.0,
    seed: int = 1,
    stand: Any = (),
    start: Any = START,
    **parameters: Any,
) -> Ground:
    return make_ground(terrain(kind, **parameters), TITAN, start, seed, span, None, stand)


def from_file(path: Path, **parameters: Any) -> Ground:
    return make_ground(terrain("file", file=path.name, **parameters), TITAN, base=path.parent)


def _matplotlib_sample() -> Path:
    cbook = pytest.importorskip("matplotlib.cbook")
    return Path(cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False))


def hills(shape: tuple[int, int] = (40, 60)) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(1).uniform(-0.1, 0.1, shape)


class Canary:
    """Unpickling this would show."""

    sang = False

    def __reduce__(self) -> Any:
        return setattr, (Canary, "sang", True)
