"""What a walker is: legs, reach boxes, leg chains, speed limits, masses. Shipped robots are data
(``descriptions/*.toml``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from ..geometry.paths import Box
from ..geometry.transforms import left_fold_sum
from ..types import Gait
from .card import (
    admitted_number,
    admitted_triple,
    chain_data,
    chain_from,
    check_masses,
    masses_data,
    masses_from,
    numbers,
    shown,
    unknown_keys,
    word,
)
from .card_keys import (
    LEG_KEYS,
    LENGTH_MAX,
    NUMBER,
    ROBOT_KEYS,
    TEXT,
    TRIPLE,
    of_shape,
)
from .card_keys import LEGS_MAX as LEGS_MAX
from .card_keys import LEGS_MIN as LEGS_MIN
from .chains import Drives, JointSpan, LegChain, Masses, slides_chain
from .quadrants import mirrored_part
from .toml_files import TomlFileError, is_file, names_toml_file, parse_toml, read_toml
from .workspace import fitted_box, out_of_reach

GRAVITY = 9.81  # m/s²
# of the mass, what all legs weigh together where the card does not say: an estimate
LEGS_SHARE = 0.12
# of a leg's mass, in hip link, upper and lower; of slides all goes with the foot
LINK_SHARES = (0.25, 0.45, 0.30)
CRAB_LEGS = 4
LEAST_BOX = 0.02  # m; a box the crab planner cannot take a step in
# m, of a leg's reach, mean of length and width: what lengths in metres were chosen for
FULL_SIZE = 0.2


class MachineError(ValueError):
    """A robot description that cannot walk; the message lists every reason, ``faults`` each one."""

    def __init__(self, message: str, faults: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.faults = tuple(faults) or (message,)


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg: its name and its control reach, a box in body axes (planning limits, H fig. 1)."""

    name: str
    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """C_i, the middle of the reach rectangle (H §2.1)."""
        return (self.x[0] + self.x[1]) / 2, (self.y[0] + self.y[1]) / 2

    @property
    def box(self) -> tuple[float, float, float, float]:
        """The reach rectangle as x_min, x_max, y_min, y_max."""
        return self.x[0], self.x[1], self.y[0], self.y[1]


@dataclass(frozen=True, slots=True)
class Reach:
    """H's one box for all four legs: |x| in [x0, x0+x*], |y| in [y0, y0+y*], z in [-z0-z*, -z0] (H
    fig. 1).
    """

    x0: float
    x_span: float  # x*
    y0: float
    y_span: float  # y*
    z0: float
    z_span: float  # z*


class MassAtFeet(NamedTuple):
    """The moment of a torso about the body's origin, kg·m, the mass of a foot and the whole, kg."""

    x: float
    y: float
    z: float
    foot: float
    whole: float


