"""The tunables of supervising, of going round and of contact: by theme, each with what you see when
it is wrong.

A scenario sets them by name, ``[config.tracking] held_back = 0.05``; what it does not name stays.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any


@dataclass(frozen=True, slots=True)
class Tolerances:
    """How exactly a plant does what it is told; the defaults are of one that errs by rounding only.

    The supervisor takes what is within them for what was planned.
    """

    # m, rad; a stance this close to the plan's end is taken to be it. Smaller than the plant errs:
    # see every step planned twice; larger: see feet drift from their plan unnoticed
    same_place: float = 1e-6
    # m the body may be from where the plan has it. Smaller: servo noise stops the walk; larger: see
    # it lean on an obstacle before it stops
    held_back: float = 0.01
    # m a foot set down may be from J_u and still have finished its step. Smaller: see the same leg
    # swing twice
    landed_as_planned: float = 0.02
    # m the body may be off in the plans of a posture. Larger: see a push eat up the margin of the
    # next swing
    body_off: float = 0.002
    # m a foot may seem to be off in the plans of a posture. Smaller: see sensor noise begin the
    # posture anew
    foot_off: float = 0.015
    # which Level C drives it. ``exact``: feet are where they are told to be, and the body is put
    # where the plan has it in every tick; ``inertia``: legs give and the body swings
    law: str = "exact"
    # m and rad, what its position monitors and its posture sensor scatter by
    position_noise: float = 0.0
    posture_noise: float = 0.0
    late: int = 0  # ticks that what it senses is old
    # of the way, that its odometry drifts by. Smaller than it does: see feet come down on the edges
    # of holes after a long walk
    drift: float = 0.0

    @property
    def scatters(self) -> bool:
        """True when its sensors say something else every tick, or say it late."""
        return self.position_noise > 0.0 or self.posture_noise > 0.0 or self.late > 0


# of a plant's tolerances, those a scenario may set
OF_A_PLANT = ("same_place", "held_back", "landed_as_planned", "body_off", "foot_off")


@dataclass(frozen=True, slots=True)
class Tracking:
    """What is put up with between plan and machine; None: what the plant says of itself."""

    same_place: float | None = None  # m, rad; as in ``Tolerances``
    held_back: float | None = None  # m; as in ``Tolerances``
    landed_as_planned: float | None = None  # m; as in ``Tolerances``
    body_off: float | None = None  # m; as in ``Tolerances``
    foot_off: float | None = None  # m; as in ``Tolerances``
    # steps cut short one after the other because the body was held back, before it says so and
    # waits for another command. More: see it scrape along a wall
    held_max: int = 3
    # times a posture is begun anew because ground or body were not as planned. Fewer: see it give
    # up after one push
    posture_tries: int = 24
    # m a foothold ahead may change its believed height. Smaller: see postures planned anew at every
    # look of the eye
    same_ground: float = 0.01

    def within(self, plant: Tolerances) -> Tolerances:
        """The tolerances of a plant with those set here in their place."""
        given = {name: getattr(self, name) for name in OF_A_PLANT}
        return replace(plant, **{name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True, slots=True)
class Planning:
    """How the supervisor spreads planning over ticks."""

    # postures looked at in a tick while a step runs, or what is as dear. More: the tick takes
    # longer than it need
    work: int = 120
    # the same while Level C waits for the step (F3). More: see ticks come late
    work_wanted: int = 240
    # ticks Level C waits on standing feet before it takes the best step found so far. More: see it
    # hesitate after the stick is pushed
    wait_max: int = 2
    # rad; commands this close share a planning job. Less: see it stand while a stick moves; more:
    # see a step go astray
    alike: float = math.radians(10.0)


@dataclass(frozen=True, slots=True)
class Gains:
    """Weights of Level C. The defaults are P control with both of H's z-direction reflexes on."""

    law: str = ""  # one of LAWS; "": the one the plant asks for
    position: float = 1.0  # of the error in (38); 1 closes it in one tick, above 2 see feet ring
    # C1 of (36), per tick; too small: see the torso stay tilted, 2 and more: see it rock up
    posture: float = 0.2
    # C2·Δz of (36), m a tick; too small: see legs hang over low ground, too large: see them stamp
    pliancy: float = 0.002
    # PID option: of what the servos missed; 0 is P control, above 1 see feet ring
    integral: float = 0.0
    derivative: float = 0.0  # PID option: of the change of what they missed
    # m; the integral never asks for more than this in one tick, however long a servo is stuck
    windup: float = 0.005


