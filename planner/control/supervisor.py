"""The conversation of Levels B and C: which step runs, which is ready, and what happens when the
operator's mind changes.

While step k is walked, step k+1 is planned from the stance expected at N_{k+1} (H §4.4). Flags as
in H §9.3: F1 Level C has called for a plan, F2 the plan is ready, F3 Level C wants it now. Level C
(``reflex``) knows only the running plan.

``GaitSupervisor`` is changed in place, once a tick, by the console alone; viewers get a
``Snapshot``. (A frozen value rebuilt every 20 ms cost a tenth of the whole tick.)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ..geometry.transforms import attitude_of
from ..initial_stance import Placement
from ..motion.body_tilt import LEVEL, leaned, leaning, unleaned
from ..motion.foot_placement import place_feet
from ..motion.postures import Choosing, Poses, regroup, sit, stand
from ..motion.step_builder import changed, holding_plan
from ..protocols import Planner, PlanningJob
from ..robot.model import Machine
from ..terrain.map import TerrainMap
from ..types import (
    POSTURES,
    TICK,
    Blocked,
    Command,
    Gait,
    Mode,
    Phase,
    Point,
    Sensing,
    Stance,
    StepPlan,
)
from .contact_reflexes import (
    HITS_MAX,
    KINDS,
    SHY,
    Encounter,
    Event,
    Situation,
    State,
    at_top,
    cell_of,
    cells_near,
    edge_cells,
    felt_ahead,
    motion,
)
from .foot_controller import (
    Gains,
    ReflexState,
    TrajectoryTracker,
    reflex,
)

DT = TICK  # s, the tick of Level C (H §10.2)
SAME_PLACE = 1e-6  # m; a stance this close to the plan's end is taken to be it
# m the body may be from where the plan has it; smaller and servo noise stops the walk
HELD_BACK = 0.01
# steps cut short for it, one after the other, before it says so and waits for another command
HELD_MAX = 3
WHISKER_TIP = 0.05  # m beyond the rim of the foot: how far whiskers feel
LANDED_AS_PLANNED = 0.02  # m; a foot set down farther from J_u than this has not finished its step

# pieces of thought a tick while a step runs; more and the tick takes longer than it need
PIECES = 4
PIECES_WANTED = 16  # the same while Level C waits for the step (F3): still well inside a tick
WAIT_MAX = 2  # ticks Level C waits on standing feet before it takes the best step thought of so far
# courses this close share a thought; less: see it stand while a stick moves, more: see a step go
# astray
ALIKE = math.radians(10.0)
# times a posture is begun anew because the ground, or a push, was not as planned, before it says so
POSE_TRIES = 24
# m a foot may seem to be beside the plan of a posture: sensors err; farther, and the rest is
# planned anew
POSE_OFF = 0.015
BODY_OFF = 0.002  # m the body may be; larger: see a push eat up the margin of the next swing
SAME_GROUND = 0.01  # m; a foothold ahead whose believed height has changed by more is planned anew

Layout = Callable[[Placement], Stance]

_MODES = {
    Phase.SUPPORT: Mode.SUPPORT,
    Phase.UP: Mode.UP,
    Phase.RETURN: Mode.RETURN,
    Phase.DOWN: Mode.DOWN,
    Phase.SHIFT: Mode.SHIFT,
}
_POSING = {"sit": Mode.SIT_DOWN, "stand": Mode.STAND_UP, "standard": Mode.REGROUP}


class GaitSupervisor:
    """One walker's walk. ``advance`` is called once a tick and answers with foot velocities for the
    servos.
    """

    def __init__(
        self,
        machine: Machine,
        gait: Gait,
        stance: Stance,
        planner: Planner,
        gains: Gains | None = None,
        *,
        layout: Layout,
        crab_angle: float = 0.0,
    ) -> None:
        self.machine = machine
        self.gait = gait
        self.planner = planner
        self.gains = gains or Gains()
        self.layout = layout  # the standard posture of a course
        self.crab_angle = crab_angle  # rad, of the last course commanded
        self.stance = stance  # at the last N_k
        self.playback = TrajectoryTracker(holding_plan(stance))
        self.kind = "stand"  # stand | step | settle | emergent | hover | pose
        self.posture = "stand"  # the posture it is in, or going to: stand | sit | standard
        self.wanted = ""  # the posture asked for and not yet reached
        # the body has sunk on command and not been raised again: it rises before it walks
        self.low = False
        self.encounter: Encounter | None = None  # the emergent motion under way
        self.t = 0.0  # s into the running plan
        self.pace = 0.0  # plan seconds per second, this tick
        self.reflexes = ReflexState.begin(len(machine.legs))
        self.blocked: Blocked | None = None
        self.flags = (False, False, False)  # F1 F2 F3
        self.steps_begun = 0
        # the step finished in this tick, its end as it came out
        self.executed: StepPlan | None = None
        self.heading = 0.0  # rad, absolute direction of the course walked
        self.emergent: dict[str, int] = {}
        self._thinking: PlanningJob | None = None
        self._ready: StepPlan | Blocked | None = None
        self._asked: tuple[Stance, Command, TerrainMap] | None = None
        # a step thought through for a command much like this one
        self._spare: tuple[Command, StepPlan] | None = None
        # what the last Blocked was an answer to
        self._refused: tuple[Command, TerrainMap] | None = None
        self._waited = 0  # ticks Level C has waited for the next step
        # steps running that were cut short because the body was not where they had it
        self._held = 0
        self._hovered = "step"  # what it was doing when it began to hover
        # the step a settling or emergent motion cut short
        self._interrupted: StepPlan | None = None
        self._choosing: Choosing | None = None  # the order of the legs is being searched for
        self._poses: Poses = ()  # the rest of the running posture's plans
        self._pose_ground: TerrainMap | None = None  # the map they were made on
        self._rises_to_walk = False  # a command to move wants the posture it is taking
        self._tries = 0  # times the posture wanted has been begun
        self._learnt: set[tuple[int, int]] = set()
        # near where this encounter found no ground: searched last, not remembered
        self._shunned: set[tuple[int, int]] = set()

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
        if self.kind == "hover":
            return Mode.BLOCKED
        if self.kind == "settle":
            return Mode.SETTLE
        if self.kind == "emergent":
            return Mode.EMERGENT
        if self.kind == "stand":
            return (
                Mode.BLOCKED
                if self.blocked
                else Mode.SIT
                if self.posture == "sit" and not self.wanted
                else Mode.STAND
            )
        if self.kind == "pose":
            return _POSING[self.posture]
        return _MODES[self.plan.phases[self.playback.stretch(self.t)]]

    @property
    def speed(self) -> float:
        """Speed of the centre of gravity along the course now, m/s."""
        return self.plan.speed * self.pace if self.kind == "step" else 0.0

    def carrying(self) -> tuple[bool, ...]:
        """Legs meant to carry: all that do not swing, and swing legs that have landed early."""
        if self.kind == "stand":
            return tuple(i not in self.stance.lifted for i in range(len(self.machine.legs)))
        plan = self.plan
        lifted = plan.end.lifted
        in_air = plan.phases[self.playback.stretch(self.t)] not in (Phase.SUPPORT, Phase.SHIFT)
        landed = self.reflexes.landed
        return tuple(
            not (i in lifted and i not in plan.swing)
            and not (in_air and i in plan.swing and not landed[i])
            for i in range(len(self.machine.legs))
        )

    # one tick

    def advance(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> list[Point]:
        """Decide for one tick: foot velocities in body axes, m/s, in leg order."""
        self.executed = None
        command = self.planner.heed(command)
        if self._rises_to_walk and command.holds:
            self.halt()
        elif not command.holds and (self.wanted or self.low or self.kind == "pose"):
            self._heed(command, terrain)
        if self.kind == "stand":
            if self.wanted:
                self._take_posture(sensing, terrain)
            elif not command.holds:
                self._start(sensing, command, terrain)
        elif self.kind == "pose":
            self._pose_on(sensing, terrain)
        elif self.kind == "step":
            if command.holds:
                self._stop(sensing, terrain)
            elif self._held_back(sensing):
                self._held += 1
                self._stop(sensing, terrain)
            elif not self._surprised(sensing, terrain):
                self._consider(self.plan.end, command, terrain)
        elif self.kind == "emergent":
            self._react(sensing, command, terrain)
        elif self.kind == "hover":
            if not command.holds:
                self._go_on(sensing, terrain)
        elif all(self.reflexes.landed[i] for i in self.plan.swing):
            self._rest(self._actual(sensing, self._after_settling(sensing)))
            if not command.holds and not self.wanted:
                self._start(sensing, command, terrain)
        t_next = self._time_after_tick(sensing, command, terrain)
        velocities, self.reflexes = reflex(
            self.playback, t_next, sensing, self.reflexes, self.gains, DT
        )
        self.t = t_next
        return velocities

    def _time_after_tick(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> float:
        if self.kind in ("stand", "hover"):
            self.pace = 0.0
            return self.t
        self.pace = self._pace_for(command)
        t_next, duration = self.t + self.pace * DT, self.playback.duration
        left = (t_next - duration) / self.pace if self.pace > 0.0 else 0.0
        if self.pace > 1.0:
            t_next, left = self.playback.onward(self.t, DT, self.pace, self.machine)
        if t_next < duration - 1e-9:
            return t_next
        if self.kind == "emergent":
            return self.playback.duration
        if self.kind == "settle":
            return self._no_ground(sensing, terrain)
        if self.kind == "pose":
            return self._next_pose(sensing, terrain, max(left, 0.0))
        return self._switch(sensing, command, terrain, max(left, 0.0))

    def _pace_for(self, command: Command) -> float:
        """How fast to play the plan: a change of speed inside a step takes effect at once, never
        above its v_max.

        A body that waits for its foot is not kept waiting longer by a slower command.
        """
        plan = self.plan
        if self.kind != "step" or plan.speed <= 0.0:
            return 1.0
        wanted = math.hypot(command.speed, self.machine.yaw_length * command.turn_rate)
        ratio = (
            min(wanted, plan.speed_max) / plan.speed
            if plan.speed_max > 0.0
            else wanted / plan.speed
        )
        if ratio <= 1.0 + 1e-12:
            return 1.0 if ratio >= 1.0 or not self.playback.body_moves(self.t) else ratio
        return min(ratio, max(1.0, self.playback.pace_max(self.t, self.machine)))

    # step switching: H §4.4, §9.3

    def _switch(
        self, sensing: Sensing, command: Command, terrain: TerrainMap, left: float
    ) -> float:
        """N_{k+1}: the running step is over; ``left`` seconds of this tick belong to the next one."""
        plan = self.plan
        airborne = [
            i for i in plan.swing if i not in plan.end.lifted and not self.reflexes.landed[i]
        ]
        if airborne:
            return self._no_ground(sensing, terrain)
        stance = self._arrived(sensing)
        self._finish(changed(plan, end=stance))
        self._held = 0
        self._consider(stance, command, terrain, PIECES_WANTED)
        answer = self._answer(command)
        if answer is None:  # not thought through yet: hold on standing feet
            self._rest(stance, keep_thinking=True)
            return 0.0
        return self._begin(answer, stance, left, command)

    def _begin(
        self, answer: StepPlan | Blocked, stance: Stance, left: float, command: Command
    ) -> float:
        self.stance = stance
        self._waited = 0
        self._forget()
        if isinstance(answer, Blocked):
            self._rest(stance)
            self.blocked = answer
            self._asked = None
            return 0.0
        self.blocked = None
        self.playback = TrajectoryTracker(answer)
        self.reflexes = self.reflexes.next_step()
        self.kind = "step"
        self.t = 0.0
        self.steps_begun += 1
        self.heading = stance.body[3] + answer.crab_angle
        self.posture = "stand"
        if command.speed > 0.0:
            self.crab_angle = command.crab_angle
        self.flags = (True, False, False)
        self.pace = self._pace_for(command)
        return min(left * self.pace, self.playback.duration)

    def _start(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> None:
        """From standing: plan the first step now; when it is ready, walk."""
        if self.blocked and self._refused == (command, terrain):
            return
        if self._held >= HELD_MAX:
            self._held, self._refused = 0, (command, terrain)
            self.blocked = Blocked(
                "something holds the body back: a leg or the torso is against an obstacle"
            )
            return
        asked = self._asked
        still_asked = asked is not None and asked[2] is terrain and self._alike(asked[1], command)
        stance = (
            asked[0] if asked is not None and still_asked else self._actual(sensing, self.stance)
        )
        self._consider(stance, command, terrain, PIECES_WANTED)
        self._waited += 1
        if self._waited >= WAIT_MAX and self._answer(command) is None:
            self._think_on(PIECES_WANTED, wanted_now=True)
        answer, asked = self._answer(command), self._asked
        if answer is not None and asked is not None:
            self._begin(answer, stance, 0.0, command)
            self._refused = (asked[1], terrain)

    def _consider(
        self, stance: Stance, command: Command, terrain: TerrainMap, pieces: int = PIECES
    ) -> None:
        """Ask for the step from ``stance`` unless just that was asked already; think a little
        further on it.

        While the stick moves a little, or only farther out, a thought is finished all the same, and
        kept while the next is begun.
        """
        asked, before = self._asked, self._ready
        anew = asked is None or asked[0] is not stance or asked[2] is not terrain
        if anew or (
            asked is not None
            and asked[1] != command
            and (before is not None or not self._alike(asked[1], command))
        ):
            if anew or asked is None:
                self._spare = None
            elif isinstance(before, StepPlan):
                self._spare = asked[1], before
            self._asked = (stance, command, terrain)
            self._thinking = self.planner.plan(stance, command, terrain)
            self._ready = None
            self.flags = (True, False, False)
        if self._ready is None:
            self._think_on(pieces)

    def _answer(self, command: Command) -> StepPlan | Blocked | None:
        """The step that is ready, for this command or for one alike; None when there is none yet."""
        if self._ready is not None or self._spare is None:
            return self._ready
        return self._spare[1] if self._alike(self._spare[0], command) else None

    def _alike(self, one: Command, other: Command) -> bool:
        """True when a step for one command will do for the other: another speed, and all but the
        same course.
        """
        if one == other:
            return True
        if one.holds or other.holds:
            return False
        rho = self.machine.yaw_length
        ax, ay, at = (
            one.speed * math.cos(one.crab_angle),
            one.speed * math.sin(one.crab_angle),
            rho * one.turn_rate,
        )
        bx, by, bt = (
            other.speed * math.cos(other.crab_angle),
            other.speed * math.sin(other.crab_angle),
            rho * other.turn_rate,
        )
        return ax * bx + ay * by + at * bt >= math.cos(ALIKE) * math.hypot(ax, ay, at) * math.hypot(
            bx, by, bt
        )

    def _think_on(self, pieces: int, wanted_now: bool = False) -> None:
        if self._thinking is None:
            return
        try:
            for _ in range(pieces):
                if wanted_now:
                    self._thinking.send(True)
                else:
                    next(self._thinking)
        except StopIteration as done:
            self._ready = done.value
            self._thinking = None
            self.flags = (False, True, False)

    def _forget(self) -> None:
        self._asked, self._thinking, self._ready, self._spare = None, None, None, None

    # postures on command

    def pose(self, posture: str) -> str:
        """Take a posture as soon as it stands; why not, or '' when it will. What else it was going
        to is dropped.
        """
        if posture not in POSTURES:
            return f"unknown posture {posture!r}; there are: {', '.join(POSTURES)}"
        if self.kind == "hover":
            return "a foot is in the air and has found no ground: drive on first"
        if self.kind == "stand":
            self.blocked = None
        self.wanted, self._rises_to_walk, self._tries = posture, False, 0
        self._choosing = None
        return ""

    def halt(self) -> None:
        """Whatever posture it is taking, it stops in the next tick, and stays as it is."""
        self.wanted, self._rises_to_walk, self._choosing = "", False, None

    @property
    def posing(self) -> bool:
        """True while a posture is being taken, or is to be."""
        return self.kind == "pose" or self.wanted != ""

    def _heed(self, command: Command, terrain: TerrainMap) -> None:
        """A command to move: the posture asked for is dropped, but a machine that has sunk rises
        first, and then walks.
        """
        if not (self.low and self.kind in ("stand", "pose")):
            return self.halt()
        if self.wanted != "stand" and not (self.blocked and self._refused == (command, terrain)):
            self.pose("stand")
            self._refused = command, terrain
        self._rises_to_walk = self.wanted == "stand"

    def _take_posture(self, sensing: Sensing, terrain: TerrainMap) -> None:
        """From standing: plan the posture that is wanted, and begin; the order of the legs takes a
        few ticks to find.
        """
        if self._choosing is None:
            if self._tries >= POSE_TRIES:
                return self._give_up(
                    Blocked("something keeps the machine from the posture asked for")
                )
            self._tries += 1
            self._pose_ground = terrain
            self._forget()
        here = self._actual(sensing, self.stance)
        stance = self.stance = self.stance if _as_planned(here, self.stance) else here
        upright: Poses = ()
        if stance.lean != LEVEL:
            levelling = leaned(stance, LEVEL, self.machine)
            if levelling is None:
                return self._give_up(Blocked("the legs cannot level the body here: drive on first"))
            upright, stance = (levelling,), levelling.end
        answer: Poses | Blocked | None
        if self.wanted == "sit":
            answer = sit(stance, terrain, self.machine, self.gait)
        elif self.wanted == "stand" or self.low:
            answer = stand(stance, terrain, self.machine, self.gait)
        else:
            answer = self._regrouped(stance, terrain)
        if isinstance(answer, Blocked):
            return self._give_up(answer)
        if answer is not None:
            self.posture = "stand" if self.low and self.wanted == "standard" else self.wanted
            self.low = self.low or self.wanted == "sit"
            self.blocked = None
            self._poses = (*upright, *answer)
            self._play_pose()

    def _regrouped(self, stance: Stance, terrain: TerrainMap) -> Poses | Blocked | None:
        """The plans into the standard layout at the present pose; None while the order of the legs
        is being searched for.
        """
        if self._choosing is None:
            x, y, _, yaw = stance.body
            goal = self.layout(Placement((x, y, yaw), terrain.height_at, self.crab_angle))
            self._choosing = regroup(
                stance, goal, terrain, self.machine, self.gait, self.crab_angle
            )
        try:
            for _ in range(PIECES_WANTED):
                next(self._choosing)
        except StopIteration as done:
            self._choosing = None
            answer: Poses | Blocked = done.value
            return answer
        return None

    def _give_up(self, why: Blocked) -> None:
        self.halt()
        self.blocked = why

    def _play_pose(self) -> None:
        """The next plan of the posture; when there is none left, it has been taken."""
        if not self._poses:
            return self._posed(self.stance)
        plan, self._poses = self._poses[0], self._poses[1:]
        self._play(plan, "pose")
        self.steps_begun += self.posture == "standard"

    def _posed(self, stance: Stance) -> None:
        """The posture is taken; one that was only on the way to another leaves that wanted."""
        self.low = self.posture == "sit"
        if self.wanted == self.posture:
            self.wanted = ""
        self._rest(stance)

    def _pose_on(self, sensing: Sensing, terrain: TerrainMap) -> None:
        """One tick of a posture being taken: is it still wanted, does all go as planned?"""
        on_the_way = self.wanted == "standard" and self.posture == "stand" and self.low
        if self.wanted != self.posture and not on_the_way or self._held_back(sensing):
            self.posture = "stand"
            self._stop(sensing, terrain)
        else:
            self._surprised(sensing, terrain)

    def _next_pose(self, sensing: Sensing, terrain: TerrainMap, left: float) -> float:
        """A plan of the posture is over; ``left`` seconds of this tick belong to the next one, if
        all came out as planned.
        """
        plan = self.plan
        if any(not self.reflexes.landed[leg] for leg in plan.swing):
            return self._no_ground(sensing, terrain)
        stance = self._arrived(sensing)
        good = _as_planned(stance, plan.end)
        if good:
            stance = plan.end  # what sensors say beside it is noise
        if self.posture == "standard":
            self._finish(changed(plan, end=stance))
        self.stance = stance
        if not self._poses:
            self._posed(stance)
            return 0.0
        if not (good and self._still_good(terrain)):
            self._rest(stance)  # and plan anew from there: the posture is still wanted
            return 0.0
        self._play_pose()
        return min(left, self.playback.duration)

    def _still_good(self, terrain: TerrainMap) -> bool:
        """True while every foothold still to come is believed to be what it was taken for."""
        if terrain is self._pose_ground:
            return True
        places = [plan.landing for plan in self._poses if plan.landing is not None]
        return all(
            terrain.allows(x, y) and abs(terrain.height_at(x, y) - z) <= SAME_GROUND
            for x, y, z in places
        )

    # stopping and settling

    def _held_back(self, sensing: Sensing) -> bool:
        """True when the body is not where the running step has it: pushed, slid, or against an
        obstacle.
        """
        x, y, _, _ = self.playback.body_at(self.t)
        return abs(x - sensing.body[0]) > HELD_BACK or abs(y - sensing.body[1]) > HELD_BACK

    def _stop(self, sensing: Sensing, terrain: TerrainMap) -> None:
        """The body stops in this tick; feet in the air are set down where they are nearest to
        ground.
        """
        plan = self.plan
        on_feet = plan.phases[self.playback.stretch(self.t)] in (Phase.SUPPORT, Phase.SHIFT)
        airborne = [
            i
            for i in plan.swing
            if (i in self.stance.lifted if on_feet else not self.reflexes.landed[i])
        ]
        if not airborne:
            self._rest(self._actual(sensing, self._after_settling(sensing)))
            return
        here = self._actual(sensing, plan.end)
        self._forget()
        frame = leaning(here, terrain, self.machine)
        settling = place_feet(frame.stance, airborne, frame.terrain, frame.machine, self.gait)
        if isinstance(settling, Blocked):
            self._hover(settling)
        else:
            self._play(frame.restored(settling, here), "settle")

    def _hover(self, why: Blocked) -> None:
        """Hold everything, one foot in the air on three that carry: there is no ground for it here.
        Driving on resumes.
        """
        self._hovered, self.kind, self.blocked = self.kind, "hover", why

    def _go_on(self, sensing: Sensing, terrain: TerrainMap) -> None:
        """From hovering: the step goes on where it was held; a stranded foot searches again."""
        self.kind, self.blocked = self._hovered, None
        if self.kind == "emergent" and self.encounter is not None:
            self._shunned = set()
            self.encounter = replace(self.encounter, misses=0)
            self._follow(self.encounter.after(Event.ORDER), sensing, None, terrain)

    def _play(self, plan: StepPlan, kind: str) -> None:
        self._interrupted = self.plan if self.kind in ("step", "pose") else self._interrupted
        self.playback = TrajectoryTracker(plan)
        self.reflexes = self.reflexes.next_step()
        self.kind, self.t = kind, 0.0

    def _after_settling(self, sensing: Sensing) -> Stance:
        """What the planner should remember after a step that was cut short: who swung last, if
        anybody did.
        """
        plan = self._interrupted if self.kind in ("settle", "emergent") else self.plan
        lifted = self.plan.end.lifted if self.kind == "settle" else ()
        if plan is None or plan.landing is None or not plan.swing:
            return (
                self.stance if self.stance.lifted == lifted else replace(self.stance, lifted=lifted)
            )
        u = plan.swing[0]
        at = self._actual(sensing, plan.end).feet[u]
        finished = math.hypot(at[0] - plan.landing[0], at[1] - plan.landing[1]) <= LANDED_AS_PLANNED
        return replace(
            plan.end,
            last_swing=u if finished else self.stance.last_swing,
            lifted=lifted,
            course=self._course_at(sensing, plan),
        )

    def _course_at(self, sensing: Sensing, plan: StepPlan) -> float:
        """s where the body stands in a step cut short, m: between its ends by how far it has got."""
        start, end = plan.body[0], plan.end.body
        way = math.hypot(
            end[0] - start[0], end[1] - start[1], self.machine.yaw_length * (end[3] - start[3])
        )
        if way < SAME_PLACE:
            return plan.end.course
        x, y, yaw = sensing.body[0], sensing.body[1], sensing.body[5]
        gone = math.hypot(x - start[0], y - start[1], self.machine.yaw_length * (yaw - start[3]))
        return self.stance.course + min(gone / way, 1.0) * (plan.end.course - self.stance.course)

    def _rest(self, stance: Stance, keep_thinking: bool = False) -> None:
        if self.kind in ("settle", "emergent") and self._interrupted is not None:
            self._finish(replace(self._interrupted, end=stance))
            self._interrupted = None
        self.stance = stance
        self.playback = TrajectoryTracker(holding_plan(stance))
        self.reflexes = self.reflexes.next_step()
        self.kind, self.t, self.pace = "stand", 0.0, 0.0
        self.encounter = None
        self._shunned = set()
        self.blocked = None
        self._refused = None
        self._waited = 0
        if not keep_thinking:
            self._forget()
            self.flags = (False, False, False)

    def _finish(self, plan: StepPlan) -> None:
        self.executed = plan

    # emergent motions: H §9

    def _surprised(self, sensing: Sensing, terrain: TerrainMap) -> bool:
        """Case 1 or 3 in the running step: the swing foot meets what the map does not show, or its
        foothold is an edge.
        """
        for leg in self.plan.swing:
            phase = self.plan.phases[self.playback.stretch(self.t)]
            if phase is Phase.RETURN:
                felt = self._felt(leg, sensing, terrain)
                if felt is not None:
                    self._meet(Event.HIT, leg, sensing, felt, terrain)
                    return True
            elif (
                phase is Phase.DOWN
                and sensing.soles[leg]
                and not self.reflexes.landed[leg]
                and self._hangs_over(leg, sensing)
            ):
                self._meet(Event.EDGE, leg, sensing, self._over(leg, sensing), terrain)
                return True
        return False

    def _no_ground(self, sensing: Sensing, terrain: TerrainMap) -> float:
        """Case 2: the step is over and a foot has found no ground."""
        leg = next(i for i in self.plan.swing if not self.reflexes.landed[i])
        self._meet(Event.NO_GROUND, leg, sensing, None, terrain)
        self.pace = 1.0
        return 0.0

    def _meet(
        self, event: Event, leg: int, sensing: Sensing, bearing: float | None, terrain: TerrainMap
    ) -> None:
        """The body stops in this tick; what the foot does next is the table's to say."""
        self.emergent[KINDS[event]] = self.emergent.get(KINDS[event], 0) + 1
        landing = self.plan.landing or self.plan.end.feet[leg]
        self._learn(event, leg, sensing, bearing, terrain)
        self._follow(Encounter(State.NORMAL, leg, landing).after(event), sensing, bearing, terrain)
        self.flags = (True, False, True)

    def _react(self, sensing: Sensing, command: Command, terrain: TerrainMap) -> None:
        """One tick of an emergent motion: has something happened that the table knows?"""
        encounter = self.encounter
        if encounter is None:
            return
        bearing = self._felt(encounter.leg, sensing, terrain)
        event = self._event(encounter, sensing, bearing)
        if event is None:
            return
        self._learn(event, encounter.leg, sensing, bearing, terrain)
        self._follow(encounter.after(event), sensing, bearing, terrain)
        if self.kind == "stand" and not command.holds and not self.wanted:
            self._start(sensing, command, terrain)

    def _event(self, encounter: Encounter, sensing: Sensing, bearing: float | None) -> Event | None:
        phase = self.plan.phases[self.playback.stretch(self.t)]
        if phase is Phase.DOWN and self.reflexes.landed[encounter.leg]:
            return Event.EDGE if self._hangs_over(encounter.leg, sensing) else Event.LANDED
        moving_on = encounter.state in (State.RETRY, State.PLACE, State.RETRACE)
        if phase is Phase.RETURN and bearing is not None and moving_on:
            return Event.HIT
        if self.t < self.playback.duration - 1e-9:
            return None
        if encounter.state is State.CLIMB:
            free = self._felt_towards(encounter, sensing) is None
            here = self._actual(sensing, self.plan.end)
            high = at_top(unleaned(here), encounter.leg, self.machine) or encounter.hits >= HITS_MAX
            return Event.TOP if high and not free else Event.CLEAR if free else Event.DONE
        return Event.NO_GROUND if phase is Phase.DOWN else Event.DONE

    def _follow(
        self, encounter: Encounter, sensing: Sensing, bearing: float | None, terrain: TerrainMap
    ) -> None:
        """Do what the encounter's new state says; a search is answered at once."""
        here = self._actual(sensing, self.plan.end)
        if encounter.state is State.NORMAL:
            self._rest(self._actual(sensing, self._after_settling(sensing)))
            return
        answer: StepPlan | Blocked
        if encounter.state is State.SEARCH:
            found = replace(encounter, state=State.PLACE)
            self._shunned |= cells_near(here.feet[encounter.leg], SHY * encounter.misses, terrain)
            searched = terrain.forbid(self._learnt | self._shunned)
            answer = self._motion(found, here, bearing, searched)
            encounter = encounter.after(
                Event.NOTHING if isinstance(answer, Blocked) else Event.FOUND
            )
        else:
            answer = self._motion(encounter, here, bearing, terrain)
        if isinstance(answer, Blocked):
            self.kind, self.encounter = "emergent", encounter
            self._hover(answer)
        else:
            self._play(answer, "emergent")
            self.encounter = encounter

    def _motion(
        self, encounter: Encounter, here: Stance, bearing: float | None, terrain: TerrainMap
    ) -> StepPlan | Blocked:
        frame = leaning(here, terrain, self.machine)
        answer = motion(
            encounter, Situation(frame.stance, bearing, frame.terrain, frame.machine, self.gait)
        )
        return frame.restored(answer, here) if isinstance(answer, StepPlan) else answer

    def _learn(
        self, event: Event, leg: int, sensing: Sensing, bearing: float | None, terrain: TerrainMap
    ) -> None:
        """What touch has shown is no ground: one cell, or a rectangle along an edge whose direction
        was felt.
        """
        foot = feet_absolute(sensing)[leg]
        if event is Event.TOP or (
            event is Event.HIT
            and self.encounter is not None
            and self.encounter.state is State.PLACE
        ):
            known = (
                self._felt_towards(self.encounter, sensing)
                if self.encounter is not None
                else bearing
            )
            self._learnt |= (
                cell_of(foot, terrain) if known is None else edge_cells(foot, known, terrain)
            )
        elif event is Event.NO_GROUND and self.kind in ("emergent", "settle"):
            self._learnt |= cell_of(foot, terrain)
        elif event is Event.EDGE:
            over = self._over(leg, sensing)
            self._learnt |= (
                cell_of(foot, terrain)
                if over is None
                else edge_cells(foot, over, terrain) | cell_of(foot, terrain)
            )

    def _felt(self, leg: int, sensing: Sensing, terrain: TerrainMap) -> float | None:
        """Absolute bearing of something felt on the foot's way that the map does not show; None
        when there is nothing.
        """
        bits = sensing.whiskers[leg]
        if not bits:
            return None
        yaw = sensing.body[5]
        here = self.playback.foot_at(leg, self.t)
        there = self.playback.foot_at(leg, min(self.t + 0.1, self.playback.duration))
        if here[0] == there[0] and here[1] == there[1]:
            return None
        ahead = felt_ahead(bits, math.atan2(there[1] - here[1], there[0] - here[0]) - yaw)
        if ahead is None:
            return None
        foot, bearing = feet_absolute(sensing)[leg], ahead + yaw
        reach = self.machine.foot_radius + WHISKER_TIP + terrain.cell
        shown = terrain.crest_in(foot[0] - reach, foot[0] + reach, foot[1] - reach, foot[1] + reach)
        return None if shown > foot[2] else bearing

    def _felt_towards(self, encounter: Encounter, sensing: Sensing) -> float | None:
        """Absolute bearing of something felt between the foot and where it was to land."""
        foot, yaw = feet_absolute(sensing)[encounter.leg], sensing.body[5]
        ahead = felt_ahead(
            sensing.whiskers[encounter.leg],
            math.atan2(encounter.goal[1] - foot[1], encounter.goal[0] - foot[0]) - yaw,
        )
        return None if ahead is None else ahead + yaw

    def _hangs_over(self, leg: int, sensing: Sensing) -> bool:
        return bool(sensing.rims) and sensing.rims[leg] != 0

    def _over(self, leg: int, sensing: Sensing) -> float | None:
        """Absolute direction in which the sole hangs over."""
        bits = sensing.rims[leg] if sensing.rims else 0
        angles = [k * math.pi / 4 for k in range(8) if bits >> k & 1]
        sine, cosine = sum(map(math.sin, angles)), sum(map(math.cos, angles))
        return (
            None if math.hypot(sine, cosine) < 1e-9 else math.atan2(sine, cosine) + sensing.body[5]
        )

    def take_learnt(self) -> set[tuple[int, int]]:
        """Cells touch has shown to be no ground, once; the console adds them to the belief."""
        learnt, self._learnt = self._learnt, set()
        return learnt

    # where the machine really is

    def _arrived(self, sensing: Sensing) -> Stance:
        """The stance at N_{k+1}: the plan's end when all went as planned up to this tick, in which
        the last of the way is still to go.
        """
        end, now = self.plan.end, self.playback.body_at(self.t)
        actual = self._actual(sensing, replace(end, body=now, lean=self.playback.lean_at(self.t)))
        return end if actual.body == now and actual.feet == end.feet else actual

    def _actual(self, sensing: Sensing, expected: Stance) -> Stance:
        """The sensed stance, or ``expected`` itself when it came out so."""
        x, y, z, roll, pitch, yaw = sensing.body
        feet = feet_absolute(sensing)
        ex, ey, ez, eyaw = expected.body
        lean = self.playback.lean_at(self.t)
        if lean != expected.lean:
            expected = replace(expected, lean=lean)
        if self.playback.leans:
            wanted_roll, wanted_pitch = attitude_of(lean, yaw)
            roll, pitch = roll - wanted_roll, pitch - wanted_pitch
        off = max(abs(x - ex), abs(y - ey), abs(z - ez), abs(yaw - eyaw), abs(roll), abs(pitch))
        for foot, wanted in zip(feet, expected.feet, strict=True):
            off = max(
                off, abs(foot[0] - wanted[0]), abs(foot[1] - wanted[1]), abs(foot[2] - wanted[2])
            )
        if off <= SAME_PLACE:
            return expected
        return replace(expected, body=(x, y, z, yaw), feet=feet)


def _as_planned(came: Stance, planned: Stance) -> bool:
    """True when a plan came out near enough to what the next one of its posture begins with."""
    if came is planned:
        return True
    pairs = [
        (came.body, planned.body, BODY_OFF),
        *((one, two, POSE_OFF) for one, two in zip(came.feet, planned.feet, strict=True)),
    ]
    return all(abs(a - b) <= off for one, two, off in pairs for a, b in zip(one, two, strict=True))


def feet_absolute(sensing: Sensing) -> tuple[Point, ...]:
    """Foot tips in the absolute frame from position monitors, posture and dead reckoning."""
    x, y, z, roll, pitch, yaw = sensing.body
    cr, sr, cp, sp, cy, sy = (
        math.cos(roll),
        math.sin(roll),
        math.cos(pitch),
        math.sin(pitch),
        math.cos(yaw),
        math.sin(yaw),
    )
    feet = []
    for fx, fy, fz in sensing.feet_b:
        ry, rz = cr * fy - sr * fz, sr * fy + cr * fz
        px, pz = cp * fx + sp * rz, cp * rz - sp * fx
        feet.append((x + cy * px - sy * ry, y + sy * px + cy * ry, z + pz))
    return tuple(feet)
