"""Who may drive. One lease, held by one socket; everybody may stop.

A held stick is a command that is repeated: it lapses ``DEAD_MAN`` s of wall time after the last
fresh one, and a frame is fresh only while the picture its sender has seen (``echo_tick``) is: after
a black-out TCP delivers every old frame at once. When a pressed stick has gone silent for
``SIT_AFTER`` s, its socket still open or not, the machine sits down where it stands. A machine that
held because its operator was lost moves again only after the stick has been seen at rest. Only the
web loop touches an ``Operator``; what it decides goes to the clock's mailbox.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from walking_console.planner.control.supervisor import DT
from walking_console.planner.types import Command, Mode

from .realtime_loop import HOLD, WalkingClock
from .schemas import DriveFrame, Frame, PostureFrame, ReleaseFrame, StopFrame, TakeFrame

DEAD_MAN = 0.5  # s: shorter stops on every hiccup of a wireless link, longer walks on blindly
# s without a fresh frame from a pressed stick after which the machine sits down; shorter: see it
# sit on every bad link
SIT_AFTER = 10.0
LEASE_IDLE = 15.0  # s without a frame after which the lease is free
FRAMES_PER_SECOND = 100.0
FRAME_BURST = 50.0
# what five seconds without a link may hold back and deliver at once
FRAME_BURST_AFTER_SILENCE = 500.0
REST = "rest"  # who drives while a REST command lives

TAKE_FIRST = "take the lease first"
CENTRE_FIRST = "let go of the stick first"
STOPPED = "stopped: let go of the stick and rearm"


class TooFast(Exception):
    """A socket that sends more than it may; it is to be closed."""


@dataclass(eq=False)
class Seat:
    """One socket's place: its last number, its stick, its allowance of frames."""

    name: str
    sequence: int = -1
    centred: bool = True  # the stick as last seen
    must_centre: bool = False  # no motion before the stick has been seen at rest
    heard: float = 0.0  # s, last frame of any kind
    driven: float = 0.0  # s, last accepted drive frame
    moving: bool = False  # whether that one asked for motion
    allowance: float = FRAME_BURST
    counted: float = 0.0

    def count(self, now: float) -> None:
        """Take one frame out of the allowance; raises ``TooFast`` when there is none left."""
        earned = (now - self.counted) * FRAMES_PER_SECOND
        ceiling = max(FRAME_BURST, min(earned, FRAME_BURST_AFTER_SILENCE))
        self.allowance = max(self.allowance, min(ceiling, self.allowance + earned)) - 1.0
        self.counted = self.heard = now
        if self.allowance < 0.0:
            raise TooFast(f"more than {FRAMES_PER_SECOND:g} frames a second")


