"""The real-time loop: 50 ticks a second in a thread of its own, so that no socket, body or browser
stalls the walk.

Every tick of the loop takes the newest command, walks ``rate`` ticks of the simulation and
publishes one ``Snapshot`` (one attribute, the newest wins). The schedule is absolute; a late tick
is not caught up but skipped, and said: simulated time then slips against the wall.
"""

from __future__ import annotations

import logging
import math
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from walking_console.planner.types import TICK, Command
from walking_console.sim.requests import Halt, Load, Request, Reset, TakePosture
from walking_console.sim.runs.runner import TimelinePlayer
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World

from .command_mailbox import CommandMailbox, SitDownTimer
from .loop_thread import LoopThread
from .pacing import STALL, Lateness, Pace, ShownTicks
from .scheduling import raise_priority, shorten_pauses

HOLD = Command()
IDLE_TICKS = 10  # a paused world is still published five times a second

log = logging.getLogger(__name__)


@dataclass(slots=True)
class Play:
    """The scenario's own timeline: asked for, running, and who plays it."""

    player: TimelinePlayer | None = None
    runs: bool = False
    is_asked: bool = False


class RealtimeLoop:
    """Walks a simulation in its own thread. ``order``, ``request`` and the switches may be used
    from any thread.
    """

    def __init__(self, simulation: Simulation, now: Callable[[], float] = time.monotonic) -> None:
        self.simulation = simulation
        self.now = now  # s; everything that lapses in wall time is counted by it
        self.newest: Snapshot = simulation.snapshot()
        # traceback of the tick that failed; the walk stands still until ``reset`` or ``load``
        self.fault = ""
        self.ticks_run = 0
        self.pace = Pace()
        self.lateness = Lateness(now())
        # called in the walking thread: must not block
        self.on_publish: Callable[[], None] = _nobody
        self._commands = CommandMailbox()
        self._sit_down = SitDownTimer()
        self._shown = ShownTicks(self.newest.tick, now())
        self._play = Play()
        self._changed = False
        self._ending = False
        self._thread = LoopThread("walking", self._walk)

    # switches, for any thread

    def start(self) -> None:
        """Begin to walk."""
        shorten_pauses()
        self._thread.start()

    def stop(self) -> None:
        """Hold and end the thread within a tick."""
        self.hold_for_good()
        self._thread.stop()

    def hold_for_good(self) -> None:
        """The end is near: hold, and take no other command."""
        self._ending = True
        self.halt()

    @property
    def running(self) -> bool:
        """Whether the thread walks."""
        return self._thread.running

    def order(self, command: Command, ttl: float = math.inf) -> None:
        """Leave a command for the next tick; after ``ttl`` s of wall time without another the
        machine holds.
        """
        if not self._ending or command.holds:
            self._commands.put(command, ttl, self.now())

    def halt(self) -> None:
        """Hold, and stop in any posture that is being taken, or timeline that was asked for."""
        self._play.is_asked = False
        self.order(HOLD)
        self.request(Halt())

    def take_posture(self, posture: str) -> None:
        """Hold, and then take a posture."""
        if not self._ending:
            self.order(HOLD)
            self.request(TakePosture(posture))

    def sit_down_at(self, at: float) -> None:
        """Sit down at this time of ``now`` unless another is given before; ``inf``: do not."""
        self._sit_down.set(at)

    def request(self, request: Request) -> None:
        """Leave a request for the next simulated tick."""
        self.simulation.request(request)
        self._changed = True

    @property
    def requests_waiting(self) -> int:
        """How many requests the next simulated tick will serve."""
        return self.simulation.requests_waiting

    def reset(self) -> None:
        """Back to the start of the scenario; forgives a fault."""
        self._begin_again(Reset())

    def load(self, world: World) -> None:
        """Another world; forgives a fault."""
        self._begin_again(Load(world))

    def play(self) -> None:
        """Back to the start, and walk by the scenario's own timeline until somebody drives."""
        self._begin_again(Reset())
        self._play.is_asked = True

    @property
    def player(self) -> TimelinePlayer | None:
        """Of the scenario's own timeline: of the last time it was played, until another world."""
        return self._play.player

    @property
    def playing(self) -> bool:
        """Whether it walks by the scenario's own timeline, or is about to."""
        return self._play.runs or self._play.is_asked

    def _begin_again(self, request: Request) -> None:
        self.order(HOLD)
        self.request(request)
        self.fault = ""

    def pause(self) -> None:
        """Stop simulated time; ``pace.advance`` walks single ticks."""
        self.pace.paused = True
        self._changed = True

    def resume(self) -> None:
        """Let simulated time go on."""
        self.pace.paused = False
        self._changed = True

    def set_rate(self, rate: float) -> None:
        """0.1 to 8 times real time, else ``ValueError``. A held command must be given again: its
        ticks were counted at the old rate. A timeline walks on.
        """
        if self.pace.set_rate(rate):
            self._changed = True
            if not self.playing:
                self.order(HOLD)

    # figures, for any thread

    @property
    def tick_age(self) -> float:
        """Seconds since the last tick; above ``STALL`` the walking thread is stuck in one."""
        return self.now() - self.lateness.last_at if self.running else 0.0

    @property
    def stalled(self) -> bool:
        """Whether the walking thread is stuck in a tick."""
        return self.tick_age > STALL

    def age_of(self, tick: int) -> float | None:
        """For how many seconds ``tick`` has no longer been the newest picture; None for a tick that
        has not been shown.
        """
        return self._shown.age_of(tick, self.now())

    # the walking thread

    def _walk(self, stopping: threading.Event) -> None:
        raise_priority()
        due = time.monotonic() + TICK
        # an event's wait is exact where an asyncio loop rounds up to milliseconds
        while not stopping.wait(max(0.0, due - time.monotonic())):
            due += TICK * self.lateness.note(max(0.0, time.monotonic() - due))
            self.tick()
            due += TICK

    def tick(self) -> None:
        """One tick of the loop: the command, the simulated ticks it is time for, one snapshot. One
        that fails is held here, and said.
        """
        now = self.now()
        self._take_command(now)
        if self._play.is_asked:
            self._begin_play()
        if not self.pace.paused and self._sit_down.falls_due(now):
            self.take_posture("sit")
        ticks = self.pace.ticks_due()
        if self.fault:
            self.pace.forgive()
        else:
            self._walk_or_fail(ticks, now)
        if self.fault and self._publication_is_due(0):
            self.on_publish()
        self.ticks_run += 1
        self.lateness.last_at = self.now()

    def _take_command(self, now: float) -> None:
        waiting = self._commands.take()
        if waiting is not None:
            self._end_play()
            self._play.is_asked = self._play.is_asked and waiting.command.holds
            self.simulation.order(waiting.command, self._ticks_of(waiting.ttl))
        # simulated ticks may have stood still: the dead-man counts wall time
        if not self.pace.paused and self._commands.lapses(now):
            self.simulation.order(HOLD)

    def _begin_play(self) -> None:
        self._play.is_asked = False
        self.simulation.serve_requests()
        self._play.player = TimelinePlayer(self.simulation)
        self._play.runs = True

    def _end_play(self) -> None:
        """The timeline gives nothing any more; what it has recorded stays."""
        if self._play.runs:
            self._play.runs = False
            self._changed = True
            self.simulation.on_input = None

    def _step(self) -> None:
        """One tick of the simulation, by the timeline while that is played."""
        if not self._play.runs or self._play.player is None:
            self.simulation.step()
            return
        self._play.player.give()
        self.simulation.step()
        self._play.player.note()
        if self._play.player.ending is not None:
            self._end_play()
            self.simulation.order(HOLD)

    def _ticks_of(self, ttl: float) -> int | None:
        """Simulated ticks in so many seconds of wall time; None: for ever."""
        return None if math.isinf(ttl) else max(1, math.ceil(ttl * self.pace.rate / TICK))

    def _walk_or_fail(self, ticks: int, now: float) -> None:
        try:
            for _ in range(ticks):
                self._step()
            if not ticks:
                # a reset or an edit shows at once, though no tick runs
                self.simulation.serve_requests()
            if self._publication_is_due(ticks):
                self._publish(now)
        except Exception:
            self.fault = traceback.format_exc()
            self.pace.forgive()
            self._changed = True
            log.exception("the walk stands still, a tick failed")

    def _publication_is_due(self, ticks: int) -> bool:
        due = ticks > 0 or self._changed or self.ticks_run % IDLE_TICKS == 0
        self._changed = False
        return due

    def _publish(self, now: float) -> None:
        snapshot = self.simulation.snapshot(
            paused=self.pace.paused,
            rate=self.pace.rate,
            late=self.lateness.last_second,
        )
        self._shown.note(snapshot.tick, now)
        self.newest = snapshot
        self.on_publish()


def _nobody() -> None:
    """Nobody listens yet."""
