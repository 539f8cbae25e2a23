"""Reading a robot card: numbers, texts, leg chains and masses out of parsed TOML.

Every reader appends what is wrong to ``faults`` and goes on, so that a refusal lists every reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from ..geometry.transforms import Point
from .card_keys import (
    CHAIN_KEYS,
    JOINT_KEYS,
    LENGTH_MAX,
    LINK_MIN,
    MASS_KEYS,
    NUMBER_MAX,
    CardKey,
)
from .chains import (
    JOINTS,
    NOWHERE,
    Drives,
    JointSpan,
    LegChain,
    Masses,
    chain_of,
    insect_chain,
    mammal_chain,
    slides_chain,
)

ANGLE_MAX = 2.0 * math.pi
MASS_SLACK = 0.01  # share of the mass by which torso and legs may differ from it

KINDS = ("slides", "insect", "mammal", "serial")

T = TypeVar("T", float, Point)


def shown(value: Any) -> str:
    """A refused value in at most 80 characters."""
    try:
        return f"{value!r:.80}"
    # an integer of thousands of digits, tables in tables in tables
    except (ValueError, RecursionError):
        return (
            "a number too long to show" if isinstance(value, int) else "a value too large to show"
        )


def word(data: Mapping[str, Any], key: str, faults: list[str], where: str = "") -> str:
    """The text under a key, 1 to 500 characters."""
    value = data.get(key)
    if not isinstance(value, str) or not value.strip() or len(value) > 500:
        faults.append(f"{where}{key} must be a text of 1 to 500 characters, got {shown(value)}")
        return ""
    return value


def number(value: Any, key: str, faults: list[str]) -> float:
    """A finite number of at most ``NUMBER_MAX``."""
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) <= NUMBER_MAX
    ):
        faults.append(
            f"{key} must be a finite number of at most {NUMBER_MAX:g}, got {shown(value)}"
        )
        return 0.0
    return float(value)


def numbers(value: Any, key: str, count: int, faults: list[str]) -> tuple[float, ...]:
    """A list of so many finite numbers."""
    if not isinstance(value, list) or len(value) != count:
        faults.append(f"{key} must be a list of {count} numbers, got {shown(value)}")
        return (0.0,) * count
    return tuple(number(item, f"{key}[{index}]", faults) for index, item in enumerate(value))


def triple(value: Any, key: str, faults: list[str]) -> Point:
    """A list of three finite numbers."""
    a, b, c = numbers(value, key, 3, faults)
    return a, b, c


def _admitted(
    read: Callable[[Any, str, list[str]], T],
    value: Any,
    key: CardKey,
    faults: list[str],
    where: str,
) -> T:
    found = len(faults)
    result = read(value, f"{where}{key.name}", faults)
    if len(faults) == found:
        faults.extend(filter(None, [key.fault(result, where)]))
    return result


def admitted_number(value: Any, key: CardKey, faults: list[str], where: str = "") -> float:
    """A number within the limits of its key."""
    return _admitted(number, value, key, faults, where)


def admitted_triple(value: Any, key: CardKey, faults: list[str], where: str = "") -> Point:
    """Three numbers within the limits of their key."""
    return _admitted(triple, value, key, faults, where)


def unknown_keys(
    data: Mapping[str, Any], known: Iterable[str], where: str, faults: list[str]
) -> None:
    """Names every key that is not known, and the known ones."""
    for key in data:
        if key not in known:
            faults.append(f"unknown key {key!r:.80}{where}; there are: {', '.join(known)}")


# -- leg chains


def chain_from(data: Mapping[str, Any], hip: Point, where: str, faults: list[str]) -> LegChain:
    """A leg's chain from its table (the card's ``chain`` with the leg's own keys laid over it)."""
    found = len(faults)
    unknown_keys(data, CHAIN_KEYS, f" in {where}", faults)
    kind = data.get("kind")
    if kind not in KINDS:
        faults.append(f"{where} kind must be one of {', '.join(KINDS)}, got {shown(kind)}")
    facing = number(data.get("facing", 0.0), f"{where} facing", faults)
    drives = _drives(data, where, faults)
    if kind == "serial":
        axes = _serial_joints(data.get("joints"), where, faults)
        return chain_of("serial", hip, facing, axes, drives)
    links = NOWHERE
    if kind in ("insect", "mammal"):
        links = _links(data.get("links"), where, faults, bool(kind == "insect"))
    if len(faults) > found or kind == "slides":
        return slides_chain(hip, facing, drives)
    build = insect_chain if kind == "insect" else mammal_chain
    return build(hip, facing, links, drives)


def _drives(data: Mapping[str, Any], where: str, faults: list[str]) -> Drives:
    spans = data.get("limits")
    if not isinstance(spans, list) or len(spans) != JOINTS:
        faults.append(f"{where} limits must be {JOINTS} pairs [low, high], got {shown(spans)}")
        spans = [[0.0, 1.0]] * JOINTS
    a, b, c = (_span(span, f"{where} limits[{i}]", faults) for i, span in enumerate(spans))
    speed = admitted_triple(data.get("speed"), CHAIN_KEYS["speed"], faults, f"{where} ")
    torque = admitted_triple(data.get("torque"), CHAIN_KEYS["torque"], faults, f"{where} ")
    return Drives((a, b, c), speed, torque)