@dataclass(frozen=True, slots=True)
class Compliance:
    """Weights of Level C for a machine whose legs give and whose body has inertia; a tick each."""

    # k of the position error of a foot. More: see the body swing up at 5 Hz; less: see it drift
    position: float = 0.03
    # of that of a foot in the air, which moves nothing but its leg; as ``position`` where sensors
    # scatter. More: see it shiver; less: see one that its reach has held back come down short
    swing: float = 0.1
    height: float = 0.05  # of the mean height error of the feet that carry (37)
    # C1 of (36). More: see the body rock; less: see it stay tilted
    posture: float = 0.03
    rate: float = 0.3  # of the turning, which is damped. More: see legs shiver
    # C2·Δz of (36), m: reach of a leg that carries nothing of its load. More: see legs stamp
    pliancy: float = 0.0005
    # of the planned load that is pressed with. Less: see the body lean towards every lifted foot
    press: float = 1.0
    # of a reading that is believed where sensors scatter. More: see it shiver; less: see it lag
    filter: float = 0.1
    # of what loads say in a tick of where the centre of gravity truly is. More: see the body shift
    # with every push; less: see it lean for long; 0: the file's place and weight are believed
    centre: float = 0.003


@dataclass(frozen=True, slots=True)
class Contact:
    """How a foot behaves that has met what the map does not show (H §9)."""

    retreat: float = 0.05  # m back along the way after a hit; less and whiskers still touch
    # m back before each further lift. Less: see whiskers stay on what is climbed over
    keep_clear: float = 0.02
    # m a leg is lifted at a time while the obstacle is still there. More: see it step needlessly
    # high
    lift_step: float = 0.05
    # of the swing speed, "somewhat lower velocity" (H §9.2 b). More: see the second hit push the
    # body
    slower: float = 0.5
    # m of a sensed edge that is marked, along it. Less: see the next foot come down on it
    edge_length: float = 0.30
    # m of what a leg cannot be drawn over that is taken to stand as tall beside where it was felt.
    # Less: see every foot feel the same wall; more: see it go round what is hardly there
    wall_length: float = 0.90
    edge_depth: float = 0.10  # m of a sensed edge that is marked, across it
    # m farther from where there was no ground it searches with each miss. Smaller: see it feel out
    # every cell
    shy: float = 0.04
    # of one foot before it is set down wherever it may be; reached only between walls
    hits_max: int = 40
    # edges one foot comes down on in an encounter before it stays on one. More: see it try every
    # edge of a stone
    edges_max: int = 4
    # changes of state in one encounter before its foot stays in the air. More: see it feel about
    # for minutes
    turns_max: int = 60
    # encounters at one place of the body before it stops and says so. Fewer: see it give up among
    # stones; more: see it knock at a wall
    setbacks_max: int = 6
    # steps a leg at one place of the body before it stops and says so. Fewer: see it give up while
    # it regroups; more: see it mark time
    steps_max: int = 8
    # ticks a leg that is to carry and hangs is waited for before the next leg is lifted; then it
    # feels for ground. Fewer: see it stop where a leg had only to stretch
    wait_for_sole: int = 25
    # of its planned load, that a leg must carry before another is lifted. More: see it wait for
    # legs that hardly count
    load_share: float = 0.1
    # the same where sensors scatter and steps lead onto unknown ground. Less: see a foot that hangs
    # on an edge taken for one that stands; more: see it wait longer for every foot
    load_share_felt: float = 0.25
    # m a foot that has lost its load or slips is below or beside where it stood, before its
    # foothold is said to give way. Smaller: see it step off stones that rock; larger: see the body
    # tilt first
    gives_way: float = 0.01
    # m inside the other legs' polygon that the body must be for a foot to be drawn off a foothold
    # that gives way. Smaller: see it tip; larger: see it stay on what sinks
    spare: float = 0.005
    # m beyond the rim of the foot that whiskers feel. More: see it take shown ground for a surprise
    whisker_tip: float = 0.05

    def for_size(self, size: float) -> Contact:
        """The same for a machine of this size (``Machine.size``): lengths that nobody has set
        shrink with it.
        """
        usual = Contact()
        lengths = {name: getattr(self, name) for name in LENGTHS_OF_CONTACT}
        unset = {name: m for name, m in lengths.items() if m == getattr(usual, name)}
        return replace(self, **{name: size * m for name, m in unset.items()})


