"""What the walker is at, and what becomes of that when something happens: a table."""

from __future__ import annotations

from enum import Enum, IntEnum, auto


class Activity(IntEnum):
    """What the walker is at. (A number, since a name is hashed anew at every look into a table, and
    it is looked up every tick.)
    """

    STAND = auto()
    STEP = auto()
    SETTLE = auto()  # setting feet down after a step that was cut short
    REFLEX = auto()  # an emergent motion of one foot (H §9)
    HOVER = auto()  # a foot in the air has no ground to come down on
    POSTURE = auto()  # taking a posture on command


class Event(Enum):
    """What happens to it."""

    STEP_READY = "the next step is planned"
    POSTURE_READY = "a plan of the posture is next"
    AT_REST = "it stands on its feet with nothing to play"
    CUT_SHORT = "the body stops with feet in the air"
    TOUCHED = "a foot meets what the map does not show, or finds no ground"
    NO_PLACE = "there is no ground for a foot in the air"
    STEP_RESUMED = "ordered on, in a step"
    POSTURE_RESUMED = "ordered on, in a posture"
    REFLEX_RESUMED = "ordered on, in a reflex"


_A, _E = Activity, Event
# Where each event leads; what is not in a row cannot happen there.
TABLE: dict[Activity, dict[Event, Activity]] = {
    _A.STAND: {
        _E.STEP_READY: _A.STEP,
        _E.POSTURE_READY: _A.POSTURE,
        _E.AT_REST: _A.STAND,
        _E.TOUCHED: _A.REFLEX,
    },
    _A.STEP: {
        _E.STEP_READY: _A.STEP,
        _E.AT_REST: _A.STAND,
        _E.CUT_SHORT: _A.SETTLE,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
    _A.SETTLE: {
        _E.AT_REST: _A.STAND,
        _E.TOUCHED: _A.REFLEX,
    },
    _A.REFLEX: {
        _E.AT_REST: _A.STAND,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
    _A.HOVER: {
        _E.STEP_RESUMED: _A.STEP,
        _E.POSTURE_RESUMED: _A.POSTURE,
        _E.REFLEX_RESUMED: _A.REFLEX,
    },
    _A.POSTURE: {
        _E.POSTURE_READY: _A.POSTURE,
        _E.AT_REST: _A.STAND,
        _E.CUT_SHORT: _A.SETTLE,
        _E.TOUCHED: _A.REFLEX,
        _E.NO_PLACE: _A.HOVER,
    },
}
RESUMED = {
    Activity.STEP: Event.STEP_RESUMED,
    Activity.POSTURE: Event.POSTURE_RESUMED,
    Activity.REFLEX: Event.REFLEX_RESUMED,
}
STILL = (Activity.STAND, Activity.HOVER)  # nothing is played
PLACING = (Activity.SETTLE, Activity.REFLEX)  # feet come down after the plan they swung in


def after(activity: Activity, event: Event) -> Activity:
    """What the walker is at once ``event`` has happened; raises ``RuntimeError`` for one that
    cannot happen there.
    """
    row = TABLE[activity]
    if event not in row:
        known = ", ".join(each.name for each in row)
        raise RuntimeError(f"{event.name} cannot happen at {activity.name}; there are: {known}")
    return row[event]