def _span(value: Any, key: str, faults: list[str]) -> JointSpan:
    found = len(faults)
    low, high = numbers(value, key, 2, faults)
    if len(faults) == found and not -LENGTH_MAX <= low < high <= LENGTH_MAX:
        faults.append(
            f"{key} must be [low, high] with low < high, rad or m within {LENGTH_MAX:g}, "
            f"got {shown(value)}"
        )
    return low, high


def _links(value: Any, where: str, faults: list[str], first: bool) -> Point:
    found = len(faults)
    links = triple(value, f"{where} links", faults)
    if len(faults) > found:
        return links
    fit = all(LINK_MIN <= link <= LENGTH_MAX for link in links[1:])
    if not (fit and 0.0 <= links[0] <= LENGTH_MAX):
        faults.append(
            f"{where} links must be [l1, l2, l3] with l1 from 0, l2 and l3 from {LINK_MIN:g} "
            f"to {LENGTH_MAX:g} m, got {shown(value)}"
        )
    return links


def _serial_joints(value: Any, where: str, faults: list[str]) -> list[tuple[Point, Point, bool]]:
    if not isinstance(value, list) or len(value) != JOINTS:
        faults.append(
            f"{where} joints must be {JOINTS} tables with {', '.join(JOINT_KEYS)}, "
            f"got {shown(value)}"
        )
        value = []
    found = [_joint(item, f"{where} joint {i}", faults) for i, item in enumerate(value, 1)]
    return found or [((0.0, 0.0, 1.0), NOWHERE, True)] * JOINTS


def _joint(value: Any, where: str, faults: list[str]) -> tuple[Point, Point, bool]:
    if not isinstance(value, Mapping):
        faults.append(f"{where} must be a table with {', '.join(JOINT_KEYS)}, got {shown(value)}")
        return (0.0, 0.0, 1.0), NOWHERE, True
    unknown_keys(value, JOINT_KEYS, f" in {where}", faults)
    x, y, z = triple(value.get("axis"), f"{where} axis", faults)
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-9:
        faults.append(f"{where} axis must not be zero, got {shown(value.get('axis'))}")
        length = 1.0
    offset = triple(value.get("offset", [0.0, 0.0, 0.0]), f"{where} offset", faults)
    slides = value.get("slides", False)
    if not isinstance(slides, bool):
        faults.append(f"{where} slides must be true or false, got {shown(slides)}")
    if abs(length - 1.0) > 1e-12:  # a unit vector stays what it is, to the last bit
        return (x / length, y / length, z / length), offset, slides is True
    return (x, y, z), offset, slides is True


def chain_data(chain: LegChain) -> dict[str, Any]:
    """A leg's chain as plain data, the inverse of ``chain_from`` (the hip apart)."""
    data: dict[str, Any] = {
        "kind": chain.kind,
        "facing": chain.facing,
        "limits": [list(joint.limits) for joint in chain.joints],
        "speed": [joint.speed for joint in chain.joints],
        "torque": [joint.torque for joint in chain.joints],
    }
    if chain.links:
        data["links"] = list(chain.links)
    if chain.kind == "serial":
        data["joints"] = [
            {"axis": list(joint.axis), "offset": list(joint.offset), "slides": joint.slides}
            for joint in chain.joints
        ]
    return data


# -- masses


def masses_from(value: Any, faults: list[str]) -> Masses | None:
    """The card's ``masses`` table; None without one."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        faults.append(f"masses must be a table with {', '.join(MASS_KEYS)}, got {shown(value)}")
        return None
    unknown_keys(value, MASS_KEYS, " in masses", faults)
    keys = MASS_KEYS
    torso = admitted_number(value.get("torso"), keys["torso"], faults, "masses ")
    links = admitted_triple(value.get("links"), keys["links"], faults, "masses ")
    centre = admitted_triple(
        value.get("centre", [0.0, 0.0, 0.0]), keys["centre"], faults, "masses "
    )
    return Masses(torso, links, centre)


def check_masses(masses: Masses, mass: float, legs: int, faults: list[str]) -> None:
    """Torso and legs must together weigh what the machine weighs."""
    whole = masses.torso + legs * masses.leg
    if abs(whole - mass) > MASS_SLACK * mass:
        faults.append(
            f"masses must add up to the mass {mass:g} kg, got {whole:g} kg of torso and {legs} legs"
        )


def masses_data(masses: Masses) -> dict[str, Any]:
    """Masses as plain data, the inverse of ``masses_from``."""
    return {
        "torso": masses.torso,
        "links": list(masses.links),
        "centre": list(masses.centre),
    }