LENGTHS_OF_CONTACT = (
    "retreat",
    "keep_clear",
    "lift_step",
    "edge_length",
    "wall_length",
    "edge_depth",
    "shy",
    "gives_way",
    "spare",
    "whisker_tip",
)


@dataclass(frozen=True, slots=True)
class Navigation:
    """How Level B1 goes round what cannot be crossed: what a metre of a way round costs, in metres
    of plain way.
    """

    # m to either side of the line and of the body; obstacles wider than twice this are not gone
    # round
    width: float = 2.0
    bodies_ahead: float = 2.0  # body lengths looked ahead. Less: see it walk into dead ends
    # courses offered for one step before the walk is called blocked
    courses_max: int = 3
    # of the commanded speed, over ground just ahead that is unknown. More: see it step where it has
    # not looked
    slowest: float = 0.25
    no_way: float = 0.5  # m; a dead end nearer than this stops the walk
    # m a corner costs, and m per rad of it; more and the way round has fewer corners and longer
    # sides
    bend: float = 0.1
    bend_per_rad: float = 0.2
    off_line: float = 0.3  # m per m²; less and it strays, more and it cuts corners steeply
    # m a way that ends off the line costs; less and a small offset from the line is kept for ever
    # rather than paid for with two bends
    not_back: float = 0.5
    worth: float = 0.05  # m; a corner is left out when the straight way costs no more than this
    # of a way within 4 degrees of α_c, where the margin vanishes
    near_critical_cost: float = 1.5
    # of the usual density of footholds, below which they are scarce, and density that never is
    scarce: float = 0.5
    scarce_below: float = 0.3
    # more a metre costs where there is no foothold at all. Less: see it walk over what it must
    # creep on
    scarce_cost: float = 3.0
    unfit_cost: float = 20.0  # a metre costs on the way out of where the body should not stand
    # of a leg's rectangle seen: enough to plan by. More: see it slow down beside every shadow
    known_enough: float = 0.2


@dataclass(frozen=True, slots=True)
class Lookahead:
    """How far mode ``predictive`` looks on broken ground, and what it gives up for margin."""

    # steps it looks ahead, one at least. Fewer: see it walk into dead ends where most of the ground
    # is prohibited; more: see ticks come late
    depth: int = 6
    width: int = 6  # ways it follows from step to step, with the same signs
    per_shift: int = 6  # footholds of one leg and shift that are tried. More: see ticks come late
    # depths at which the full margin is tried beside the smallest. Fewer: see it walk on edges
    two_margins: int = 3
    # m of way given up for each m of margin that is missing; 0: see margins of millimetres where
    # there is no need
    margin_weight: float = 0.1
    # the same on open ground: more than any walk with less margin can gain
    open_margin_weight: float = 0.5
    # of the standard step; a way on slower than this is not good enough, and any foothold in reach
    # is tried. More: see it stand and think
    gets_on: float = 0.6
    # steps in which open ground should lead back to the standard walk. Fewer: see it walk on askew
    back_steps: int = 12
    # footholds of one leg and shift that are tried when anything goes. Fewer: see it stop among
    # poles; more: see ticks come late
    wide_max: int = 16


