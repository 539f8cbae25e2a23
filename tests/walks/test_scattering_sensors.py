"""Walks with position monitors and a posture sensor that scatter."""

from __future__ import annotations

import pytest

from tests.sweeps.seams import walk


@pytest.mark.parametrize("name", ["flat", "rough"])
@pytest.mark.parametrize("robot", [("robot=titan3",), ("robot=hexapod", "planner=trace")])
def test_sensors_that_scatter_by_5_mm_and_half_a_degree_do_not_stop_the_walk(
    name: str, robot: tuple[str, ...]
) -> None:
    scatter = "noise={position=0.005, posture_deg=0.5}"
    told = walk(name, *robot, scatter, "end={time=40.0}")
    assert told.ending == ("completed", "time") and told.distance > 2.4
    assert told.falls == 0 and told.margin > 0.0


@pytest.mark.parametrize(("name", "way"), [("k-curve", 2.0), ("fig13", 3.5)])
def test_nor_one_whose_footholds_are_few_where_they_are_late_too(name: str, way: float) -> None:
    """A river as wide as the stride, and three legs that hang while the others are to rise."""
    scatter = "noise={position=0.005, posture_deg=0.5, delay=0.02}"
    told = walk(name, scatter, f"end={{time=90.0,distance={way}}}", "expect={}")
    assert told.ending == ("completed", "distance")
    assert told.falls == 0 and told.margin > 0.0
