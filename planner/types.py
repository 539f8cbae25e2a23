"""The words every room shares: what is commanded, where the machine stands, what it senses, what it
plans.

All are frozen. Legs are numbered from 0 in code and from 1 in files and on screens,
counter-clockwise from front-left (quadruped: 0 FL, 1 RL, 2 RR, 3 FR, the papers' 1-4). Angles in
radians, lengths in metres, times in seconds. A trailing ``_b`` marks the body frame (x forward, y
left, z up, origin at the centre of gravity); everything else is absolute.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum, unique
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

TICK = 0.02  # s, Δt: one tick of Level C and of the simulation (H §10.2)
# what may be asked of a machine that stands; standard: its feet in the layout of the last course
POSTURES = ("sit", "stand", "standard")

Point = tuple[float, float, float]
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Command:
    """What Level A asks for: a course relative to the torso and a speed along it.

    ``crab_angle`` α is the direction of travel in body axes, positive to the left; ``speed`` is
    never negative: to walk backwards, turn the crab angle. ``turn_rate`` is the yaw rate of the
    torso, positive to the left. Speed 0 with turn rate 0 means hold.

    >>> from walking_console import Command
    >>> to_the_left = Command(crab_angle=1.57, speed=0.1)
    >>> to_the_left.holds, Command().holds
    (False, True)
    """

    crab_angle: float = 0.0  # rad
    speed: float = 0.0  # m/s
    turn_rate: float = 0.0  # rad/s

    @property
    def straight_course(self) -> float | None:
        """The crab angle, rad; None of a command that turns."""
        return self.crab_angle if self.turn_rate == 0.0 else None

    @property
    def holds(self) -> bool:
        """True when nothing is to move."""
        return self.speed == 0.0 and self.turn_rate == 0.0


@dataclass(frozen=True, slots=True)
class Gait:
    """Gait settings a scenario may override: β, the lift of H §4.5, the height H, and the speed
    profile.
    """

    duty_factor: float  # β
    lift_up: float  # h_up, m
    lift_down: float  # h_dwn, m
    height: float  # H, m
    # eased swing phases (H §11 (3)); False: constant velocity between knots, as printed
    smooth: bool = True
    # the body bends its way into every support; False: straight along the reference, as printed
    sways: bool = False
    margin: float = 0.02  # m, of the polygon, that the way of a swaying body keeps where it can
    acceleration: float = 0.0  # m/s², most the body speeds up or slows down; 0: g·margin/height


class Phase(IntEnum):
    """What the swing legs do on one stretch of a plan: H table 3, and the four-leg shift that has
    no swing leg.
    """

    SUPPORT = 0
    UP = 1
    RETURN = 2
    DOWN = 3
    SHIFT = 4


class Mode(IntEnum):
    """What the walker is doing: one number in the log, one word on the screen."""

    STAND = 0
    SUPPORT = 1
    UP = 2
    RETURN = 3
    DOWN = 4
    SHIFT = 5
    SETTLE = 6  # stopped in mid-step: the swing foot is set down by its own clock
    BLOCKED = 7
    EMERGENT = 8
    TIPPING = 9
    FALLEN = 10
    SIT_DOWN = 11
    SIT = 12
    STAND_UP = 13
    REGROUP = 14  # going back into the standard layout


class HeldCourse(NamedTuple):
    """The course that is walked while the hand trembles, and how the hand has been, rad."""

    angle: float  # α that steps are planned for
    mean: float  # of the crab angles commanded at the last switching points
    tremor: float  # mean distance of those from their mean


@dataclass(frozen=True, slots=True)
class Stance:
    """The machine at a step-switching point N_k, and all a planner may remember (H §4.1, §5).

    ``feet`` are foot tips, in leg order. ``last_swing`` is u of the step before, −1 when none.
    ``quarter_turns`` is n of H table 1, kept for the hysteresis at α_c, −1 when none yet;
    ``held_course`` is what the hand that trembles at α_c is judged by, None when none is held.
    ``lifted`` are legs that stay in the air across the switch (K only). ``course`` is the distance
    already walked on the trace. ``still`` counts the steps since the body last got on (the
    lookahead's guard against walking on the spot). ``lean`` is the gradient of the body's floor
    along absolute x and y; (0, 0) is level. ``body`` is on the reference (L_G, or the trace), from
    which steps are decided; the body itself is ``sway`` beside it, along its floor, and goes at
    ``velocity``. ``kept_down`` are legs that the step from here is not to lift. Metres, seconds and
    radians, absolute frame.

    >>> from walking_console import Stance
    >>> feet = ((0.5, 0.4, 0.0), (-0.5, 0.4, 0.0), (-0.5, -0.4, 0.0), (0.5, -0.4, 0.0))
    >>> standing = Stance(body=(0.0, 0.0, 0.7, 0.0), feet=feet)
    >>> standing.lifted, standing.last_swing
    ((), -1)
    """

    body: tuple[float, float, float, float]  # x, y, z, yaw
    feet: tuple[Point, ...]
    last_swing: int = -1
    quarter_turns: int = -1
    lifted: tuple[int, ...] = ()
    course: float = 0.0
    still: int = 0
    lean: tuple[float, float] = (0.0, 0.0)
    sway: tuple[float, float] = (0.0, 0.0)  # x, y of the body from the reference, m
    velocity: tuple[float, float] = (0.0, 0.0)  # of the body, m/s
    held_course: HeldCourse | None = None
    kept_down: tuple[int, ...] = ()

    @property
    def place(self) -> tuple[float, float, float, float]:
        """Where the body itself is: x, y, z, yaw."""
        x, y, z, yaw = self.body
        dx, dy = self.sway
        return x + dx, y + dy, z + self.lean[0] * dx + self.lean[1] * dy, yaw

    def at_rest(self) -> Stance:
        """The same with the reference through the body, which stands still."""
        if self.sway == (0.0, 0.0) == self.velocity:
            return self
        return replace(self, body=self.place, sway=(0.0, 0.0), velocity=(0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class StepPlan:
    """One step as knots in the absolute frame, from N_k to N_{k+1}.

    Feet go straight between knots and so does the body, or along cubics that have ``foot_rates``
    and ``rates`` there.

    In the absolute frame a supporting foot does not move and a rising foot rises vertically (H
    §4.5). The swing foot's last knot is what it *aims* at: h_up below the expected ground, so that
    touch decides (H §4.5); ``end`` holds the stance expected at N_{k+1}, with the foot on the
    ground at its landing point J_u. The body leans over evenly from ``lean`` to that of ``end``.
    The arrays are write-protected.

    >>> import numpy as np
    >>> from walking_console import Command, StepPlanner, TerrainMap, load_machine
    >>> machine = load_machine("titan3")
    >>> terrain = TerrainMap.from_heights(np.zeros((120, 120)), 0.05, machine, (-3.0, -3.0))
    >>> planner = StepPlanner(machine)
    >>> plan = planner.plan(planner.stance_on(terrain), Command(speed=0.1), terrain)
    >>> [phase.name for phase in dict.fromkeys(plan.phases)], plan.feet.shape[1:]
    (['SUPPORT', 'UP', 'RETURN', 'DOWN'], (4, 3))
    >>> f"leg {plan.swing[0] + 1} swings in a step of {plan.times[-1]:.2f} s"
    'leg 3 swings in a step of 2.11 s'
    """

    swing: tuple[int, ...]  # legs in the air: u [H], i1..ik [K]; () is a four-leg shift
    times: Array  # (m,), s from the step-switching point, times[0] = 0
    body: Array  # (m, 4): x, y, z, yaw
    feet: Array  # (m, n_legs, 3)
    phases: tuple[Phase, ...]  # (m-1,), one per stretch between knots
    end: Stance
    crab_angle: float = 0.0  # rad, of the course in body axes
    support_shift: float = 0.0  # g0, m: travelled while u still stands
    shift: float = 0.0  # g, m: travelled in the whole step
    standard_margin: float = 0.0  # s0, m
    margin_min: float = 0.0  # least planned longitudinal margin of the step, m
    speed: float = 0.0  # v_G the plan was timed for, m/s
    speed_max: float = 0.0  # v_max of this step, H §7 (28) without the command, m/s
    search_start: Point | None = None  # I_u
    landing: Point | None = None  # J_u of the first swing leg
    lean: tuple[float, float] | None = None  # at its beginning; None: as at its end
    decision: dict[str, Any] | None = None  # why: filled only when asked
    rates: Array | None = None  # (m, 4), of the body at the knots: m/s, and rad/s of yaw
    foot_rates: Array | None = None  # (m, n_legs, 3), of the feet at the knots: m/s
    # least planned distance of the centre of gravity from the support polygon's edge, m; nan where
    # it was not worked out
    polygon_margin_min: float = math.nan
    departure: Departure | None = None  # why it is not the step of the paper's rules; None: it is

    def __post_init__(self) -> None:
        for array in (self.times, self.body, self.feet, self.rates, self.foot_rates):
            if array is not None:
                array.setflags(write=False)

    @property
    def mean_speed(self) -> float:
        """Over the whole step, m/s: less than ``speed`` where a swaying body needs more time."""
        return self.speed if self.rates is None else self.shift / float(self.times[-1])


@unique
class Departure(Enum):
    """Why a step is not that of the paper's rules, or not along the trace that was given, with the
    text that is shown for it.
    """

    NO_STEP = "the paper's rules find no step here"
    BACK_TO_STANDARD = "leads back to the standard pattern sooner than the paper's step"
    BROKEN_GROUND = "prohibited cells ahead: gets on better than the paper's step"
    ANY_FOOTHOLD = "near the paper's step nothing gets on: any foothold in reach"
    STEP_BACK = "nothing gets on: a step back, to get past this place"
    ASIDE = "nothing gets on: a course beside the commanded one"
    STRETCHED = "nothing gets on: legs stretched to their mechanical limit"
    TRACE_BENT = "on the trace there is no way: the trace bends round it"


@unique
class Reason(Enum):
    """Why there is no step, or no posture, with the text that is shown for it."""

    # no step
    NO_LEG = "no leg can take a step: {because}"
    NO_WAY_ON = (
        "no way on {where}by any leg, shift, step back, course within 30 degrees or stretched leg: "
        "{because}{cells}"
    )
    NO_WAY_ON_AN_ARC = "no sequence of swings and body shifts leads on along the arc"
    NO_WAY_ROUND = (
        "no way round within {width:g} m to either side: {distance:.1f} m ahead {because}"
    )
    NO_DIRECTION = "no step can be planned in any direction near the course"
    NO_SHIFT = "{shift}"  # of the body over the other legs, after which a leg could swing
    PROHIBITED_CELL = "the foot would come down on a prohibited cell"
    TORSO_TOUCHES = (
        "the torso would touch the ground: it needs {needs:.2f} m, the legs reach {reach:.2f} m"
    )
    NO_PROGRESS = (
        "met something the map did not show {times:.0f} times at one place, and got no farther{bar}"
    )
    MARKING_TIME = "took {steps:.0f} steps at one place, and got no farther{bar}"
    HELD_BACK = "the body is {off:.0f} mm {side} its legs, again and again{bar}"
    # along a trace
    ARRIVED = "the trace ends here"
    NO_WAY_ALONG = "{search}"  # the trace: what stopped the search for states
    # no place for a foot in the air
    NO_PLACE = "no ground within reach to set the lifted foot down"
    NO_PLACE_FOR_ANY = "no ground within reach to set any lifted foot down"
    GAVE_WAY = "the ground gave way under the foot, and no other foothold is in its reach"
    # no posture
    POSTURE_KEPT_FROM = "something keeps the machine from the posture asked for"
    CANNOT_LEVEL = "the legs cannot level the body here: drive on first"
    LEG_BESIDE = "it cannot sit down here: the leg would come to lie on the ground beside it"
    FOOT_IN_THE_AIR = "a foot is in the air and has found no ground: it must be set down first"
    NO_FOOTHOLD_BACK = "it cannot get back into the standard layout: no foothold for it is in reach"
    NO_FOOTHOLD_THERE = "there is no foothold near its place in the standard layout"
    NO_STANDING_BODY = (
        "no standing body is carried by what may be stepped on near its standard layout"
    )
    NO_WAY_BACK = "it cannot get back into the standard layout: {because}"
    OF_ITS_OWN = "{said}"  # of a planner that is not ours


@dataclass(frozen=True, slots=True)
class Blocked:
    """The planner's answer when there is no step: which constraint failed, for which leg, and the
    cells it refused.

    >>> import numpy as np
    >>> from walking_console import Blocked, Command, StepPlanner, TerrainMap, load_machine
    >>> machine = load_machine("titan3")
    >>> island = np.full((120, 120), np.nan)
    >>> island[45:75, 40:80] = 0.0
    >>> terrain = TerrainMap.from_heights(island, 0.05, machine, (-3.0, -3.0))
    >>> planner = StepPlanner(machine)
    >>> stance = planner.stance_on(terrain)
    >>> answer = planner.plan(stance, Command(speed=0.1), terrain)
    >>> while not isinstance(answer, Blocked):
    ...     answer = planner.plan(answer.end, Command(speed=0.1), terrain)
    >>> answer.reason.name, answer.leg in range(4), answer.text[:9]
    ('NO_WAY_ON', True, 'no way on')
    """

    reason: Reason
    leg: int | None = None
    decision: dict[str, Any] | None = None
    facts: Mapping[str, float | str] = field(default_factory=dict)  # what the text names

    @classmethod
    def saying(cls, text: str, leg: int | None = None) -> Blocked:
        """For a reason of a planner's own."""
        return cls(Reason.OF_ITS_OWN, leg, facts={"said": text})

    @property
    def text(self) -> str:
        """The reason as one line for people, its numbers filled in."""
        return self.reason.value.format(**self.facts)


@dataclass(frozen=True, slots=True, eq=False)
class GaitPreview:
    """What a trace walker foresees, K global prediction: where it will tread and over which s every
    foothold serves. For viewers.

    A bar is one foothold: its existence segment s1, s2, and the part placed, lifted of it on which
    the foot is to stand (m of s). ``states`` are the segments of whole states, all their feet in
    reach: standing, with legs lifted, standing ... in turn; where two that follow each other
    overlap, the change can be made. ``reached`` short of ``goal`` is a dead end, or the end of what
    is known.
    """

    line: tuple[Point, ...]  # the trace ahead: s, x, y
    footholds: tuple[tuple[Point, ...], ...]  # per leg, planned, in their order
    # per leg, the present foothold first
    bars: tuple[tuple[tuple[float, float, float, float], ...], ...]
    states: tuple[tuple[float, float], ...]
    reached: float  # s up to which the walk is sure, m
    goal: float  # s it was to lead to, m
    complete: bool
    reason: str  # why not


class Sensing(NamedTuple):
    """What the plant tells Level C once a tick: position monitors, soles, whiskers, posture (H §8
    (1)).
    """

    tick: int
    body: tuple[float, float, float, float, float, float]  # dead-reckoned x, y, z, roll, pitch, yaw
    feet_b: tuple[Point, ...]  # position monitors, body frame
    soles: tuple[bool, ...]
    # per leg, one bit per direction of eight (bit 0 = body +x, counter-clockwise), 0 = free
    whiskers: tuple[int, ...]
    slipping: tuple[bool, ...]
    # per leg, one bit per direction of eight in which the sole hangs over; () = no such sensor
    rims: tuple[int, ...] = ()
    loads: tuple[float, ...] = ()  # per leg, N, what the foot carries; () = no such sensor
    joints: tuple[Point, ...] = ()  # per leg, rad or m; () = no such sensor
    rates: Point = (0.0, 0.0, 0.0)  # of an inertial sensor about body x, y, z, rad/s
