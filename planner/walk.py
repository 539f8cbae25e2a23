"""The conversation of Levels B and C: which step runs, which is ready, and what happens when the operator's mind changes.

While step k is walked, step k+1 is planned from the stance expected at N_{k+1} (H §4.4). Flags as in H §9.3: F1 Level C
has called for a plan, F2 the plan is ready, F3 Level C wants it now. Level C (``reflex``) knows only the running plan.

``Walk`` is changed in place, once a tick, by the console alone; viewers get a ``Snapshot``. (A frozen value rebuilt every
20 ms cost a tenth of the whole tick.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import replace

from .machine import Machine
from .reflex import Gains, Playback, ReflexState, holding_plan, reflex
from .settle import probe_plan, settle_plan
from .terrain import TerrainMap
from .vocabulary import Blocked, Command, Gait, Mode, Phase, Point, Sensing, Stance, StepPlan

DT = 0.02  # s, the tick of Level C (H §10.2)
SAME_PLACE = 1e-6  # m; a stance this close to the plan's end is taken to be it
LANDED_AS_PLANNED = 0.02  # m; a foot set down farther from J_u than this has not finished its step

PlanStep = Callable[[Stance, Command, TerrainMap], StepPlan | Blocked]
Thinking = Generator[None, None, StepPlan | Blocked]
Think = Callable[[Stance, Command, TerrainMap], Thinking]

_MODES = {
    Phase.SUPPORT: Mode.SUPPORT,
    Phase.UP: Mode.UP,
    Phase.RETURN: Mode.RETURN,
    Phase.DOWN: Mode.DOWN,
    Phase.SHIFT: Mode.SHIFT,
}


class Walk:
    """One walker's walk. ``advance`` is called once a tick and answers with foot velocities for the servos."""

    def __init__(self, machine: Machine, gait: Gait, stance: Stance, think: Think, gains: Gains | None = None) -> None:
        self.machine = machine
        self.gait = gait
        self.think = think
        self.gains = gains or Gains()
        self.stance = stance  # at the last N_k
        self.playback = Playback(holding_plan(stance))
        self.kind = "stand"  # stand | step | settle | probe | hover
        self.t = 0.0  # s into the running plan
        self.pace = 0.0  # plan seconds per second, this tick
        self.reflexes = ReflexState.begin(len(machine.legs))
        self.blocked: Blocked | None = None
        self.flags = (False, False, False)  # F1 F2 F3
        self.steps_begun = 0
        self.executed: StepPlan | None = None  # the step finished in this tick, its end as it came out
        self.heading = 0.0  # rad, absolute direction of the course walked
        self.emergent: dict[str, int] = {}
        self._thinking: Thinking | None = None
        self._ready: StepPlan | Blocked | None = None
        self._asked: tuple[Stance, Command, TerrainMap] | None = None
        self._learnt: set[tuple[int, int]] = set()

    # what others may ask

    @property
    def plan(self) -> StepPlan:
        return self.playback.plan

    @property
    def ready(self) -> StepPlan | None:
        """The step after the running one, once it is planned."""
        return self._ready if isinstance(self._ready, StepPlan) else None

    @property
    def mode(self) -> Mode:
        if self.kind in ("settle", "hover"):
            return Mode.BLOCKED if self.blocked else Mode.SETTLE
        if self.kind == "probe":
            return Mode.EMERGENT
        if self.kind == "stand":
            return Mode.BLOCKED if self.blocked else Mode.STAND
        return _MODES[self.plan.phases[self.playback.stretch(self.t)]]

    @property
    def speed(self) -> float:
        """Speed of the centre of gravity along the course now, m/s."""
        return self.plan.speed * self.pace if self.kind == "step" else 0.0

    def carrying(self) -> tuple[bool, ...]:
        """Legs meant to carry: all that do not swing, and swing legs that have landed early."""
        if self.kind == "stand":
            return (True,) * len(self.machine.legs)
        plan = self.plan
        lifted = plan.end.lifted
        in_air = plan.phases[self.playback.stretch(self.t)] not in (Phase.SUPPORT, Phase.SHIFT)
        landed = self.reflexes.landed
        return tuple(
            not (i in lifted and i not in plan.swing) and not (in_air and i in plan.swing and not landed[i])
            for i in range(len(self.machine.legs))
        )

    # one tick

    def advance(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> list[Point]:
        """Decide for one tick: foot velocities in body axes, m/s, in leg order."""
        self.executed = None
        if self.kind == "stand":
            if not command.holds:
                self._start(sensing, command, terrain)
        elif self.kind == "step":
            if command.holds:
                self._stop(sensing, terrain)
            else:
                self._consider(self.plan.end, command, terrain)
        elif self.kind == "hover":
            if not command.holds:
                self.kind, self.blocked = self._hovered, None
        elif all(self.reflexes.landed[i] for i in self.plan.swing):
            self._rest(self._actual(sensing, self._after_settling(sensing)))
            if not command.holds:
                self._start(sensing, command, terrain)
        t_next = self._time_after_tick(sensing, command, terrain)
        velocities, self.reflexes = reflex(self.playback, t_next, sensing, self.reflexes, self.gains, DT)
        self.t = t_next
        return velocities

    def _time_after_tick(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> float:
        if self.kind in ("stand", "hover"):
            self.pace = 0.0
            return self.t
        self.pace = self._pace_for(command)
        t_next = self.t + self.pace * DT
        if t_next < self.playback.duration - 1e-9:
            return t_next
        left = (t_next - self.playback.duration) / self.pace if self.pace > 0.0 else 0.0
        if self.kind != "step":
            return self._bottom_reached(sensing, terrain)
        return self._switch(sensing, command, terrain, max(left, 0.0))

    def _pace_for(self, command: Command) -> float:
        """How fast to play the plan: a change of speed inside a step takes effect at once, never above its v_max."""
        plan = self.plan
        if self.kind != "step" or plan.speed <= 0.0:
            return 1.0
        wanted = math.hypot(command.speed, self.machine.yaw_length * command.turn_rate)
        ratio = min(wanted, plan.speed_max) / plan.speed if plan.speed_max > 0.0 else wanted / plan.speed
        if ratio <= 1.0 + 1e-12:
            return min(ratio, 1.0)
        return min(ratio, max(1.0, self.playback.pace_max(self.t, self.machine)))

    # step switching: H §4.4, §9.3

    def _switch(self, sensing: Sensing, command: Command, terrain: TerrainMap, left: float) -> float:
        """N_{k+1}: the running step is over; ``left`` seconds of this tick belong to the next one."""
        plan = self.plan
        airborne = [i for i in plan.swing if i not in plan.end.lifted and not self.reflexes.landed[i]]
        if airborne:
            return self._probe(sensing, airborne[0])
        stance = self._actual(sensing, plan.end)
        self._finish(replace(plan, end=stance))
        self._consider(stance, command, terrain)
        self._think_on()
        answer = self._ready
        if answer is None:  # not thought through yet: hold on standing feet
            self._rest(stance, keep_thinking=True)
            return 0.0
        return self._begin(answer, stance, left, command)

    def _begin(self, answer: StepPlan | Blocked, stance: Stance, left: float, command: Command) -> float:
        self.stance = stance
        self._forget()
        if isinstance(answer, Blocked):
            self._rest(stance)
            self.blocked = answer
            self._asked = None
            return 0.0
        self.blocked = None
        self.playback = Playback(answer)
        self.reflexes = self.reflexes.next_step()
        self.kind = "step"
        self.t = 0.0
        self.steps_begun += 1
        self.heading = stance.body[3] + answer.crab_angle
        self.flags = (True, False, False)
        self.pace = self._pace_for(command)
        return min(left * self.pace, self.playback.duration)

    def _start(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> None:
        """From standing: plan the first step now; when it is ready, walk."""
        if self.blocked and self._refused == (command, terrain):
            return
        asked = self._asked
        still_asked = asked is not None and asked[1] == command and asked[2] is terrain
        stance = asked[0] if asked is not None and still_asked else self._actual(sensing, self.stance)
        self._consider(stance, command, terrain)
        self._think_on()
        if self._ready is not None:
            answer = self._ready
            self._begin(answer, stance, 0.0, command)
            self._refused = (command, terrain)

    _refused: tuple[Command, TerrainMap] | None = None  # what the last Blocked was an answer to

    def _consider(self, stance: Stance, command: Command, terrain: TerrainMap) -> None:
        """Ask for the step from ``stance`` unless just that was asked already; think a little further on it."""
        asked = self._asked
        if asked is None or asked[0] is not stance or asked[1] != command or asked[2] is not terrain:
            self._asked = (stance, command, terrain)
            self._thinking = self.think(stance, command, terrain)
            self._ready = None
            self.flags = (True, False, False)
        if self._ready is None:
            self._think_on()

    def _think_on(self) -> None:
        if self._thinking is None:
            return
        try:
            next(self._thinking)
        except StopIteration as done:
            self._ready = done.value
            self._thinking = None
            self.flags = (False, True, False)

    def _forget(self) -> None:
        self._asked, self._thinking, self._ready = None, None, None

    # stopping and settling

    def _stop(self, sensing: Sensing, terrain: TerrainMap) -> None:
        """The body stops in this tick; a foot in the air is set down where it is nearest to ground."""
        plan = self.plan
        airborne = [i for i in plan.swing if not self.reflexes.landed[i]]
        phase = plan.phases[self.playback.stretch(self.t)]
        if phase in (Phase.SUPPORT, Phase.SHIFT) or not airborne:
            self._rest(self._actual(sensing, self._after_settling(sensing)))
            return
        here = self._actual(sensing, plan.end)
        self._forget()
        settling = settle_plan(here, airborne[0], terrain, self.machine, self.gait)
        if isinstance(settling, Blocked):
            self._hover(settling)
        else:
            self._play(settling, "settle")

    def _hover(self, why: Blocked) -> None:
        """Hold everything, one foot in the air on three that carry: there is no ground for it here. Driving on resumes."""
        self._hovered, self.kind, self.blocked = self.kind, "hover", why

    _hovered = "step"

    def _play(self, plan: StepPlan, kind: str) -> None:
        self._interrupted = self.plan if self.kind == "step" else self._interrupted
        self.playback = Playback(plan)
        self.reflexes = self.reflexes.next_step()
        self.kind, self.t = kind, 0.0

    _interrupted: StepPlan | None = None

    def _after_settling(self, sensing: Sensing) -> Stance:
        """What the planner should remember after a step that was cut short: who swung last, if anybody did."""
        plan = self._interrupted if self.kind in ("settle", "probe") else self.plan
        if plan is None or plan.landing is None or not plan.swing:
            return self.stance
        u = plan.swing[0]
        at = self._actual(sensing, plan.end).feet[u]
        finished = math.hypot(at[0] - plan.landing[0], at[1] - plan.landing[1]) <= LANDED_AS_PLANNED
        return replace(plan.end, last_swing=u if finished else self.stance.last_swing, lifted=())

    def _rest(self, stance: Stance, keep_thinking: bool = False) -> None:
        if self.kind in ("settle", "probe") and self._interrupted is not None:
            self._finish(replace(self._interrupted, end=stance))
            self._interrupted = None
        self.stance = stance
        self.playback = Playback(holding_plan(stance))
        self.reflexes = self.reflexes.next_step()
        self.kind, self.t, self.pace = "stand", 0.0, 0.0
        self.blocked = None
        self._refused = None
        if not keep_thinking:
            self._forget()
            self.flags = (False, False, False)

    def _finish(self, plan: StepPlan) -> None:
        self.executed = plan

    # no ground at N_{k+1}: H §9.2, case 2

    def _probe(self, sensing: Sensing, leg: int) -> float:
        """The body stops at once and the foot goes straight down to the bottom of its mechanical reach."""
        self.emergent["no ground"] = self.emergent.get("no ground", 0) + 1
        self._play(probe_plan(self._actual(sensing, self.plan.end), leg, self.machine, self.gait), "probe")
        self.pace = 1.0
        return 0.0

    def _bottom_reached(self, sensing: Sensing, terrain: TerrainMap) -> float:
        """Nothing below: remember the cell as prohibited and put the foot somewhere else."""
        leg = self.plan.swing[0]
        here = self._actual(sensing, self.plan.end)
        cell = terrain.cell_at(here.feet[leg][0], here.feet[leg][1])
        if cell is not None:
            self._learnt.add(cell)
        settling = settle_plan(here, leg, terrain.forbid(self._learnt), self.machine, self.gait)
        if isinstance(settling, Blocked):
            self._hover(settling)
            return self.t
        self._play(settling, "settle")
        return 0.0

    def take_learnt(self) -> set[tuple[int, int]]:
        """Cells touch has shown to be no ground, once; the console adds them to the belief."""
        learnt, self._learnt = self._learnt, set()
        return learnt

    # where the machine really is

    def _actual(self, sensing: Sensing, expected: Stance) -> Stance:
        """The sensed stance, or ``expected`` itself when it came out so."""
        x, y, z, roll, pitch, yaw = sensing.body
        feet = feet_absolute(sensing)
        ex, ey, ez, eyaw = expected.body
        off = max(abs(x - ex), abs(y - ey), abs(z - ez), abs(yaw - eyaw), abs(roll), abs(pitch))
        for foot, wanted in zip(feet, expected.feet, strict=True):
            off = max(off, abs(foot[0] - wanted[0]), abs(foot[1] - wanted[1]), abs(foot[2] - wanted[2]))
        if off <= SAME_PLACE:
            return expected
        return replace(expected, body=(x, y, z, yaw), feet=feet)


def feet_absolute(sensing: Sensing) -> tuple[Point, ...]:
    """Foot tips in the absolute frame from position monitors, posture and dead reckoning."""
    x, y, z, roll, pitch, yaw = sensing.body
    cr, sr, cp, sp, cy, sy = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch), math.cos(yaw), math.sin(yaw)
    feet = []
    for fx, fy, fz in sensing.feet_b:
        ry, rz = cr * fy - sr * fz, sr * fy + cr * fz
        px, pz = cp * fx + sp * rz, cp * rz - sp * fx
        feet.append((x + cy * px - sy * ry, y + sy * px + cy * ry, z + pz))
    return tuple(feet)