@dataclass(frozen=True, slots=True)
class Turning:
    """What steps on arcs keep and what they lose by; ``inset`` and ``thin_cost`` are less for small
    machines.
    """

    # m kept from every edge of the triangle, where the nominal walk has so much
    inset: float = 0.03
    inset_share: float = 0.6  # of the least margin of the nominal walk, where it has less
    # m of way a swing with hardly any inset is held to lose. Less: see the torso tip as a foot
    # lifts
    thin_cost: float = 0.15
    # of the nominal swing's way; a swing that moves the body less is looked at with no inset, and
    # beside body shifts
    useful: float = 0.5
    # of what the legs lack of the nominal phases, m of progress per m; 0: see legs bunch up
    phase_weight: float = 0.25
    far_enough: float = 0.45  # m around I_u in which footholds are looked for
    cells_max: int = 4  # footholds compared. More: see ticks come late


# what a way along a trace is to be best at: the first that is found, few changes of state, ...
SOONEST = "soonest"
FEWEST_STATES = "states"
GREATEST_MARGIN = "margin"
GREATEST_SPEED = "speed"
AIMS = (SOONEST, FEWEST_STATES, GREATEST_MARGIN, GREATEST_SPEED)


@dataclass(frozen=True, slots=True)
class TraceSearch:
    """How the trace planner looks for a way."""

    # m the body's reference may leave its trace sideways where on it there is no way; None: a
    # sixteenth of its length. 0: see it stop where a hand's breadth aside there are footholds
    sway: float | None = None
    # one of AIMS. Other than the first: see steps planned three times as long
    aim: str = SOONEST
    # m the trace may bend aside round what cannot be walked on it, and come back; None: 1.25
    # body lengths. 0: see it stop before a pole on its trace
    detour: float | None = None


@dataclass(frozen=True, slots=True)
class PlannerConfig:
    """All tunables; a scenario's ``[config]``."""

    tracking: Tracking = field(default_factory=Tracking)
    planning: Planning = field(default_factory=Planning)
    gains: Gains = field(default_factory=Gains)
    compliance: Compliance = field(default_factory=Compliance)
    contact: Contact = field(default_factory=Contact)
    navigation: Navigation = field(default_factory=Navigation)
    trace: TraceSearch = field(default_factory=TraceSearch)
    lookahead: Lookahead = field(default_factory=Lookahead)
    turning: Turning = field(default_factory=Turning)


DEFAULT = PlannerConfig()
# exact: the body is put where the plan has it, in a tick; inertia: the plan's velocity and loads
# are fed forward and errors closed slowly; printed: (33) to (38) as they stand, leg by leg
LAWS = ("exact", "inertia", "printed")
WORDS = {"law": LAWS, "aim": AIMS}  # what settings that are words may be


def configured(changes: Mapping[str, Any], config: PlannerConfig = DEFAULT) -> PlannerConfig:
    """A configuration with some settings changed: theme, then name, then a finite number.

    Raises ``ValueError`` that names what there is, for a theme or a name that there is not, and for
    what is no number.
    """
    changed: PlannerConfig = _changed(config, changes, "config")
    return changed


def _changed(settings: Any, changes: Any, where: str) -> Any:
    if not isinstance(changes, Mapping):
        raise ValueError(f"{where} should be a table, got {changes!r:.80}")
    known = {each.name: getattr(settings, each.name) for each in fields(settings)}
    new = {}
    for name, value in changes.items():
        if name not in known:
            raise ValueError(f"unknown key {name!r:.80} in {where}; there are: {', '.join(known)}")
        below = f"{where}.{name}"
        if is_dataclass(known[name]):
            new[name] = _changed(known[name], value, below)
        elif isinstance(known[name], str):
            new[name] = _word(value, WORDS[name], below)
        else:
            new[name] = _number(value, isinstance(known[name], int), below)
    return replace(settings, **new)


def _word(value: Any, words: tuple[str, ...], where: str) -> str:
    """One of these words; raises ``ValueError``."""
    if value not in words:
        raise ValueError(f"{where} should be one of {', '.join(words)}, got {value!r:.80}")
    return str(value)


def _number(value: Any, whole: bool, where: str) -> float:
    """A setting as a scenario gives it; raises ``ValueError``."""
    if isinstance(value, bool) or not isinstance(value, int if whole else int | float):
        wanted = "an integer" if whole else "a number"
        raise ValueError(f"{where} should be {wanted}, got {value!r:.80}")
    if not math.isfinite(value) or value < 0:
        raise ValueError(f"{where} should be finite and not negative, got {value!r:.80}")
    return value
