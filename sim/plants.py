"""Plants by name: the only place that names them.

Another plant is one folder and one entry here: anything that is called like ``PlantMaker`` and gives
a ``Plant``. A scenario then asks for it with ``plant = "name"``, and the conformance test in
``tests/sim/test_plant_protocol.py`` takes it up by itself.
"""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version
from typing import Protocol

import numpy as np

from walking_console.planner.protocols import Plant
from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Stance

from .kinematic.plant import KinematicPlant
from .sensor_noise import SensorNoise
from .terrain.ground import Ground

DEFAULT_PLANT = "kinematic"


class PlantMaker(Protocol):
    """Sets a machine down on its ground in a stance. Raises ``ValueError`` where it cannot.

    ``noise`` is what the sensors add, drawn from ``rng``, the only source of chance there is.
    """

    def __call__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: SensorNoise | None = None,
        rng: np.random.Generator | None = None,
    ) -> Plant[Ground]: ...


@dataclass(frozen=True)
class PlantEntry:
    """A plant as it is registered."""

    make: PlantMaker
    # distributions whose version a walk depends on to the last bit
    libraries: tuple[str, ...] = ()


PLANTS: dict[str, PlantEntry] = {
    "kinematic": PlantEntry(KinematicPlant, ("pymunk",)),
}


def plant_entry(name: str) -> PlantEntry:
    """The plant of this name; raises ``ValueError`` that lists those there are."""
    entry = PLANTS.get(name)
    if entry is None:
        raise ValueError(f"unknown plant {name!r:.80}; there are: {', '.join(PLANTS)}")
    return entry


def versions(name: str) -> dict[str, str]:
    """What a walk of this plant depends on to the last bit: Python, numpy, its own libraries."""
    libraries = {library: version(library) for library in plant_entry(name).libraries}
    return {"python": platform.python_version(), "numpy": np.__version__, **libraries}