@dataclass(frozen=True)
class Machine:
    """A walker as both planners and the simulation see it. Lengths in metres, mass in kilograms."""

    name: str
    title: str
    source: str
    mass: float
    torso: tuple[float, float, float]  # length, width, height
    height: float  # H, centre of gravity above the ground
    foot_radius: float
    friction: float
    yaw_length: float  # ρ, metres per radian
    duty_factor: float  # β
    lift_up: float  # h_up
    lift_down: float  # h_dwn
    speed: tuple[float, float, float]  # V_x, V_y, V_z
    overreach: tuple[float, float, float]  # δx, δy, δz
    legs: tuple[Leg, ...]
    card_chains: tuple[LegChain, ...] = ()  # as the card gives them; (): it gives none
    card_masses: Masses | None = None  # as the card gives them
    # m, mean length and width of the legs' reach as the card has it; 0: of these legs. Legs planned
    # for with less, as on slopes, belong to no smaller a machine
    card_span: float = 0.0

    def __hash__(self) -> int:
        return self._at_a_glance

    @cached_property
    def _at_a_glance(self) -> int:
        """A hash of what tells machines apart, worked out once: gaits are looked up by machine
        several times a step. Of numbers alone, whose hash is the same in every process.
        """
        first = self.legs[0]
        return hash((self.mass, self.speed, self.overreach, first.x, first.y, first.z))

    @cached_property
    def gait(self) -> Gait:
        """The gait it was made for; a scenario may override it."""
        return Gait(self.duty_factor, self.lift_up, self.lift_down, self.height)

    @cached_property
    def chains(self) -> tuple[LegChain, ...]:
        """Every leg's chain of joints: the card's, else three slides fitted to its mechanical box
        (the control reach widened by δ).
        """
        if self.card_chains:
            return self.card_chains
        return tuple(self._fitted_slides(index) for index in range(len(self.legs)))

    def _fitted_slides(self, index: int) -> LegChain:
        leg = self.legs[index]
        hip_x, hip_y = self.hips[index]
        dx, dy, dz = self.overreach
        x = leg.x
        y = leg.y
        z = leg.z
        limits: tuple[JointSpan, JointSpan, JointSpan] = (
            (x[0] - dx - hip_x, x[1] + dx - hip_x),
            (y[0] - dy - hip_y, y[1] + dy - hip_y),
            (z[0] - dz, z[1] + dz),
        )
        weight = self.mass * GRAVITY
        drives = Drives(limits, self.speed, (weight, weight, 2.0 * weight))
        return slides_chain((hip_x, hip_y, 0.0), 0.0, drives)

    @cached_property
    def masses(self) -> Masses:
        """Where the mass is: the card's, else an estimate (legs are 12 % of the mass)."""
        if self.card_masses is not None:
            return self.card_masses
        leg = LEGS_SHARE * self.mass / len(self.legs)
        a, b, c = LINK_SHARES
        if self.chains[0].joints[-1].slides:
            a = 0.0
            b = 0.0
            c = 1.0
        return Masses((1.0 - LEGS_SHARE) * self.mass, (a * leg, b * leg, c * leg))

    @cached_property
    def mass_at_feet(self) -> MassAtFeet | None:
        """Where all mass of the legs is at their feet, what its centre of gravity is a mean of;
        None of a machine whose joints make odds to it.
        """
        masses = self.masses
        first, second, foot = masses.links
        if not (first == 0.0 == second and all(chain.joints[2].slides for chain in self.chains)):
            return None
        x, y, z = masses.centre
        whole = masses.torso
        for _ in self.legs:
            whole += masses.leg
        return MassAtFeet(x * masses.torso, y * masses.torso, z * masses.torso, foot, whole)

    @cached_property
    def boxes(self) -> tuple[tuple[float, float, float, float], ...]:
        """Every leg's reach rectangle as (x_min, x_max, y_min, y_max)."""
        return tuple(leg.box for leg in self.legs)

    @cached_property
    def hips(self) -> tuple[tuple[float, float], ...]:
        """Where each leg leaves the torso: the point of its outline nearest to the middle of the
        leg's reach.
        """
        half_length = self.torso[0] / 2
        half_width = self.torso[1] / 2
        return tuple(
            (max(-half_length, min(half_length, x)), max(-half_width, min(half_width, y)))
            for x, y in (leg.centre for leg in self.legs)
        )

    @cached_property
    def size(self) -> float:
        """What a small machine has of a length that was chosen in metres, 0 to 1: insets, lifts and
        spacings of a machine whose legs reach less than ``FULL_SIZE`` shrink with its reach.
        """
        return min(1.0, (self.card_span or _mean_span(self.legs)) / FULL_SIZE)

    @cached_property
    def mirrored_box(self) -> Box:
        """The reach rectangle of H's front left leg: what is common to all four legs, mirrored.

        Of a machine whose centre of gravity lies off the middle of its legs, or whose hips differ,
        this is less than every leg reaches. Raises ``MachineError`` where there is none (the crab
        planner needs it).
        """
        if len(self.legs) != CRAB_LEGS:
            raise MachineError(
                "the crab planner walks four-legged machines; "
                f"{self.name!r} has {len(self.legs)} legs"
            )
        box = mirrored_part(self.boxes)
        if box is None or box[1] - box[0] < LEAST_BOX or box[3] - box[2] < LEAST_BOX:
            raise MachineError(
                "the crab planner walks with the box that the four legs have in common when they "
                "are mirrored about the centre of gravity, at least "
                f"{LEAST_BOX:g} m long and wide; the legs of {self.name!r} have {_size(box)}"
            )
        return box

    @cached_property
    def reach(self) -> Reach:
        """H's symmetric box; raises as ``mirrored_box``."""
        x1, x2, y1, y2 = self.mirrored_box
        low, high = self.z_range
        spans = (round(span, 12) for span in (x2 - x1, y2 - y1, high - low))
        x_span, y_span, z_span = spans
        return Reach(x1, x_span, y1, y_span, -high, z_span)

    @cached_property
    def critical_angle(self) -> float:
        """α_c, where the walk along x turns over into the walk along y (H §4.3 (2)), rad."""
        reach = self.reach
        return math.atan((reach.y0 + reach.y_span / 2) / (reach.x0 + reach.x_span / 2))

    @cached_property
    def z_range(self) -> tuple[float, float]:
        """Heights every leg can stand at: the intersection of the legs' z ranges."""
        return max(leg.z[0] for leg in self.legs), min(leg.z[1] for leg in self.legs)


_NUMBERS = of_shape(ROBOT_KEYS, NUMBER)
_TRIPLES = of_shape(ROBOT_KEYS, TRIPLE)
_WORDS = of_shape(ROBOT_KEYS, TEXT)


