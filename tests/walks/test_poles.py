"""Six legs among poles that the map shows: no leg meets one, standing or on its way."""

from __future__ import annotations

from tests.sweeps.seams import walk


def test_no_leg_swings_into_a_pole_between_its_hip_and_its_way() -> None:
    told = walk(
        "poles",
        "robot=hexapod",
        "planner=trace",
        'gait.body="straight"',
        "seed=1",
        "end={time=32.0}",
    )
    assert told.encounters == {} and told.halts == 0
    assert told.distance > 1.4 and told.margin > 0.01 and told.slide == 0.0
