"""Why a frame or a request to drive has no effect: a reason for programs, a sentence for people."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

AGE_SAID = 999.0  # s, no picture is said to be older


class LeaseReason(StrEnum):
    """Why a frame or a request has no effect."""

    TAKE_FIRST = "take_first"
    CENTRE_FIRST = "centre_first"
    STOPPED = "stopped"
    REARM_FIRST = "rearm_first"
    REST_FIRST = "rest_first"
    OTHER_DRIVES = "other_drives"
    OUT_OF_ORDER = "out_of_order"
    NOT_SHOWN = "not_shown"
    STALE = "stale"
    NO_POSTURE_NOW = "no_posture_now"
    WATCHES = "watches"


TEXTS = {
    LeaseReason.TAKE_FIRST: "take the lease first",
    LeaseReason.CENTRE_FIRST: "let go of the stick first",
    LeaseReason.STOPPED: "stopped: let go of the stick and rearm",
    LeaseReason.REARM_FIRST: "stopped: rearm first",
    LeaseReason.REST_FIRST: "stopped: show the stick at rest first, by a command of no speed and "
    "no turn, then rearm while that lives",
    LeaseReason.OTHER_DRIVES: "{holder} is driving",
    LeaseReason.OUT_OF_ORDER: "out of order: {seq} after {last}",
    LeaseReason.NOT_SHOWN: "echo_tick {tick} has not been shown yet",
    LeaseReason.STALE: "stale: the picture of tick {tick} is {age:.1f} s old",
    LeaseReason.NO_POSTURE_NOW: "{why}",
    LeaseReason.WATCHES: "this link may watch and stop, not drive",
}


@dataclass(frozen=True)
class LeaseRefusal:
    """Why not: the reason, and the sentence for people."""

    reason: LeaseReason
    text: str


def refusal(reason: LeaseReason, **values: object) -> LeaseRefusal:
    """A reason with its sentence filled in."""
    return LeaseRefusal(reason, TEXTS[reason].format(**values))


def stale(tick: int, age: float) -> LeaseRefusal:
    """The picture of ``tick``, which a frame answers, is ``age`` s old."""
    return refusal(LeaseReason.STALE, tick=tick, age=min(age, AGE_SAID))
