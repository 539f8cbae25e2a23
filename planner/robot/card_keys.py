"""Every key of a robot card: what it is, in which unit, within which limits, and what it means.

``card`` and ``model`` take names and limits from here, and ``sim.format_tables`` makes the tables
of ``docs/robots.md`` of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

LEGS_MIN = 4
LEGS_MAX = 8
NUMBER_MAX = 1e6
LENGTH_MAX = 10.0  # m: beyond it maps and searches outgrow memory, and nothing walks
FOOT_MAX = 0.5  # m
DUTY_MIN = 0.5
LINK_MIN = 1e-3  # m

NUMBER = "number"
TRIPLE = "list of 3 numbers"
PAIR = "list of 2 numbers"
TEXT = "text"
TABLE = "table"


@dataclass(frozen=True, slots=True)
class CardKey:
    """One key. Of its numbers each is more than ``above``, at least ``least``, at most ``most``,
    less than ``below``, and no farther from 0 than ``within``.
    """

    name: str
    shape: str
    unit: str
    meaning: str
    above: float | None = None
    least: float | None = None
    most: float | None = None
    below: float | None = None
    within: float | None = None
    default: str = "must be given"

    @property
    def limits(self) -> str:
        """The limits in words, "" where there are none of its own."""
        unit = f" {self.unit}" if self.unit else ""
        said = [
            f"more than {self.above:g}" if self.above else "",
            "positive" if self.above == 0.0 else "",
            f"at least {self.least:g}" if self.least else "",
            "not negative" if self.least == 0.0 else "",
            f"at most {self.most:g}{unit}" if self.most is not None else "",
            f"less than {self.below:g}{unit}" if self.below is not None else "",
            f"within {self.within:g}{unit}" if self.within is not None else "",
        ]
        return ", ".join(filter(None, said))

    def admits(self, value: float) -> bool:
        """Whether a number is within the limits."""
        return (
            (self.above is None or value > self.above)
            and (self.least is None or value >= self.least)
            and (self.most is None or value <= self.most)
            and (self.below is None or value < self.below)
            and (self.within is None or abs(value) <= self.within)
        )

    def fault(self, values: float | Iterable[float], where: str = "") -> str:
        """What is wrong with a number, or with any of several; "" when nothing is."""
        parts = [values] if isinstance(values, int | float) else list(values)
        if all(self.admits(part) for part in parts):
            return ""
        got = f"{values:g}" if isinstance(values, int | float) else str(parts)
        return f"{where}{self.name} must be {self.limits}, got {got}"


def by_name(keys: Iterable[CardKey]) -> Mapping[str, CardKey]:
    """The keys by their names, in order."""
    return {key.name: key for key in keys}


def of_shape(keys: Mapping[str, CardKey], shape: str) -> tuple[str, ...]:
    """The names of those of one shape."""
    return tuple(key.name for key in keys.values() if key.shape == shape)


ROBOT_KEYS = by_name(
    (
        CardKey("name", TEXT, "", "what it is called, in a word; 1 to 500 characters"),
        CardKey("title", TEXT, "", "the same in a line"),
        CardKey("source", TEXT, "", "where its numbers come from"),
        CardKey("mass", NUMBER, "kg", "of the whole machine", above=0.0),
        CardKey("height", NUMBER, "m", "H, of the origin over the ground; within the z ranges of "
                "all legs", above=0.0, most=LENGTH_MAX),
        CardKey("foot_radius", NUMBER, "m", "of a sole", above=0.0, most=FOOT_MAX),
        CardKey("friction", NUMBER, "", "of soles on the ground", above=0.0),
        CardKey("yaw_length", NUMBER, "m", "ρ, for each radian: weighs turning against going",
                above=0.0, most=LENGTH_MAX),
        CardKey("duty_factor", NUMBER, "", "β, share of the cycle a leg stands, in the gait it "
                "begins with", least=DUTY_MIN, below=1.0),
        CardKey("lift_up", NUMBER, "m", "h_up, how high a foot is lifted", above=0.0,
                most=LENGTH_MAX),
        CardKey("lift_down", NUMBER, "m", "h_dwn, how far it comes down until there is ground; at "
                "least `lift_up`", above=0.0, most=LENGTH_MAX),
        CardKey("torso", TRIPLE, "m", "length, width, height", above=0.0, most=LENGTH_MAX),
        CardKey("speed", TRIPLE, "m/s", "of a foot against the body along x, y, z", above=0.0),
        CardKey("overreach", TRIPLE, "m", "how far the mechanism reaches beyond the control box "
                "along x, y, z", least=0.0, most=LENGTH_MAX),
        CardKey("chain", TABLE, "", "the chain all legs have", default="three slides"),
        CardKey("masses", TABLE, "", "where the mass is", default="12 % of it in the legs"),
        CardKey("legs", f"list of {LEGS_MIN} to {LEGS_MAX} tables", "",
                "counter-clockwise from front-left"),
    )
)  # fmt: skip
BOX = "a box fitted to the chain"
LEG_KEYS = by_name(
    (
        CardKey("name", TEXT, "", "of the leg"),
        *(
            CardKey(axis, PAIR, "m", f"lowest and highest {axis} of its control box",
                    within=LENGTH_MAX, default=BOX)
            for axis in "xyz"
        ),
        CardKey("hip", TRIPLE, "m", "where its chain begins", within=LENGTH_MAX,
                default="must be given with a chain"),
        CardKey("chain", TABLE, "", "laid over the chain of all legs, key by key", default=""),
    )
)  # fmt: skip
CHAIN_KEYS = by_name(
    (
        CardKey("kind", TEXT, "", "`slides` (x, y, z in series), `insect` (yaw, pitch, pitch), "
                "`mammal` (roll, pitch, pitch) or `serial` (any three joints)"),
        CardKey("links", TRIPLE, "m", "l1, l2, l3 of `insect` and `mammal`; l2 and l3 from "
                f"{LINK_MIN:g}", least=0.0, most=LENGTH_MAX, default="must be given with them"),
        CardKey("joints", "list of 3 tables", "", "of `serial`, from the hip out",
                default="must be given with it"),
        CardKey("limits", "list of 3 pairs", "rad or m", "lowest and highest of each joint",
                within=LENGTH_MAX),
        CardKey("speed", TRIPLE, "rad/s or m/s", "the most of each joint", above=0.0),
        CardKey("torque", TRIPLE, "N·m or N", "the most of each joint's drive", above=0.0),
        CardKey("facing", NUMBER, "rad", "the way the leg's own x points; 0 is ahead",
                default="`0.0`"),
    )
)  # fmt: skip
JOINT_KEYS = by_name(
    (
        CardKey("axis", TRIPLE, "", "the joint turns about it, or slides along it; not zero"),
        CardKey("offset", TRIPLE, "m", "to the next joint, or the foot tip", default="`[0, 0, 0]`"),
        CardKey("slides", "true or false", "", "slides instead of turning", default="`false`"),
    )
)  # fmt: skip
MASS_KEYS = by_name(
    (
        CardKey("torso", NUMBER, "kg", "torso and legs add up to the mass within 1 %", above=0.0),
        CardKey("links", TRIPLE, "kg", "of each leg, from the hip out", least=0.0),
        CardKey("centre", TRIPLE, "m", "the torso's own centre of gravity", within=LENGTH_MAX,
                default="`[0, 0, 0]`"),
    )
)  # fmt: skip
CARD_TABLES = (
    ("Top level", "The body, and the gait it begins with.", ROBOT_KEYS),
    ("`[[legs]]`", "One leg. A box left out altogether is fitted to the leg's reach.", LEG_KEYS),
    ("`[chain]`", "The three joints of a leg; a leg's own `chain` has the same keys.", CHAIN_KEYS),
    ("`[[chain.joints]]`", "One joint of a `serial` chain, with all joints at 0.", JOINT_KEYS),
    ("`[masses]`", "Where the mass is.", MASS_KEYS),
)
