"""Rivers at many places and of many widths: a rate, where one picture shows one lucky place."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sweeps.seams import walk

from .telling import walked


@pytest.mark.parametrize("degrees", [0, 16])
@pytest.mark.parametrize("place", [1.2, 1.325, 1.475, 1.7, 1.9, 2.125])
def test_looking_ahead_figure_13_is_crossed_wherever_its_river_is(
    degrees: int, place: float
) -> None:
    told = walk(
        "fig13",
        "mode=predictive",
        f"drive=[{{t=0.0, crab_angle_deg={degrees}, speed=0.08}}]",
        f"terrain.at={place}",
    )
    assert told.ending == ("completed", "distance") and told.forbidden == 0


@pytest.mark.parametrize("place", [1.3, 1.55, 1.7, 1.9])
def test_no_step_of_the_papers_mode_is_planned_outside_the_polygon(
    place: float, tmp_path: Path
) -> None:
    walk = walked(tmp_path, "fig13", f"terrain.at={place}", "expect={}")
    assert walk.steps and min(step["planned_margin_min"] for step in walk.steps) >= -1e-5
    assert walk.log["margin"].min() >= -0.001


@pytest.mark.parametrize("width", [0.3, 0.37, 0.44, 0.5])
def test_six_legs_cross_a_river_from_the_last_cell_of_its_bank(width: float) -> None:
    told = walk(
        "river",
        "robot=hexapod",
        "planner=trace",
        "end={time=120.0, distance=4.0}",
        f"terrain.width={width}",
    )
    assert told.ending == ("completed", "distance") and told.forbidden == 0
