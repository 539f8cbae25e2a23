"""No leg is lifted while a foot that is meant to carry has no ground or no load (Level C, any
planner), nor, from a standstill, before it has given its own load away.

Such a leg reaches for the ground by itself, C2 of (36). It is waited for; when that does not help,
it is let down like one that found no ground at the end of its step.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..motion.swing_profile import legs_on_known_ground
from ..types import Sensing
from .contact_reflexes import ContactReflexes
from .execution import Execution
from .walk_state import Now, WalkState

SLOWEST = 1e-6  # m/s and rad/s; a body that begins a plan slower rests


class SoleWatch:
    """Whether legs may be lifted now, tick by tick."""

    def __init__(self, state: WalkState, contacts: ContactReflexes) -> None:
        self._state = state
        self._run = state.run
        self._contacts = contacts
        self._hung = 0  # ticks legs that are to carry have been waited for

    def keeps_standing(self, now: Now) -> bool:
        """True while a leg that should stand hangs: no step is begun."""
        soles = now.sensing.soles
        if all(soles):
            self._hung = 0
            return False
        lifted = self._run.stance.lifted
        legs = [leg for leg, on in enumerate(soles) if not on and leg not in lifted]
        return self._waits_for(legs, now)

    def keeps_down(self, t_next: float, now: Now) -> bool:
        """True when the step would lift legs by ``t_next``, s into it, while one that is to carry
        then does not.
        """
        run = self._run
        for time, legs, stand in run.tracker.rises:
            if run.t <= time < t_next and any(leg not in run.stance.lifted for leg in legs):
                if run.t == 0.0 and shifts_loads(run, legs):
                    return True
                settings = run.config.contact
                least = settings.load_share_felt if self._gropes(now) else settings.load_share
                waits = self._waits_for(not_carrying(run, now.sensing, stand, least), now)
                if waits and self._state.steps:
                    run.pace = 0.0
                return waits
        return False

    def time_begun(self, begun: float, now: Now) -> float:
        """Time into what was begun in the middle of a tick, s, by its end: a walker that gropes
        does not begin a step that would lift legs by then while one that is to carry does not.
        """
        if begun > 0.0 and self._state.steps and self._gropes(now):
            return self._run.t if self.keeps_down(begun, now) else begun
        return begun

    def _gropes(self, now: Now) -> bool:
        """True where a step leads onto unknown ground and sensors scatter: how far a foot hangs
        from where it should be tells little then, and its load has to.
        """
        run = self._run
        plan = run.tracker.plan
        return run.tolerances.scatters and not legs_on_known_ground(plan, now.terrain).issuperset(
            leg for leg in plan.swing if leg not in plan.end.lifted
        )

    def _waits_for(self, legs: list[int], now: Now) -> bool:
        if not legs:
            self._hung = 0
            return False
        self._hung += 1
        if self._hung > self._run.config.contact.wait_for_sole:
            self._hung = 0
            self._contacts.let_down(legs, now)
        return True


def not_carrying(run: Execution, sensing: Sensing, legs: Sequence[int], least: float) -> list[int]:
    """Those of ``legs`` whose soles are off, or that press with less than ``least`` of the planned
    load where loads are sensed; but not those that are to carry next to nothing.
    """
    if run.compliant is not None:
        idle = run.compliant.idle(run.t)
        legs = [leg for leg in legs if leg not in idle]
    hanging = [leg for leg in legs if not sensing.soles[leg]]
    if run.compliant is None or not sensing.loads:
        return hanging
    planned = run.compliant.loads
    light = [leg for leg in legs if sensing.loads[leg] < least * planned[leg]]
    return sorted({*hanging, *light})


def shifts_loads(run: Execution, legs: Sequence[int]) -> bool:
    """True while a body that begins its plan at rest still has loads to shift before ``legs``
    rise.
    """
    if run.compliant is None or run.tracker.plan.rates is None:
        return False
    rests = max(map(abs, run.tracker.velocity_at(0.0))) < SLOWEST
    return rests and run.compliant.presses(legs)
