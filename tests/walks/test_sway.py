"""Whole walks with the body swayed into its supports: the same way, with the margin kept."""

import numpy as np
import pytest

from .telling import walked

SWAY = ('gait.body="sway"', "expect={}")


def acceleration(log):
    places = log["body"][:, :2]
    return np.hypot(*(np.diff(places, 2, axis=0) / 0.02**2).T)


@pytest.mark.parametrize("angle", [0.0, 45.0, 90.0])
def test_on_level_ground_the_margin_and_the_acceleration_are_kept_at_every_tick(tmp_path, angle):
    drive = f"drive=[{{t=0.0,crab_angle_deg={angle},speed=0.08}}]"
    walk = walked(tmp_path, "flat", *SWAY, drive, "end={time=30.0}")
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.019
    assert acceleration(walk.log).max() <= 0.25
    assert walk.summary["mean_speed"] >= (0.9 if angle == 0.0 else 0.85) * 0.08


@pytest.mark.parametrize("name", ["river", "holes"])
def test_on_broken_ground_the_margin_is_kept_where_straight_it_is_millimetres(tmp_path, name):
    walk = walked(tmp_path, name, *SWAY)
    assert walk.summary["result"] == "completed" and walk.summary["forbidden_steps"] == 0
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.019


def test_six_legs_keep_it_along_a_curve(tmp_path):
    walk = walked(tmp_path, "k-curve", *SWAY)
    assert walk.summary["result"] == "completed" and walk.summary["falls"] == 0
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.015
