"""K requirement 2: a trace that bends round what the map or the eye shows across it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sweeps.seams import walk

from .telling import walked

TO_THE_END = "end={distance=8.0, time=200.0}"
GROUNDS = {
    "poles": 'terrain={kind="poles"}',
    "block": 'terrain={kind="block", at=2.6, height=0.8, length=0.8, width=0.6}',
}


@pytest.mark.parametrize("ground", GROUNDS)
def test_it_is_walked_to_the_goal_round_poles_and_round_a_block(ground: str) -> None:
    told = walk("k-curve", GROUNDS[ground], TO_THE_END)
    assert told.ending == ("completed", "distance")
    assert told.falls == 0 and told.forbidden == 0 and told.margin >= -0.001
    assert told.encounters == {} and told.slide <= 0.005


def test_with_a_detour_of_0_it_stops_before_the_block_on_its_trace(tmp_path: Path) -> None:
    settings = GROUNDS["block"], "trace.detour=0", TO_THE_END, "expect={}"
    summary = walked(tmp_path, "k-curve", *settings).summary
    assert summary["result"] == "blocked" and "the torso would touch" in summary["reason"]
    assert summary["off_trace"] < 0.16


def test_round_ponds_seen_by_eye_it_is_off_its_trace_and_comes_back_to_it(tmp_path: Path) -> None:
    told = walked(tmp_path, "k-detour")
    assert told.summary["result"] == "completed"
    assert 0.5 < told.summary["off_trace"] < 1.4
    said = {step.get("departure") for step in told.steps}
    assert "trace_bent" in said and None in said


def test_among_poles_a_joysticks_course_bends_too() -> None:
    told = walk(
        "poles", "robot=hexapod", "planner=trace", "seed=0", "end={time=120.0,distance=5.0}"
    )
    assert told.ending == ("completed", "distance")
    assert told.falls == 0 and told.encounters == {}
