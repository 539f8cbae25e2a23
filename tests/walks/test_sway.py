"""Whole walks with the body swayed into its supports: the same way, with the margin kept."""

import numpy as np
import pytest

from tests.sweeps.margins import margins_of, shares_of
from tests.sweeps.stops import stop_after
from walking_console.planner.motion.body_bounds import BRISK, STEEPEST
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Mode

from .telling import walked

SWAY = ('gait.body="sway"', "expect={}")


def acceleration(log):
    places = log["body"][:, :2]
    return np.hypot(*(np.diff(places, 2, axis=0) / 0.02**2).T)


def over_allowed(walk):
    """The acceleration of every tick over g·margin/h."""
    machine = load_machine(walk.summary["robot"]["name"])
    return shares_of(walk.log, margins_of(walk.log, machine))


@pytest.mark.parametrize("angle", [0.0, 45.0, 90.0])
def test_on_level_ground_the_margin_and_the_acceleration_are_kept_at_every_tick(tmp_path, angle):
    drive = f"drive=[{{t=0.0,crab_angle_deg={angle},speed=0.08}}]"
    walk = walked(tmp_path, "flat", *SWAY, drive, "end={time=30.0}")
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.02
    assert over_allowed(walk).max() <= 1.0 and acceleration(walk.log).max() <= BRISK
    assert walk.summary["mean_speed"] >= (0.9 if angle == 90.0 else 0.97) * 0.08


@pytest.mark.parametrize(("degrees", "course"), [(12.0, 0.0), (10.0, 45.0), (15.0, 270.0)])
def test_a_body_that_leans_with_its_slope_keeps_both_too(tmp_path, degrees, course):
    aslant = f'terrain={{kind="slope",angle_deg={degrees},heading_deg=90.0}}'
    drive = f"drive=[{{t=0.0,crab_angle_deg={course},speed=0.08}}]"
    walk = walked(tmp_path, "hillside", *SWAY, aslant, drive, "end={time=40.0}")
    log = walk.log
    assert np.abs(log["body"][-1, 3:5]).max() > 0.03 and walk.summary["distance"] > 1.5
    margins = margins_of(log, load_machine(walk.summary["robot"]["name"]))
    assert margins.min() >= 0.02
    # it may stop for as long as it weighs how far to lean
    assert over_allowed(walk).max() <= 1.0 and acceleration(log).max() <= STEEPEST * 1.001
    assert touch_speeds(walk).max() <= 0.15


@pytest.mark.parametrize("name", ["river", "holes"])
def test_on_broken_ground_the_margin_is_kept_where_straight_it_is_millimetres(shared, name):
    walk = shared.walked(name, 'gait.body="sway"')
    assert walk.summary["result"] == "completed" and walk.summary["forbidden_steps"] == 0
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.019


def test_six_legs_keep_it_along_a_curve(tmp_path):
    walk = walked(tmp_path, "k-curve", *SWAY)
    assert walk.summary["result"] == "completed" and walk.summary["falls"] == 0
    assert min(step["planned_polygon_margin_min"] for step in walk.steps) >= 0.015


@pytest.mark.parametrize("name", ["omni", "k-turn", "k-free-vs-rigid"])
def test_courses_that_turn_keep_the_margin_until_every_foot_has_landed(tmp_path, name):
    walk = walked(tmp_path, name, *SWAY, "gait.margin=0.02")
    assert walk.summary["falls"] == 0
    assert margins_of(walk.log, load_machine(walk.summary["robot"]["name"])).min() >= 0.018


def test_a_trace_with_corners_is_walked_without_jerks(tmp_path):
    walk = walked(tmp_path, "k-free-vs-rigid", *SWAY)
    assert walk.summary["result"] == "completed"
    assert over_allowed(walk).max() <= 1.0
    stops = walk.log["mode"] == Mode.SETTLE
    stops = stops[:-2] | stops[1:-1] | stops[2:]
    # a twentieth more where a corner comes too soon to slow down for it
    assert acceleration(walk.log)[~stops].max() <= 1.05 * BRISK
    assert acceleration(walk.log)[stops].max() <= STEEPEST * 1.001


def touch_speeds(walk):
    """How fast every foot came down when its sole came on, m/s."""
    log = walk.log
    falling = -np.diff(log["feet"][..., 2], axis=0) / 0.02
    on = ~log["contact"][:-1] & log["contact"][1:]
    return falling[on]


@pytest.mark.parametrize("name", ["flat", "rough", "stairs-up", "tripod"])
def test_feet_come_down_softly_on_known_ground_and_the_body_has_no_jumps(shared, name):
    walk = shared.walked(name, 'gait.body="sway"')
    assert all(expected["pass"] for expected in walk.summary["expect"].values())
    assert touch_speeds(walk).max() <= 0.15
    assert over_allowed(walk).max() <= 1.0 and acceleration(walk.log).max() <= BRISK


@pytest.mark.parametrize("speed", [0.08, 0.5])
@pytest.mark.parametrize("degrees", [-60.0, 0.0, 45.0, 90.0, 165.0])
def test_a_stop_at_any_phase_is_short_and_the_zero_moment_point_stays_inside(degrees, speed):
    for tick in (323, 410, 495, 560):
        seconds, _, least = stop_after(tick, degrees, speed)
        assert seconds <= 0.4 and least >= 0.003


@pytest.mark.parametrize("slow", [0.005, 0.02])
def test_a_creeping_stick_that_is_pushed_is_answered_within_the_acceleration(tmp_path, slow):
    """A step planned for minutes is played ever faster, and as planned again at its end."""
    drive = f"drive=[{{t=0.0,speed={slow}}},{{t=4.0,speed=0.25}}]"
    walk = walked(tmp_path, "flat", *SWAY, drive, "end={time=20.0}")
    assert over_allowed(walk).max() <= 1.0 and acceleration(walk.log).max() <= BRISK
    assert walk.summary["distance"] >= 1.2


def test_no_foot_lands_within_a_centimetre_of_a_hole_unless_it_may(tmp_path):
    for edge in (0.01, 0.0):
        walk = walked(tmp_path, "holes", f"terrain.edge={edge}", "expect={}")
        places = np.array([step["landing"][:2] for step in walk.steps if step["landing"]])
        around = [
            walk.ground_at(places + (dx, dy))
            for dx in (-0.0099, 0.0099)
            for dy in (-0.0099, 0.0099)
        ]
        assert np.isnan(around).any() == (edge == 0.0)
