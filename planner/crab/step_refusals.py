"""Why a leg cannot swing or a foothold cannot be used, in the words of H §5 and §6."""

from __future__ import annotations

from enum import Enum


class StepRefusal(Enum):
    """Why a leg cannot swing or a foothold cannot be used; the value is the text that is shown."""

    # of the swing of a leg, whatever its foothold (H §5.2)
    MISSES = "the course misses the triangle of the other feet"
    LEFT = "the centre of gravity has already left the triangle of the other feet"
    NOT_YET = "the centre of gravity is not yet in the triangle of the other feet"
    TOO_LATE = (
        "the centre of gravity cannot enter the triangle of the other feet before a leg leaves "
        "its reach"
    )
    UNCARRIED = "the centre of gravity would leave the feet on the way into the triangle"
    KEPT_DOWN = "the body cannot be led far enough over the other feet before it lifts"
    NO_FOOTHOLD = "no foothold in the search domain"
    NONE_IN_REACH = "no foothold in reach"
    NOTHING = "the step would change nothing"
    # of a foothold (H §5.3, §6)
    PROHIBITED = "prohibited cell"
    UNKNOWN_GROUND = "no ground known there"
    TOO_UNEVEN = "too high or too low for the legs to reach together"
    LIFT = "the foot cannot be lifted over the ground on the way"
    TALL = "a leg would run into something tall"
    # whatever the foothold: no use to try another with this shift
    STANDING_LEG = "a leg that stands would run into something tall"
