"""A hexapod on its trace planner over ground that is not level: hills, a block, stairs."""

from pathlib import Path

import pytest

from .telling import assert_always_true, walked

SIX_LEGS = ("robot=hexapod", "planner=trace")


@pytest.mark.parametrize(
    ("scenario", "ground"),
    [
        ("rough", "terrain.amplitude=0.1"),
        ("block", "terrain.height=0.1"),
        ("stairs-up", "terrain.rise=0.1"),
        ("stairs-down", "terrain.rise=0.1"),
    ],
)
def test_what_must_always_be_true_is_so_on_ground_that_is_not_level(
    scenario: str, ground: str, tmp_path: Path
) -> None:
    walk = walked(tmp_path, scenario, *SIX_LEGS, ground)
    assert_always_true(walk)
    assert walk.summary["reason"] == "distance"