def _mean_span(legs: Sequence[Leg]) -> float:
    """Mean length and width of what the legs reach, m."""
    spans = [leg.x[1] - leg.x[0] + leg.y[1] - leg.y[0] for leg in legs]
    return left_fold_sum(spans) / (2 * len(spans))


def _size(box: Box | None) -> str:
    return "none" if box is None else f"{box[1] - box[0]:.3g} x {box[3] - box[2]:.3g} m"


def machine_names() -> tuple[str, ...]:
    """Names of the shipped robots, sorted."""
    folder = resources.files("walking_console.planner.robot") / "descriptions"
    return tuple(
        sorted(
            entry.name.removesuffix(".toml")
            for entry in folder.iterdir()
            if entry.name.endswith(".toml")
        )
    )


def load_machine(name_or_path: str, relative_to: Path | None = None) -> Machine:
    """A shipped robot by name, or a robot file by path (relative to ``relative_to``).

    Raises ``MachineError``, a ``ValueError`` that lists every reason.

    >>> from walking_console import load_machine
    >>> machine = load_machine("titan3")
    >>> [leg.name for leg in machine.legs], machine.mass, machine.height
    (['front left', 'rear left', 'rear right', 'front right'], 80.0, 0.85)
    """
    what = f"robot file {name_or_path!r}"
    try:
        if name_or_path in machine_names():
            return _shipped(name_or_path)
        path = (relative_to or Path()) / name_or_path
        if not names_toml_file(name_or_path) or not is_file(path):
            raise MachineError(
                f"unknown robot {name_or_path!r:.200}; there are: {', '.join(machine_names())}, "
                "or a path to a robot TOML file"
            )
        return machine_from(read_toml(path, what))
    except TomlFileError as error:
        raise MachineError(str(error)) from None


@cache
def _shipped(name: str) -> Machine:
    """The one instance of a shipped robot: what is looked up by machine is found at once by the
    same one, by an equal one only after all of its numbers are compared.
    """
    folder = resources.files("walking_console.planner.robot") / "descriptions"
    text = (folder / f"{name}.toml").read_text("utf-8")
    return machine_from(parse_toml(text, f"robot file {name!r}"))


def machine_from(data: Mapping[str, Any]) -> Machine:
    """Build and check a machine from plain data (a parsed robot file); a refusal lists every
    reason.
    """
    faults: list[str] = []
    unknown_keys(data, ROBOT_KEYS, "", faults)
    words = {key: word(data, key, faults) for key in _WORDS}
    wrong: list[str] = []  # of numbers
    values = {key: admitted_number(data.get(key), ROBOT_KEYS[key], wrong) for key in _NUMBERS}
    triples = {key: admitted_triple(data.get(key), ROBOT_KEYS[key], wrong) for key in _TRIPLES}
    unfit: list[str] = []  # of legs
    tables = _leg_tables(data.get("legs"), unfit)
    chains = _chains(data.get("chain"), tables, unfit)
    legs = _legs(tables, chains, unfit)
    if not unfit:
        _check_stance(legs, unfit)
        _check_reach(legs, chains, unfit)
    heavy: list[str] = []  # of masses
    masses = masses_from(data.get("masses"), heavy)
    if not wrong:
        _check_lifts(values, wrong)
    if not (wrong or unfit):
        _check_height(legs, values["height"], unfit)
    if masses is not None and tables and not (wrong or heavy):
        check_masses(masses, values["mass"], len(tables), heavy)
    faults += [*wrong, *unfit, *heavy]
    if faults:
        name = words["name"] or "?"
        raise MachineError(f"robot {name} cannot be used: " + "; ".join(faults), faults)
    plain: dict[str, Any] = {**words, **values, **triples}
    return Machine(
        **plain, legs=legs, card_chains=chains, card_masses=masses, card_span=_mean_span(legs)
    )


def as_data(machine: Machine) -> dict[str, Any]:
    """The robot as plain data, the inverse of ``machine_from`` (what ``run.json`` keeps)."""
    plain = {key: getattr(machine, key) for key in (*_WORDS, *_NUMBERS)}
    triples = {key: list(getattr(machine, key)) for key in _TRIPLES}
    legs: list[dict[str, Any]] = [
        {"name": leg.name, "x": list(leg.x), "y": list(leg.y), "z": list(leg.z)}
        for leg in machine.legs
    ]
    for leg, chain in zip(legs, machine.card_chains, strict=False):
        leg |= {"hip": list(chain.hip), "chain": chain_data(chain)}
    masses = {} if machine.card_masses is None else {"masses": masses_data(machine.card_masses)}
    return {**plain, **triples, **masses, "legs": legs}


