"""Who may drive. One lease, held by one session; everybody may stop.

A held stick is a command that is repeated: it lapses ``DEAD_MAN`` s of wall time after the last
fresh one, and a frame is fresh only while the picture its sender has seen (``echo_tick``) is: after
a black-out TCP delivers every old frame at once. When a pressed stick has gone silent for
``SIT_AFTER`` s, its socket still open or not, the machine sits down where it stands. A machine that
held because its operator was lost moves again only after the stick has been seen at rest. Only the
web loop touches a ``ControlLease``; what it decides goes to the mailbox of the real-time loop.
"""

from __future__ import annotations

import logging
import math

from walking_console.planner.types import TICK, Command, Mode

from .lease_reasons import LeaseReason, LeaseRefusal, refusal, stale
from .realtime_loop import HOLD, RealtimeLoop
from .schemas import (
    DriveFrame,
    LeaseAct,
    PostureFrame,
    RearmFrame,
    ReleaseFrame,
    StopFrame,
    TakeFrame,
)
from .sessions import DEAD_MAN, LEASE_IDLE, SIT_AFTER, RestSession, Session, slowed
from .stop_latch import StopLatch

REST = "rest"  # who drives while a REST command lives

log = logging.getLogger(__name__)


class ControlLease:
    """The lease, the stop, and the way every command takes to the loop. Methods answer why not, or
    None when it was done.
    """

    def __init__(
        self, loop: RealtimeLoop, sit_after: float = SIT_AFTER, latch: StopLatch | None = None
    ) -> None:
        self.loop = loop
        self._now = loop.now
        self._sit_after = sit_after if sit_after > 0.0 else math.inf
        self._holder: Session | None = None
        self._rest = RestSession()
        self.latch = latch or StopLatch()
        self.revision = 0  # a new one means: tell everybody who drives
        self.refusals = 0

    # sessions

    def open(self, name: str, title: str = "", *, watches: bool = False) -> Session:
        """A session for a new socket; ``title`` is what others read of it."""
        now = self._now()
        return Session(name, title or name, watches=watches, heard=now, counted=now)

    def count(self, session: Session) -> None:
        """One more frame from a socket; raises ``TooFast``."""
        session.count(self._now())

    def close(self, session: Session) -> None:
        """A socket closed: if it drove, the machine holds at once; if its stick was pressed, it
        sits down later.
        """
        if self._holder is session:
            self.loop.halt()
            self._free()

    @property
    def holder(self) -> str | None:
        """Who drives: a socket's name, ``rest``, or nobody."""
        now = self._now()
        if self._holder is not None and now - self._holder.heard > LEASE_IDLE:
            if not leaves_the_play(self.loop, self._holder):
                self.loop.order(HOLD)
            self._free()
        if self._holder is not None:
            return self._holder.name
        if self._rest.lapses(now):
            self.revision += 1
        return REST if self._rest.drives else None

    @property
    def stopped(self) -> bool:
        """Whether everything is stopped, until ``rearm``."""
        return self.latch.is_set

    @property
    def holder_title(self) -> str | None:
        """Who drives, for people."""
        if self.holder == REST:
            return "a program"
        return self._holder.title if self._holder is not None else None

    def holds(self, session: Session) -> bool:
        """Whether this session drives."""
        return self.holder is not None and self._holder is session

    def handle(self, session: Session, frame: LeaseAct) -> LeaseRefusal | None:
        """Do what a frame asks, or say why not."""
        why: LeaseRefusal | None = None
        if session.watches and not isinstance(frame, StopFrame):
            return self._counted(refusal(LeaseReason.WATCHES))
        match frame:
            case DriveFrame():
                why = self._drive(session, frame)
            case PostureFrame():
                why = self._take_posture(session, frame)
            case RearmFrame():
                why = self._rearm(session)
            case TakeFrame():
                self._take(session)
            case ReleaseFrame():
                self._release(session)
            case StopFrame():
                self.stop()
        return self._counted(why)

    def _counted(self, why: LeaseRefusal | None) -> LeaseRefusal | None:
        self.refusals += why is not None
        return why

    # driving

    def _drive(self, session: Session, frame: DriveFrame) -> LeaseRefusal | None:
        now = self._now()
        command = frame.command()
        age = session.age_of_picture(frame, self.loop.age_of)
        if isinstance(age, LeaseRefusal):
            return age
        if now - session.driven > DEAD_MAN:
            session.lose_touch()
        if age > DEAD_MAN:
            session.lose_touch()
            return stale(frame.echo_tick, age)
        session.show_stick(command.holds, by_hand=frame.by_hand)
        why = blocked(self._other_drives(session), self.stopped, session, command)
        if why is None:
            self._obey(session, command, age)
        if self._holder is session:
            self.loop.sit_down_at(math.inf if command.holds else now + self._sit_after)
        return why

    def _other_drives(self, session: Session | None) -> LeaseRefusal | None:
        """Whether somebody else holds the lease; None stands for REST, which no lease is for."""
        holder = self.holder
        if holder is None or self._holder is session:
            return None
        return refusal(LeaseReason.OTHER_DRIVES, holder=self.holder_title or holder)

    def keeps_from_changing(self, name: str) -> LeaseRefusal | None:
        """Why whoever goes by this name (REST: ``""``) may not change the world: another drives."""
        holder = self.holder
        if holder in (None, REST, name):
            return None
        return refusal(LeaseReason.OTHER_DRIVES, holder=self.holder_title)

    def _obey(self, session: Session, command: Command, age: float) -> None:
        if self._holder is not session:
            self._hand_to(session)
        if not (command.holds and leaves_the_play(self.loop, session)):
            # so a frozen picture holds at the dead-man, not at twice that
            self.loop.order(slowed(command, age), max(TICK, DEAD_MAN - age))
        session.driven = self._now()
        session.moving = not command.holds

    # postures

    def _take_posture(self, session: Session, frame: PostureFrame) -> LeaseRefusal | None:
        """By the holder, or whoever finds the lease free."""
        age = session.age_of_picture(frame, self.loop.age_of)
        if isinstance(age, LeaseRefusal):
            return age
        if age > DEAD_MAN:
            return stale(frame.echo_tick, age)
        why = self._other_drives(session) or no_posture_now(self, LeaseReason.STOPPED)
        if why is None:
            if self._holder is not session:
                self._hand_to(session)
            session.freeze()
            self._begin_posture(frame.posture)
        return why

    def _begin_posture(self, posture: str) -> None:
        self.loop.sit_down_at(math.inf)
        self.loop.take_posture(posture)

    # taking, letting go, stopping

    def _take(self, session: Session) -> None:
        if self._holder is not session:
            self._quieten()
            self._free()
            self._holder = session
            session.freeze()

    def _release(self, session: Session) -> None:
        if self._holder is session:
            if not leaves_the_play(self.loop, session):
                self._quieten()
            self._free()
        session.let_go()

    def _hand_to(self, session: Session) -> None:
        log.info("%s drives", session.name)
        self._holder = session
        self.revision += 1

    def _quieten(self) -> None:
        """Somebody is there: the machine holds, in whatever posture, and does not sit down by
        itself.
        """
        self.loop.sit_down_at(math.inf)
        self.loop.halt()

    def _free(self) -> None:
        """The lease is free, and a stick left pressed moves nothing later."""
        if self._holder is not None:
            self._holder.freeze()
        self._holder = None
        self._rest.end()
        self.revision += 1

    def stop(self) -> None:
        """Anybody; the machine holds from the next tick on, until ``rearm``."""
        self._quieten()
        self.revision += self.latch.set(True)

    def _rearm(self, session: Session) -> LeaseRefusal | None:
        if self._holder is not session:
            return self._other_drives(session) or refusal(LeaseReason.TAKE_FIRST)
        if not session.centred:
            return refusal(LeaseReason.CENTRE_FIRST)
        self.revision += self.latch.set(False)
        return None

    # by REST, which holds no lease: only while no socket does

    def rearm(self, name: str = "") -> LeaseRefusal | None:
        """End a stop, as the page of this name or, for ``""``, as REST whose newest command is one
        to rest and lives.
        """
        if self._holder is not None and self._holder.name == name:
            return self._rearm(self._holder)
        why = self._other_drives(None)
        if why is None and self.stopped and self._now() > self._rest.at_rest_until:
            why = refusal(LeaseReason.REST_FIRST)
        if why is None:
            self.revision += self.latch.set(False)
        return self._counted(why)

    def command(self, command: Command, ttl: float) -> LeaseRefusal | None:
        """Drive for ``ttl`` s; the next socket waits until this has lapsed."""
        self._rest.show_stick(command.holds)
        why = self._other_drives(None)
        if why is None and self.stopped and not command.holds:
            why = refusal(LeaseReason.REARM_FIRST)
        if why is None:
            self.revision += self._rest.order(command.holds, self._now() + ttl)
            self.loop.sit_down_at(math.inf)
            if command.holds:
                self.loop.halt()
            self.loop.order(command, ttl)
        return self._counted(why)

    def take_posture(self, posture: str) -> LeaseRefusal | None:
        """Take a posture; it ends a command that REST has given."""
        why = self._other_drives(None) or no_posture_now(self, LeaseReason.REARM_FIRST)
        if why is None:
            self._rest.end()
            self._begin_posture(posture)
        return self._counted(why)

    def hold(self) -> None:
        """The machine holds and whoever drives must let go of the stick first: another world,
        another rate, the end.
        """
        if self._holder is not None:
            self._holder.freeze()
        self._rest.end()
        self.loop.sit_down_at(math.inf)
        self.loop.order(HOLD)


def leaves_the_play(loop: RealtimeLoop, session: Session) -> bool:
    """Whether a session at rest lets the timeline walk on that was begun since it drove: its last
    frames come after that.
    """
    return loop.playing and not session.moving


def no_posture_now(lease: ControlLease, when_stopped: LeaseReason) -> LeaseRefusal | None:
    """Why nobody may have a posture taken: a stop, or a machine on its way down."""
    newest = lease.loop.newest
    if lease.stopped:
        return refusal(when_stopped)
    if newest.mode in (Mode.TIPPING, Mode.FALLEN) and newest.reason:
        return refusal(LeaseReason.NO_POSTURE_NOW, why=newest.reason)
    return None


def blocked(
    other_drives: LeaseRefusal | None, stopped: bool, session: Session, command: Command
) -> LeaseRefusal | None:
    """Why this session may not move the machine now."""
    if other_drives is not None:
        return other_drives
    if stopped:
        return None if session.centred else refusal(LeaseReason.STOPPED)
    if session.must_centre and not command.holds:
        return refusal(LeaseReason.CENTRE_FIRST)
    return None
