"""Planners by name, with the modes they have and what they declare: the only place that names them.

Another planner is one module and one entry::

    @register_planner("amble", modes={"": Capabilities(leg_counts=(4,))}, stance=square_stance)
    class Amble(Planner): ...

A package that is installed beside this one needs no import: its entry point in the group
``walking_console.planners`` names such a module, which is loaded when the planners are first asked
for. Mode ``""`` is that of a planner without modes; it then answers to every mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from .crab.gait import standard_stance
from .crab.modes import MODES as CRAB_MODES
from .crab.modes import CrabPlanner
from .crab.slope_adaptation import walker_on_slopes
from .geometry.paths import SampledPath
from .geometry.transforms import Pose
from .initial_stance import Placement, StanceMaker, square_stance
from .motion.slope_strides import fitted_at_start
from .protocols import Capabilities, Planner, PlannerError, PlannerSetup
from .robot.model import Machine
from .trace.paths import trace_for
from .trace.walker import CAPABILITIES as TRACE
from .trace.walker import TracePlanner
from .types import Gait, Stance

ENTRY_POINTS = "walking_console.planners"
DEFAULT_PLANNER = "crab"
DEFAULT_MODE = next(iter(CRAB_MODES))

PLAIN: Mapping[str, Capabilities] = {"": Capabilities()}  # no modes, nothing special

Maker = Callable[[PlannerSetup], Planner]


@dataclass(frozen=True)
class PlannerEntry:
    """A planner as it is registered."""

    name: str
    make: Maker
    modes: Mapping[str, Capabilities]  # the default one first
    stance: StanceMaker  # the posture a walk begins in, for a machine in a mode

    @property
    def default_mode(self) -> str:
        """The mode taken when none is given."""
        return next(iter(self.modes))

    def mode(self, mode: str) -> str:
        """The mode meant by a name; raises ``PlannerError``."""
        if "" in self.modes:
            return ""
        if mode and mode not in self.modes:
            raise PlannerError(
                f"unknown {self.name} mode {mode!r}; there are: {', '.join(self.modes)}"
            )
        return mode or self.default_mode


_ENTRIES: dict[str, PlannerEntry] = {}


def register_planner(
    name: str,
    *,
    modes: Mapping[str, Capabilities] = PLAIN,
    stance: StanceMaker = square_stance,
) -> Callable[[Maker], Maker]:
    """Enter a planner under a name; decorates its class, or a function that makes it.

    ``modes`` are the modes it has, the default one first, each with what it declares to be able to
    do; ``stance`` makes the posture a walk begins in. Raises ``PlannerError`` when the name is
    taken or no mode is given.

    >>> from walking_console import Blocked, Planner, StepPlanner, load_machine, register_planner
    >>> @register_planner("stubborn")
    ... class Stubborn(Planner):
    ...     def __init__(self, setup):
    ...         self.machine = setup.machine
    ...
    ...     def plan_step(self, stance, command, terrain):
    ...         return Blocked.saying(f"{self.machine.name} does not want to")
    >>> StepPlanner(load_machine("titan3"), "stubborn").capabilities.may_lean
    False
    >>> unregister_planner("stubborn")
    """
    if name in _ENTRIES:
        raise PlannerError(f"a planner {name!r} is registered already")
    if not modes:
        raise PlannerError(f'planner {name!r} needs at least one mode; "" when it has no modes')

    def enter(make: Maker) -> Maker:
        _ENTRIES[name] = PlannerEntry(name, make, dict(modes), stance)
        return make

    return enter


def unregister_planner(name: str) -> None:
    """Take a planner out again; raises ``PlannerError`` when there is none of this name."""
    if _ENTRIES.pop(name, None) is None:
        raise PlannerError(_unknown(name))


@cache
def _load_installed() -> None:
    """Import what installed packages offer; once."""
    for point in entry_points(group=ENTRY_POINTS):
        try:
            point.load()
        except Exception as error:
            raise PlannerError(f"cannot load planner {point.name!r}: {error}") from error


def planner_names() -> tuple[str, ...]:
    """Every planner there is, ours first."""
    _load_installed()
    return tuple(_ENTRIES)


def mode_names() -> tuple[str, ...]:
    """Every mode of any planner."""
    names = (mode for name in planner_names() for mode in _ENTRIES[name].modes if mode)
    return tuple(dict.fromkeys(names))


def rigid_gait_names() -> tuple[str, ...]:
    """Every periodic gait that any planner can be held to."""
    declared = (mode for name in planner_names() for mode in _ENTRIES[name].modes.values())
    return tuple(dict.fromkeys(gait for mode in declared for gait in mode.rigid_gaits))


def planner_entry(name: str) -> PlannerEntry:
    """The planner of this name; raises ``PlannerError`` that lists those there are."""
    if name not in planner_names():
        raise PlannerError(_unknown(name))
    return _ENTRIES[name]


def _unknown(name: str) -> str:
    return f"unknown planner {name!r:.80}; there are: {', '.join(_ENTRIES)}"


def capabilities(name: str, mode: str = "") -> Capabilities:
    """What a planner declares for a mode (its default when not given); raises ``PlannerError``."""
    entry = planner_entry(name)
    return entry.modes[entry.mode(mode)]


def choices_that(offer: Callable[[Capabilities], bool]) -> tuple[tuple[str, str], ...]:
    """Planner and mode of all that declare something, to name them in a message."""
    return tuple(
        (name, mode)
        for name in planner_names()
        for mode, declared in _ENTRIES[name].modes.items()
        if offer(declared)
    )


def only_leans_with() -> str:
    """Why other planners refuse to let the body follow the ground."""
    able = spoken(choices_that(lambda planner: planner.may_lean))
    return f"the body follows the ground only with {able}"


def spoken(choices: Iterable[tuple[str, str]]) -> str:
    """Planners in their modes as a sentence names them."""
    return " or ".join(
        f"the {planner} planner" + (f' in mode "{mode}"' if mode else "")
        for planner, mode in choices
    )


def make_planner(name: str, setup: PlannerSetup) -> Planner:
    """A planner by name; raises ``PlannerError`` for one that cannot be made so."""
    entry = planner_entry(name)
    mode = entry.mode(setup.mode)
    return entry.make(setup if mode == setup.mode else replace(setup, mode=mode))


def initial_stance(name: str, mode: str, machine: Machine, gait: Gait, place: Placement) -> Stance:
    """The posture a walk of this planner begins in; raises ``PlannerError``."""
    entry = planner_entry(name)
    return entry.stance(machine, gait, place, entry.modes[entry.mode(mode)])


def sampled_path(trace: Mapping[str, Any], machine: Machine, start: Pose) -> SampledPath:
    """A scenario's trace, sampled: too slow for a tick when it is long. Raises ``PlannerError``."""
    try:
        return trace_for(trace, machine, start)
    except ValueError as error:
        raise PlannerError(str(error)) from None


# ours


def _standard_stance(machine: Machine, gait: Gait, place: Placement, mode: Capabilities) -> Stance:
    """The standard posture of the first course (gait-dependent, H §4.3), on strides that fit."""
    if mode.fits_slopes:
        walker = walker_on_slopes(machine, gait)
        machine = fitted_at_start(walker, place.crab_angle, place.pose, place.height_at)
    return standard_stance(machine, gait, place)


@register_planner("crab", modes=CRAB_MODES, stance=_standard_stance)
def _crab(setup: PlannerSetup) -> Planner:
    return CrabPlanner(setup, CRAB_MODES[setup.mode])


register_planner("trace", modes={"": TRACE})(TracePlanner)
