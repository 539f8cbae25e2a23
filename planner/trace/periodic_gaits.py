"""Rigid gaits as data (K "gait"): rows of states, and the same as one binary fraction for each leg.

A row says which legs stand (1) and which are in the air (0), legs counter-clockwise from
front-left. Digit n of a leg's fraction is its n-th state; a cyclic gait is a recurring fraction, α
= cycle / (2^length − 1) (fig. 3: 14/15 and 11/15).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

SUPPORTING_MIN = 3  # legs, K: a statically stable gait keeps three down in every state
LENGTH_MAX = 64  # states in a cycle

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
        """The legs moved together, in order: each time legs come down."""
        moved = []
        n = len(self.rows)
        for k in range(n):
            down = tuple(
                leg
                for leg, digit in enumerate(self.rows[k])
                if digit == 0 and self.rows[(k + 1) % n][leg] == 1
            )
            if down:
                moved.append(down)
        return tuple(moved)

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
        "ripple": """
            111111 110111
            111111 111110
            111111 101111
            111111 111011
            111111 011111
            111111 111101""",
        "gallop": """
            111111 110011
            111111 101101
            111111 011110""",
    }.items()
}


def rigid_gait(name: str) -> RigidGait:
    """A shipped rigid gait of the six-legged machine; raises ``GaitError`` with the known names."""
    if name not in GAITS:
        raise GaitError(f"unknown gait {name!r}; there are: free, {', '.join(GAITS)}")
    return GAITS[name]