def _leg_tables(value: Any, faults: list[str]) -> list[Mapping[str, Any]]:
    if not isinstance(value, list) or not LEGS_MIN <= len(value) <= LEGS_MAX:
        got = len(value) if isinstance(value, list) else shown(value)
        faults.append(f"legs must be {LEGS_MIN} to {LEGS_MAX} tables, got {got}")
        return []
    for index, item in enumerate(value, 1):
        if not isinstance(item, Mapping):
            faults.append(f"leg {index} must be a table with {', '.join(LEG_KEYS)}")
        else:
            unknown_keys(item, LEG_KEYS, f" in leg {index}", faults)
    return [item for item in value if isinstance(item, Mapping)]


def _legs(
    tables: list[Mapping[str, Any]], chains: tuple[LegChain, ...], faults: list[str]
) -> tuple[Leg, ...]:
    """Every leg with its control box: the card's, else the one that fits its chain's reach. Where
    chains have faults a leg without a box is left out.
    """
    legs = []
    unfit = bool(faults)
    for index, item in enumerate(tables, 1):
        name = word(item, "name", faults, f"leg {index} ")
        boxed = any(axis in item for axis in "xyz")
        if chains and not boxed:
            legs.append(Leg(name, *fitted_box(chains[index - 1])))
        if not boxed and (chains or unfit):
            continue
        x, y, z = (_range(item.get(axis), f"leg {index} {axis}", faults) for axis in "xyz")
        legs.append(Leg(name, x, y, z))
    return tuple(legs)


def _range(value: Any, key: str, faults: list[str]) -> JointSpan:
    found = len(faults)
    low, high = numbers(value, key, 2, faults)
    if len(faults) > found:
        return low, high
    if not low < high:
        faults.append(f"{key} must be [low, high] with low < high, got {[low, high]}")
    elif not max(-low, high) <= LENGTH_MAX:
        faults.append(f"{key} must be within {LENGTH_MAX:g} m, got {[low, high]}")
    return low, high


def _chains(
    common: Any, tables: list[Mapping[str, Any]], faults: list[str]
) -> tuple[LegChain, ...]:
    """Every leg's chain: the card's ``chain`` with the leg's own keys laid over it; () without
    either, and after a fault.
    """
    if common is None and not any("chain" in leg or "hip" in leg for leg in tables):
        return ()
    found = len(faults)
    chains = []
    for index, leg in enumerate(tables, 1):
        own = leg.get("chain", {})
        if not isinstance(own, Mapping) or not isinstance(common or {}, Mapping):
            faults.append(f"leg {index} chain must be a table, got {shown(own or common)}")
            continue
        hip = admitted_triple(leg.get("hip"), LEG_KEYS["hip"], faults, f"leg {index} ")
        chains.append(chain_from({**(common or {}), **own}, hip, f"leg {index} chain", faults))
    return tuple(chains) if len(faults) == found else ()


def _check_reach(legs: tuple[Leg, ...], chains: tuple[LegChain, ...], faults: list[str]) -> None:
    """Every place of a control box must be one that its leg's joints can reach."""
    for index, (leg, chain) in enumerate(zip(legs, chains, strict=False), 1):
        spot = out_of_reach(chain, (leg.x, leg.y, leg.z))
        if spot is not None:
            place = ", ".join(f"{part:.3f}" for part in spot)
            faults.append(
                f"leg {index} cannot reach ({place}) of its control box with its {chain.kind} "
                "chain; make the box smaller, or leave x, y and z out to have one fitted"
            )


def _check_lifts(values: Mapping[str, float], faults: list[str]) -> None:
    if values["lift_down"] < values["lift_up"]:
        faults.append(
            f"lift_down must be at least lift_up {values['lift_up']:g}, got {values['lift_down']:g}"
        )


def _check_height(legs: tuple[Leg, ...], height: float, faults: list[str]) -> None:
    low = max(leg.z[0] for leg in legs)
    high = min(leg.z[1] for leg in legs)
    if not low <= -height <= high:
        faults.append(
            f"height {height:g} is outside the legs' common z range [{-high:g}, {-low:g}]"
        )


def _check_stance(legs: tuple[Leg, ...], faults: list[str]) -> None:
    angles = [math.atan2(leg.centre[1], leg.centre[0]) % (2 * math.pi) for leg in legs]
    if any(b <= a for a, b in zip(angles, angles[1:], strict=False)):
        faults.append("legs must run counter-clockwise from front-left")
    gaps = [(b - a) % (2 * math.pi) for a, b in zip(angles, angles[1:] + angles[:1], strict=True)]
    if max(gaps) >= math.pi:
        faults.append(
            "no statically stable stance: the centre of gravity is outside the polygon of the leg "
            "centres"
        )