class Operator:
    """The lease, the stop, and the way every command takes to the clock. Methods answer why not, or
    '' when it was done.
    """

    def __init__(self, clock: WalkingClock, sit_after: float = SIT_AFTER) -> None:
        self._clock, self._now = clock, clock.now
        self._sit_after = sit_after if sit_after > 0.0 else math.inf
        self._holder: Seat | None = None
        self._rest_until = 0.0
        self.stopped = False
        self.revision = 0  # a new one means: tell everybody who drives
        self.refusals = 0

    def sit(self, name: str) -> Seat:
        """A place for a new socket."""
        now = self._now()
        return Seat(name, heard=now, counted=now)

    def count(self, seat: Seat) -> None:
        """One more frame from a socket; raises ``TooFast``."""
        seat.count(self._now())

    def leave(self, seat: Seat) -> None:
        """A socket closed: if it drove, the machine holds at once; if its stick was pressed, it
        sits down later.
        """
        if self._holder is seat:
            self._clock.halt()
            self._let_go()

    @property
    def holder(self) -> str | None:
        """Who drives: a socket's name, ``rest``, or nobody."""
        now = self._now()
        if self._holder is not None and now - self._holder.heard > LEASE_IDLE:
            self._let_go()
        if self._holder is not None:
            return self._holder.name
        return REST if now < self._rest_until else None

    def holds(self, seat: Seat) -> bool:
        return self.holder is not None and self._holder is seat

    def hear(self, seat: Seat, frame: Frame) -> str:
        """Do what a frame asks, or say why not."""
        if isinstance(frame, DriveFrame):
            why = self._drive(seat, frame)
        elif isinstance(frame, TakeFrame):
            why = self._take(seat)
        elif isinstance(frame, ReleaseFrame):
            why = self._release(seat)
        elif isinstance(frame, StopFrame):
            why = self.stop()
        elif isinstance(frame, PostureFrame):
            why = self._pose(seat, frame)
        else:
            why = self._rearm(seat)
        self.refusals += bool(why)
        return why

    def _drive(self, seat: Seat, frame: DriveFrame) -> str:
        now = self._now()
        command = frame.command()
        age = self._age(seat, frame)
        if isinstance(age, str):
            return age
        if seat.moving and now - seat.driven > DEAD_MAN:
            seat.moving, seat.must_centre = False, True
        if age > DEAD_MAN:
            seat.must_centre, seat.moving = seat.must_centre or seat.moving, False
            return _stale(frame.echo_tick, age)
        seat.centred = command.holds
        if command.holds:
            seat.must_centre = False
        if self._holder is seat:
            self._expect(command, now)
        return self._blocked_by(seat) or self._obey(seat, command, now, age)

    def _age(self, seat: Seat, frame: DriveFrame | PostureFrame) -> float | str:
        """How old the picture is that a frame answers, s; or why the frame is none of this moment."""
        if frame.seq <= seat.sequence:
            return f"out of order: {frame.seq} after {seat.sequence}"
        seat.sequence = frame.seq
        age = self._clock.age_of(frame.echo_tick)
        return f"echo_tick {frame.echo_tick} has not been shown yet" if age is None else age

    def _expect(self, command: Command, now: float) -> None:
        """A fresh frame: while its stick is pressed the next one is due before the machine sits
        down.
        """
        self._clock.sit_down_at(math.inf if command.holds else now + self._sit_after)

    def _pose(self, seat: Seat, frame: PostureFrame) -> str:
        """By the holder, or whoever finds the lease free. A stick still pressed moves nothing
        before it has been let go.
        """
        age = self._age(seat, frame)
        if isinstance(age, str):
            return age
        if age > DEAD_MAN:
            return _stale(frame.echo_tick, age)
        holder = self.holder
        if holder is not None and self._holder is not seat:
            return f"{holder} is driving"
        why = STOPPED if self.stopped else self._cannot_pose()
        if not why:
            if self._holder is not seat:
                self._holder = seat
                self.revision += 1
            seat.must_centre, seat.moving = not seat.centred, False
            self._take_posture(frame.posture)
        return why

    def _cannot_pose(self) -> str:
        newest = self._clock.newest
        return newest.reason if newest.mode in (Mode.TIPPING, Mode.FALLEN) else ""

    def _take_posture(self, posture: str) -> None:
        self._clock.sit_down_at(math.inf)
        self._clock.pose(posture)

    def _blocked_by(self, seat: Seat) -> str:
        holder = self.holder
        if holder is not None and self._holder is not seat:
            return f"{holder} is driving"
        if self.stopped:
            return "" if seat.centred else STOPPED
        return CENTRE_FIRST if seat.must_centre else ""

    def _obey(self, seat: Seat, command: Command, now: float, age: float) -> str:
        if self._holder is not seat:
            self._holder = seat
            self.revision += 1
            self._expect(command, now)
        seat.driven, seat.moving = now, not command.holds
        # so a frozen picture holds at the dead-man, not at twice that
        self._clock.order(command, max(DT, DEAD_MAN - age))
        return ""

    def _take(self, seat: Seat) -> str:
        if self._holder is not seat:
            self._quieten()
            self._let_go()
            self._holder = seat
            seat.moving, seat.must_centre = False, not seat.centred
        return ""

    def _release(self, seat: Seat) -> str:
        seat.centred, seat.must_centre, seat.moving = True, False, False
        if self._holder is seat:
            self._quieten()
            self._let_go()
        return ""

    def _quieten(self) -> None:
        """Somebody is there: the machine holds, in whatever posture, and does not sit down by
        itself.
        """
        self._clock.sit_down_at(math.inf)
        self._clock.halt()

    def _let_go(self) -> None:
        """The machine holds; the lease is free, and a stick left pressed moves nothing later."""
        self._clock.order(HOLD)
        if self._holder is not None:
            self._holder.must_centre, self._holder.moving = not self._holder.centred, False
        self._holder, self._rest_until = None, 0.0
        self.revision += 1

    def stop(self) -> str:
        """Anybody; the machine holds from the next tick on, until ``rearm``."""
        self._quieten()
        if not self.stopped:
            self.stopped = True
            self.revision += 1
        return ""

    def _rearm(self, seat: Seat) -> str:
        if self._holder is not seat:
            return f"{self.holder} is driving" if self.holder else TAKE_FIRST
        if not seat.centred:
            return CENTRE_FIRST
        return self._end_stop()

    def rearm(self) -> str:
        """By REST: only while no socket drives."""
        return (
            f"{self._holder.name} is driving" if self.holder and self._holder else self._end_stop()
        )

    def _end_stop(self) -> str:
        if self.stopped:
            self.stopped = False
            self.revision += 1
        return ""

    def command(self, command: Command, ttl: float) -> str:
        """By REST: while no socket drives; the next one waits until this has lapsed."""
        now = self._now()
        if self.holder is not None and self._holder is not None:
            why = f"{self._holder.name} is driving"
        elif self.stopped and not command.holds:
            why = "stopped: rearm first"
        else:
            why = ""
            self._rest_until = 0.0 if command.holds else now + ttl
            self._clock.sit_down_at(math.inf)
            if command.holds:
                self._clock.halt()
            self._clock.order(command, ttl)
        self.refusals += bool(why)
        return why

    def pose(self, posture: str) -> str:
        """By REST: while no socket drives; it ends a command that REST has given."""
        if self.holder is not None and self._holder is not None:
            why = f"{self._holder.name} is driving"
        else:
            why = "stopped: rearm first" if self.stopped else self._cannot_pose()
        if not why:
            self._rest_until = 0.0
            self._take_posture(posture)
        self.refusals += bool(why)
        return why

    def hold(self) -> None:
        """The machine holds and whoever drives must let go of the stick first: another world,
        another rate, the end.
        """
        if self._holder is not None:
            self._holder.must_centre, self._holder.moving = not self._holder.centred, False
        self._rest_until = 0.0
        self._clock.sit_down_at(math.inf)
        self._clock.order(HOLD)


def _stale(tick: int, age: float) -> str:
    return f"stale: the picture of tick {tick} is {min(age, 999.0):.1f} s old"
