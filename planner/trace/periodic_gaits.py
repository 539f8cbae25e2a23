"""Rigid gaits as data (K "gait"): rows of states, and the same as one binary fraction for each leg.

A row says which legs stand (1) and which are in the air (0), legs counter-clockwise from
front-left. Digit n of a leg's fraction is its n-th state; a cyclic gait is a recurring fraction, α
= cycle / (2^length − 1) (fig. 3: 14/15 and 11/15).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..robot.model import Machine

SUPPORTING_MIN = 3  # legs, K: a statically stable gait keeps three down in every state
LENGTH_MAX = 64  # states in a cycle
STATES = 60  # that a cycle of phases is cut into

Row = tuple[int, ...]


class GaitError(ValueError):
    """Rows or fractions that are no statically stable gait."""


@dataclass(frozen=True, slots=True)
class RigidGait:
    """A cyclic sequence of states that is followed whatever the ground offers."""

    name: str
    rows: tuple[Row, ...]

    def __post_init__(self) -> None:
        legs = {len(row) for row in self.rows}
        if len(legs) != 1 or any(digit not in (0, 1) for row in self.rows for digit in row):
            raise GaitError(f"gait {self.name!r} needs rows of 0 and 1, all of one length")
        for n, row in enumerate(self.rows, 1):
            if sum(row) < SUPPORTING_MIN:
                raise GaitError(
                    f"gait {self.name!r} stands on {sum(row)} legs in state {n}; "
                    f"at least {SUPPORTING_MIN} must carry"
                )

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """The legs moved together, in order of lifting: those that lift before the first of them is
        half way. Lifting and landing together is the nearest to overlapping swings that a walk by
        changes of state has.
        """
        moved: list[list[int]] = []
        half = -1.0
        for start, length, leg in sorted(self._swings()):
            if start > half:
                moved.append([])
                half = start + length / 2
            moved[-1].append(leg)
        return tuple(tuple(sorted(legs)) for legs in moved)

    def _swings(self) -> Iterator[tuple[int, int, int]]:
        """Every time a leg is in the air: first state, number of states, leg."""
        n = len(self.rows)
        for leg in range(len(self.rows[0])):
            digits = [row[leg] for row in self.rows]
            for k in range(n):
                if digits[k] == 0 and digits[k - 1] == 1:
                    length = next(m for m in range(1, n) if digits[(k + m) % n] == 1)
                    yield k, length, leg

    @property
    def fractions(self) -> tuple[Fraction, ...]:
        """α_1 … α_n, K fig. 3."""
        return fractions_of(self.rows)


def fractions_of(rows: Sequence[Row]) -> tuple[Fraction, ...]:
    """Rows of a cycle as recurring binary fractions, one a leg."""
    whole = 2 ** len(rows) - 1
    return tuple(
        Fraction(int("".join(str(row[leg]) for row in rows), 2), whole)
        for leg in range(len(rows[0]))
    )


def rows_of(fractions: Sequence[Fraction]) -> tuple[Row, ...]:
    """The shortest cycle of rows these fractions recur with; raises ``GaitError`` when there is
    none up to LENGTH_MAX.
    """
    if any(not 0 <= f <= 1 for f in fractions):
        raise GaitError(
            f"a gait's fractions lie between 0 and 1, got {[str(f) for f in fractions]}"
        )
    for length in range(1, LENGTH_MAX + 1):
        whole = 2**length - 1
        if all((f * whole).denominator == 1 for f in fractions):
            columns = [f"{int(f * whole):0{length}b}" for f in fractions]
            return tuple(tuple(int(column[n]) for column in columns) for n in range(length))
    raise GaitError(f"these fractions do not recur within {LENGTH_MAX} states")


def may_be_stable(fractions: Sequence[Fraction]) -> bool:
    """K's necessary, not sufficient condition: Σα_i ≥ 3."""
    return sum(fractions) >= SUPPORTING_MIN


def _rows(text: str) -> tuple[Row, ...]:
    return tuple(tuple(int(digit) for digit in row) for row in text.split())


