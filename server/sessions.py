"""One socket's part in driving: its last number, its stick, its allowance of frames, and how long
its silence is borne; and REST's, which has no socket.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from walking_console.planner.types import Command

from .lease_reasons import LeaseReason, LeaseRefusal, refusal
from .limits import DRIVE_BURST, DRIVE_BURST_AFTER_SILENCE, DRIVE_FRAMES_PER_SECOND
from .schemas import DriveFrame, PostureFrame

DEAD_MAN = 0.5  # s: shorter stops on every hiccup of a wireless link, longer walks on blindly
# s without a fresh frame from a pressed stick after which the machine sits down; shorter: see it
# sit on every bad link
SIT_AFTER = 10.0
# s, age of the picture up to which a stick moves as far as it is pushed; from there on it moves the
# machine less, down to nothing at the dead-man: who sees the past drives slower. Shorter: every
# hiccup of a wireless link is felt
FULL_SPEED_AGE = 0.25
LEASE_IDLE = 15.0  # s without a frame after which the lease is free


def slowed(command: Command, age: float) -> Command:
    """The command of somebody whose picture is ``age`` s old."""
    part = (DEAD_MAN - age) / (DEAD_MAN - FULL_SPEED_AGE)
    if part >= 1.0:
        return command
    part = max(0.0, part)
    return replace(command, speed=part * command.speed, turn_rate=part * command.turn_rate)


class TooFast(Exception):
    """A socket that sends more than it may; it is to be closed."""


@dataclass(eq=False)
class Session:
    """One socket's part in driving: its last number, its stick, its allowance of frames."""

    name: str
    title: str = ""  # for people
    sequence: int = -1
    watches: bool = False  # it may stop, and nothing else
    centred: bool = True  # the stick as last seen
    must_centre: bool = False  # no motion before the stick has been seen at rest
    heard: float = 0.0  # s, last frame of any kind
    driven: float = 0.0  # s, last accepted drive frame
    moving: bool = False  # whether that one asked for motion
    allowance: float = DRIVE_BURST
    counted: float = 0.0  # s, when the allowance was last drawn on

    def count(self, now: float) -> None:
        """Take one frame out of the allowance; raises ``TooFast`` when there is none left."""
        earned = (now - self.counted) * DRIVE_FRAMES_PER_SECOND
        ceiling = max(DRIVE_BURST, min(earned, DRIVE_BURST_AFTER_SILENCE))
        self.allowance = max(self.allowance, min(ceiling, self.allowance + earned)) - 1.0
        self.counted = self.heard = now
        if self.allowance < 0.0:
            raise TooFast(f"more than {DRIVE_FRAMES_PER_SECOND:g} frames a second")

    def freeze(self) -> None:
        """A stick left pressed moves nothing until it has been seen at rest."""
        self.must_centre = not self.centred
        self.moving = False

    def show_stick(self, at_rest: bool, *, by_hand: bool) -> None:
        """How the stick stands. A page that holds by itself, because it hung or its picture is old,
        has not seen a hand let go: that still has to come.
        """
        if at_rest and not by_hand:
            self.freeze()
            return
        self.centred = at_rest
        if at_rest:
            self.must_centre = False

    def lose_touch(self) -> None:
        """Its motion has lapsed: it must be seen at rest before the next."""
        if self.moving:
            self.must_centre = True
        self.moving = False

    def let_go(self) -> None:
        """The stick is at rest."""
        self.centred = True
        self.must_centre = False
        self.moving = False

    def age_of_picture(
        self, frame: DriveFrame | PostureFrame, age_of: Callable[[int], float | None]
    ) -> float | LeaseRefusal:
        """How old the picture is that a frame answers, s; or why the frame is none of this
        moment.
        """
        if frame.seq <= self.sequence:
            return refusal(LeaseReason.OUT_OF_ORDER, seq=frame.seq, last=self.sequence)
        self.sequence = frame.seq
        age = age_of(frame.echo_tick)
        return refusal(LeaseReason.NOT_SHOWN, tick=frame.echo_tick) if age is None else age


@dataclass(eq=False)
class RestSession:
    """The part of REST in driving, which holds no lease: its commands lapse by themselves."""

    until: float = 0.0  # s, its last command lives
    at_rest_until: float = -math.inf  # s, its stick counts as seen at rest
    drives: bool = False  # as last said

    def order(self, holds: bool, until: float) -> bool:
        """One command, which lives until then; whether that changes who drives."""
        self.until = 0.0 if holds else until
        if holds:
            self.at_rest_until = until
        changed = self.drives == holds
        self.drives = not holds
        return changed

    def show_stick(self, at_rest: bool) -> None:
        """How the stick stands, whatever comes of the command."""
        if not at_rest:
            self.at_rest_until = -math.inf

    def lapses(self, now: float) -> bool:
        """Whether it drove, as last said, and does no longer."""
        if not self.drives or now < self.until:
            return False
        self.drives = False
        return True

    def end(self) -> None:
        """Its command lives no longer."""
        self.until = 0.0
