"""Plants by name: the only place that names them.

Another plant is one folder and one entry here: anything that is called like ``PlantMaker`` and
gives a ``Plant``. A scenario then asks for it with ``plant = "name"``, and the conformance test in
``tests/sim/test_plant_protocol.py`` takes it up by itself.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Protocol

import numpy as np

from walking_console.planner.protocols import Plant
from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Stance

from .kinematic.plant import KinematicPlant
from .mujoco.settings import Physics
from .sensor_noise import SensorNoise
from .terrain.ground import Ground

DEFAULT_PLANT = "kinematic"


class PlantMissing(ValueError):
    """A plant that cannot be had here; one line says what to install."""


class PlantMaker(Protocol):
    """Sets a machine down on its ground in a stance. Raises ``ValueError`` where it cannot.

    ``noise`` is what the sensors add, drawn from ``rng``, the only source of chance there is.
    ``physics`` is what the machine truly is, for plants with bodies that have mass.
    """

    def __call__(
        self,
        machine: Machine,
        ground: Ground,
        stance: Stance,
        *,
        noise: SensorNoise | None = None,
        rng: np.random.Generator | None = None,
        physics: Physics | None = None,
    ) -> Plant[Ground]: ...


@dataclass(frozen=True)
class PlantEntry:
    """A plant as it is registered."""

    make: PlantMaker
    # raises ``PlantMissing`` where what it is made with is not installed
    check: Callable[[], None] = lambda: None
    # distributions whose version a walk depends on to the last bit; "a|b": either provides it
    libraries: tuple[str, ...] = ()


def _physics(
    machine: Machine,
    ground: Ground,
    stance: Stance,
    *,
    noise: SensorNoise | None = None,
    rng: np.random.Generator | None = None,
    physics: Physics | None = None,
) -> Plant[Ground]:
    """Imported when first asked for: a bare install does without MuJoCo."""
    from .mujoco.plant import PhysicsPlant

    return PhysicsPlant(machine, ground, stance, noise=noise, rng=rng, physics=physics)


def _check_physics() -> None:
    try:
        import_module("walking_console.sim.mujoco.library")
    except ImportError as error:
        raise PlantMissing(str(error)) from None


PLANTS: dict[str, PlantEntry] = {
    "kinematic": PlantEntry(KinematicPlant, libraries=("pymunk",)),
    "physics": PlantEntry(_physics, _check_physics, ("mujoco-core|mujoco",)),
}


def plant_entry(name: str) -> PlantEntry:
    """The plant of this name; raises ``ValueError`` that lists those there are."""
    entry = PLANTS.get(name)
    if entry is None:
        raise ValueError(f"unknown plant {name!r:.80}; there are: {', '.join(PLANTS)}")
    return entry


def versions(name: str) -> dict[str, str]:
    """What a walk of this plant depends on to the last bit: Python, numpy, its own libraries."""
    libraries = dict(_installed(library) for library in plant_entry(name).libraries)
    return {"python": platform.python_version(), "numpy": np.__version__, **libraries}


def _installed(library: str) -> tuple[str, str]:
    """The distribution that provides a library, and its version."""
    *others, last = library.split("|")
    for name in others:
        try:
            return name, version(name)
        except PackageNotFoundError:
            continue
    return last, version(last)