#   legs in each row: FL ML RL RR MR FR
GAITS: dict[str, RigidGait] = {
    name: RigidGait(name, _rows(text))
    for name, text in {
        "tripod": """
            111111 101010
            111111 010101""",
        "wave": """
            111111 110111
            111111 101111
            111111 011111
            111111 111011
            111111 111101
            111111 111110""",
        # the waves of the two sides half a cycle apart: a third of it in the air, two legs a time
        "ripple": """
            110101
            110110
            101110
            101011
            011011
            011101""",
        "gallop": """
            111111 110011
            111111 101101
            111111 011110""",
    }.items()
}
LEGS_MIN = {"tripod": 6, "wave": 4, "ripple": 5, "gallop": 5}


def rigid_gait(name: str, machine: Machine | None = None) -> RigidGait:
    """A rigid gait by name, of this machine or of six legs; raises ``GaitError`` with the known
    names, or with the number of legs it is for.
    """
    if name not in GAITS:
        raise GaitError(f"unknown gait {name!r}; there are: free, {', '.join(GAITS)}")
    if machine is None or len(machine.legs) == len(GAITS[name].rows[0]):
        return GAITS[name]
    count = len(machine.legs)
    if count < LEGS_MIN[name]:
        raise GaitError(
            f"rigid gait {name!r} is for at least {LEGS_MIN[name]} legs; {machine.name} has {count}"
        )
    return RigidGait(name, _rows_of_groups(_groups_for(name, machine), count))


def fastest_gait(machine: Machine) -> RigidGait | None:
    """The one with most legs in the air at a time that this machine has the legs for."""
    legs = len(machine.legs)
    name = next((name for name in ("tripod", "ripple") if legs >= LEGS_MIN[name]), None)
    return None if name is None else rigid_gait(name, machine)


def _groups_for(name: str, machine: Machine) -> list[list[int]]:
    """The legs moved together, of any number of legs: each side from the rear to the front."""
    legs = range(len(machine.legs))
    if name == "tripod":
        return [[leg for leg in legs if leg % 2 == odd] for odd in (1, 0)]
    places = [leg.centre for leg in machine.legs]
    left = sorted((leg for leg in legs if places[leg][1] >= 0.0), key=lambda leg: places[leg][0])
    right = sorted((leg for leg in legs if places[leg][1] < 0.0), key=lambda leg: places[leg][0])
    if name == "wave":
        return [[leg] for leg in (*left, *right)]
    count = max(len(left), len(right))
    aside = count - 1 if name == "ripple" else 0  # of one wave behind the other
    both = [(*left[k : k + 1], *_one(right, (k + aside) % count)) for k in range(count)]
    return [sorted(pair) for pair in both]


def _one(legs: Sequence[int], k: int) -> Sequence[int]:
    return legs[k : k + 1]


def _rows_of_groups(groups: Sequence[Sequence[int]], legs: int) -> tuple[Row, ...]:
    """Rows in which each group in turn is in the air, all legs down between."""
    rows: list[Row] = []
    for group in groups:
        rows += [(1,) * legs, tuple(int(leg not in group) for leg in range(legs))]
    return tuple(rows)


def given_gait(given: Mapping[str, Any], machine: Machine) -> RigidGait:
    """A rigid gait of one's own: ``rows``, ``fractions``, or ``duty`` and ``phases``, legs in the
    machine's order. Raises ``GaitError``.

    ``phases`` say when in the cycle each leg comes down; it then stands for ``duty`` of the cycle.
    """
    rows = _given_rows(given)
    if len(rows) > LENGTH_MAX:
        raise GaitError(f"a rigid gait has at most {LENGTH_MAX} states, got {len(rows)}")
    for row in rows:
        if len(row) != len(machine.legs):
            raise GaitError(
                f"a rigid gait says of every leg what it does; {machine.name} has "
                f"{len(machine.legs)} legs, this gait {len(row)}"
            )
    gait = RigidGait("own", rows)
    resting = set(range(len(machine.legs))) - {leg for group in gait.groups for leg in group}
    if resting:
        raise GaitError(f"leg {min(resting) + 1} never swings in this gait")
    return gait


def _given_rows(given: Mapping[str, Any]) -> tuple[Row, ...]:
    if "rows" in given:
        return tuple(tuple(int(digit) for digit in row) for row in given["rows"])
    if "fractions" in given:
        return rows_of([Fraction(text) for text in given["fractions"]])
    duty = float(given["duty"])
    moments = [(k + 0.5) / STATES for k in range(STATES)]
    return tuple(
        tuple(int((moment - phase) % 1.0 < duty) for phase in given["phases"]) for moment in moments
    )
