"""The walking clock: 50 beats a second in a thread and an asyncio loop of its own, so that no
socket, body or browser stalls it.

Every beat takes the newest order, walks ``rate`` ticks and publishes one ``Snapshot`` (one
attribute, the newest wins). The schedule is absolute; a late beat is not caught up but skipped, and
said: simulated time then slips against the wall. ``Drawing`` is the other thread here: it hands the
newest snapshot to the scene, and a slow draw skips snapshots.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import math
import os
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from walking_console.planner.control.supervisor import DT
from walking_console.planner.types import Command
from walking_console.sim.requests import Halt, Load, Request, Reset, TakePosture
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World

HOLD = Command()
RATE_MAX = 8  # times real time; more starves the pages on two cores
STALL = 0.2  # s without a beat that counts as stalled
ADVANCE_PER_BEAT = 100  # ticks; more would make the beat itself late
ADVANCE_MAX = 3000  # ticks of one request: a minute of walking
IDLE_BEATS = 10  # a paused world is still published five times a second
# s a busy thread keeps the interpreter; the default 5 ms shows in the lateness with three pages
# open
SWITCH_INTERVAL = 0.001
NICENESS = -10
DRAW_RATE = 25.0  # Hz
DRAW_RATE_UNWATCHED = 2.0  # Hz while no canvas is open: enough for the next one to start from


def go_first() -> None:
    """Let this thread run before other programs' where the system allows it (root, or a user with
    an rtprio or nice limit).

    Beside three browser pages that render in software on two cores, 50 beats a second were kept in
    full so, and one in thirty was skipped without. Every thread that holds the interpreter needs
    it, or the walking thread waits behind the one that was put aside. Child processes start as
    usual.
    """
    if sys.platform != "linux":  # only there is a thread's number one that these calls take
        return
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))


class Order(NamedTuple):
    """A command as it waits for the next beat, with the wall time at which it lapses."""

    command: Command
    ttl: float  # s
    deadline: float  # s, monotonic


class Deadline(NamedTuple):
    """When the machine is to sit down unless somebody is heard again; a new one replaces the old."""

    at: float  # s, monotonic


class WalkingClock:
    """Walks a console in its own thread. ``order``, ``request`` and the switches may be used from
    any thread.
    """

    def __init__(self, console: Simulation, now: Callable[[], float] = time.monotonic) -> None:
        self.console = console
        self.now = now  # s; everything that lapses in wall time is counted by it
        self.newest: Snapshot = console.snapshot()
        # traceback of the tick that failed; the walk stands still until ``reset`` or ``load``
        self.fault = ""
        self.beats = 0
        self.skipped = 0  # beats that were dropped because the clock was late
        self.worst = 0.0  # s, worst lateness since the start
        # called in the walking thread: must not block
        self.on_publish: Callable[[], None] = _nobody
        self._rate = 1
        self._paused = False
        self._changed = False
        self._order: Order | None = None
        # the last one a beat has seen: the mailbox itself is only ever overwritten
        self._taken: Order | None = None
        self._deadline = math.inf
        # the newest, and the last one a beat has acted on
        self._sits = self._sat = Deadline(math.inf)
        self._advances: deque[int] = deque()
        self._owed = 0
        self._late: deque[float] = deque([0.0], maxlen=round(1 / DT))
        self._published: deque[tuple[int, float]] = deque([(self.newest.tick, now())], maxlen=128)
        self._beat_at = now()
        self._ending = False
        self._stopping = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._walk()), name="walking", daemon=True
        )

    # switches, for any thread

    def start(self) -> None:
        """Begin to walk; threads give way to each other quickly from here on.

        What has been loaded by now is for good: left out of full garbage collections, which
        otherwise take 20 to 36 ms of a tick.
        """
        sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))
        gc.collect()
        gc.freeze()
        self._thread.start()

    def stop(self) -> None:
        """Hold and end the thread within a beat."""
        self.hold_for_good()
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(timeout=1.0)

    def hold_for_good(self) -> None:
        """The end is near: hold, and take no other order."""
        self._ending = True
        self.halt()

    @property
    def running(self) -> bool:
        return self._thread.is_alive()

    @property
    def rate(self) -> int:
        return self._rate

    @property
    def paused(self) -> bool:
        return self._paused

    def order(self, command: Command, ttl: float = math.inf) -> None:
        """Leave a command for the next beat; after ``ttl`` s of wall time without another the
        machine holds.
        """
        if self._ending and not command.holds:
            return
        self._order = Order(command, ttl, self.now() + ttl)

    def halt(self) -> None:
        """Hold, and stop in any posture that is being taken."""
        self.order(HOLD)
        self.request(Halt())

    def pose(self, posture: str) -> None:
        """Hold, and then take a posture."""
        if not self._ending:
            self.order(HOLD)
            self.request(TakePosture(posture))

    def sit_down_at(self, at: float) -> None:
        """Sit down at this time of ``now`` unless another is given before; ``inf``: do not."""
        self._sits = Deadline(at)

    def request(self, request: Request) -> None:
        """Leave a request for the next tick."""
        self.console.request(request)
        self._changed = True

    def reset(self) -> None:
        """Back to the start of the scenario; forgives a fault."""
        self._begin_again(Reset())

    def load(self, world: World) -> None:
        """Another world; forgives a fault."""
        self._begin_again(Load(world))

    def _begin_again(self, request: Request) -> None:
        self.order(HOLD)
        self.request(request)
        self.fault = ""

    def pause(self) -> None:
        self._paused = self._changed = True

    def resume(self) -> None:
        self._paused, self._changed = False, True

    def set_rate(self, rate: int) -> None:
        """1 to 8 times real time. A held command must be given again: its ticks were counted at the
        old rate.
        """
        if not 1 <= rate <= RATE_MAX:
            raise ValueError(f"rate must be 1 to {RATE_MAX}, got {rate}")
        if rate != self._rate:
            self._rate, self._changed = rate, True
            self.order(HOLD)

    def advance(self, ticks: int) -> None:
        """Walk this many ticks while paused; ``owed`` tells how many are left."""
        self._advances.append(ticks)

    # figures, for any thread

    @property
    def owed(self) -> int:
        """Ticks still to be walked for ``advance``."""
        return self._owed + sum(self._advances.copy())

    @property
    def late(self) -> float:
        """Worst lateness of the last second, s."""
        return max(self._late.copy())

    @property
    def beat_age(self) -> float:
        """Seconds since the last beat; above ``STALL`` the walking thread is stuck in a tick."""
        return self.now() - self._beat_at if self.running else 0.0

    @property
    def stalled(self) -> bool:
        return self.beat_age > STALL

    def age_of(self, tick: int) -> float | None:
        """For how many seconds ``tick`` has no longer been the newest picture; None for a tick that
        has not been shown.
        """
        if tick > self.newest.tick:
            return None
        published = self._published.copy()
        if tick < published[0][0]:
            return math.inf
        return next((self.now() - at for shown, at in published if shown > tick), 0.0)

    # the walking thread

    async def _walk(self) -> None:
        go_first()
        loop = asyncio.get_running_loop()
        due = loop.time()
        while not self._stopping.is_set():
            due += DT
            await asyncio.sleep(due - loop.time())
            late = max(0.0, loop.time() - due)
            if late >= DT:
                missed = int(late / DT)
                self.skipped += missed
                due += missed * DT
            self._late.append(late)
            self.worst = max(self.worst, late)
            self.beat()

    def beat(self) -> None:
        """One beat: the order, the ticks it is time for, one snapshot. A tick that fails is held
        here, and said.
        """
        now = self.now()
        self._take_order(now)
        self._sit_down(now)
        ticks = self._ticks_due()
        try:
            if not self.fault:
                for _ in range(ticks):
                    self.console.step()
                if not ticks:
                    self._serve_while_paused()
                self._publish(now, ticks)
        except Exception:
            self.fault = traceback.format_exc()
            self._changed = True
            print(
                f"the walk stands still, a tick failed:\n{self.fault}", file=sys.stderr, flush=True
            )
        if self.fault and self._publish_due(0):
            self.on_publish()
        self.beats += 1
        self._beat_at = self.now()

    def _take_order(self, now: float) -> None:
        order = self._order
        if order is not None and order is not self._taken:
            self._taken = order
            ticks = (
                None if math.isinf(order.ttl) else max(1, math.ceil(order.ttl * self._rate / DT))
            )
            self.console.order(order.command, ticks)
            self._deadline = order.deadline
        # ticks may have stood still: the dead-man counts wall time
        if now > self._deadline and not self._paused:
            self.console.order(HOLD)
            self._deadline = math.inf

    def _sit_down(self, now: float) -> None:
        """The operator has been silent for too long: standing for ever costs more than sitting."""
        sits = self._sits
        if now > sits.at and sits is not self._sat and not self._paused:
            self._sat = sits
            self.pose("sit")

    def _ticks_due(self) -> int:
        while self._advances:
            self._owed += self._advances.popleft()
        if not self._paused:
            self._owed = 0
            return self._rate
        ticks = min(self._owed, ADVANCE_PER_BEAT)
        self._owed = 0 if self.fault else self._owed - ticks
        return ticks

    def _serve_while_paused(self) -> None:
        """A reset or an edit shows at once, though no tick runs."""
        self.console.serve_requests()

    def _publish_due(self, ticks: int) -> bool:
        due = ticks > 0 or self._changed or self.beats % IDLE_BEATS == 0
        self._changed = False
        return due

    def _publish(self, now: float, ticks: int) -> None:
        if not self._publish_due(ticks):
            return
        self.newest = self.console.snapshot(
            paused=self._paused, rate=float(self._rate), late=self.late
        )
        last = self._published[-1][0]
        if self.newest.tick < last:
            self._published.clear()
        if self.newest.tick != last or not self._published:
            self._published.append((self.newest.tick, now))
        self.on_publish()


class Drawing:
    """Draws the newest snapshot in a thread of its own; a draw that fails is said once and tried
    again.
    """

    def __init__(
        self, clock: WalkingClock, draw: Callable[[Snapshot], None], watched: Callable[[], bool]
    ) -> None:
        self.fault = ""
        self.draws = 0
        self._clock, self._draw, self._watched = clock, draw, watched
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="drawing", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(timeout=1.0)

    def _run(self) -> None:
        go_first()
        drawn: Snapshot | None = None
        wait = 0.0
        while not self._stopping.wait(wait):
            begun = time.monotonic()
            newest = self._clock.newest
            if newest is not drawn:
                self.show(newest)
                drawn = newest
            wait = max(
                0.0,
                begun
                + 1.0 / (DRAW_RATE if self._watched() else DRAW_RATE_UNWATCHED)
                - time.monotonic(),
            )

    def show(self, snapshot: Snapshot) -> None:
        """Draw one snapshot; a failure is kept in ``fault``."""
        try:
            self._draw(snapshot)
            self.draws, self.fault = self.draws + 1, ""
        except Exception:
            if not self.fault:
                traceback.print_exc()
            self.fault = traceback.format_exc()


def _nobody() -> None:
    """Nobody listens yet."""
