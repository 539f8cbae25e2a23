"""Walks that turn: on the spot, round circles at any crab angle, in and out of straight walking, on
whole and on broken ground.
"""

import math

import numpy as np
import pytest

from .telling import assert_always_true, walked

BROKEN = 'terrain={{kind="holes", fraction=0.3, cell=0.05, seed={seed}}}'
INSIDE = -0.001  # m; a margin counts as non-negative from there


def turned(walk):
    """How far the torso has turned at the end, degrees."""
    return math.degrees(np.unwrap(walk.log["body"][:, 5])[-1])


def told(folder, *settings):
    walk = walked(folder, "circle", "expect={}", *settings)
    assert_always_true(walk)
    assert walk.log["polygon_margin"].min() >= INSIDE
    assert walk.summary["result"] == "completed", walk.summary["reason"]
    return walk


def driven(*entries):
    """A drive of (seconds, crab angle, speed, turn rate in degrees)."""
    keys = ("t", "crab_angle_deg", "speed", "turn_rate_deg_s")
    tables = (
        ", ".join(f"{k}={float(v)}" for k, v in zip(keys, entry, strict=True)) for entry in entries
    )
    return "drive=[" + ", ".join(f"{{{table}}}" for table in tables) + "]"


@pytest.mark.parametrize("ground", ["flat", "broken"])
@pytest.mark.parametrize("rate", [8.0, -8.0])
def test_it_turns_right_round_on_the_spot(tmp_path, rate, ground):
    ground = (BROKEN.format(seed=31),) if ground == "broken" else ()
    walk = told(tmp_path, driven((0, 0, 0, rate)), "end={time=50.0}", *ground)
    assert turned(walk) * math.copysign(1, rate) >= 360.0
    assert np.hypot(*walk.log["body"][:, :2].T).max() < 0.3
    assert abs(walk.summary["distance"]) < 0.3, "turning alone is no way"


CIRCLES = [(1, 0, 1), (1, 90, 2), (2, 135, 3), (2, 0, 4), (5, 45, 5)]
# of the time that the pace would take; a swaying body goes as fast as keeps its margin
SLACK = {"straight": 1.15, "sway": 1.45}


@pytest.mark.parametrize("body", SLACK)
@pytest.mark.parametrize(("radius", "degrees", "seed"), CIRCLES)
def test_it_goes_round_circles_on_broken_ground(tmp_path, radius, degrees, seed, body):
    speed, share = 0.06, 1.0 if radius < 5 else 0.3
    seconds = share * 2 * math.pi * radius / speed * SLACK[body]
    rate = math.degrees(speed / radius) * (1 if seed % 2 else -1)
    walk = told(
        tmp_path,
        driven((0, degrees, speed, rate)),
        f"end={{time={seconds}}}",
        f"gait.body={body}",
        BROKEN.format(seed=seed),
    )
    assert abs(turned(walk)) >= 340.0 * share


def test_it_closes_the_circle_it_was_told_to_walk(shared):
    walk = shared.walked("circle")
    assert_always_true(walk)
    assert all(entry["pass"] for entry in walk.summary["expect"].values())
    places = walk.log["body"][:, :2]
    assert np.hypot(places[:, 0], places[:, 1] - 2.0) == pytest.approx(2.0, abs=0.2)


def test_after_turning_both_ways_it_is_back_in_the_standard_gait(shared):
    walk = shared.walked("spot-turn")
    assert_always_true(walk)
    assert all(entry["pass"] for entry in walk.summary["expect"].values())


def test_it_bends_into_an_arc_and_out_of_it_in_the_middle_of_a_walk(tmp_path):
    drive = driven(
        (0, 0, 0.08, 0),
        (11.3, 0, 0.08, 5),
        (24.9, 0, 0.08, -5),
        (40.1, 60, 0.06, 0),
        (60.7, 60, 0.0, 6),
        (75, 0, 0.08, 0),
    )
    walk = told(tmp_path, drive, "end={time=110.0}")
    assert walk.steps[-1]["planned_margin_min"] == pytest.approx(walk.steps[-1]["s0"], abs=1e-3)
    assert walk.summary["distance"] > 4.5


def test_it_reverses_an_arc_and_stops_and_starts_in_it(tmp_path):
    drive = driven(
        (0, 0, 0.07, 4),
        (15.1, 180, 0.07, -4),
        (30.3, 0, 0, 0),
        (33, 180, 0.07, -4),
        (45.7, 90, 0, 0),
        (47, 90, 0.05, 7),
    )
    walk = told(tmp_path, drive, "end={time=70.0}", BROKEN.format(seed=8))
    assert walk.summary["emergent"] == {}


@pytest.mark.parametrize("seed", [1, 2])
def test_a_restless_hand_on_both_axes_never_makes_it_fall_or_stand_for_good(tmp_path, seed):
    rng, t, entries = np.random.default_rng(seed), 0.0, []
    while t < 60.0:
        entries.append(
            (
                round(t, 2),
                rng.uniform(-180, 180),
                rng.choice([0.0, 0.05, 0.1]),
                rng.choice([0.0, rng.uniform(-10, 10)]),
            )
        )
        t += rng.uniform(0.2, 5.0)
    entries.append((60.0, 0.0, 0.08, 0.0))
    walk = told(tmp_path, driven(*entries), "end={time=90.0}", BROKEN.format(seed=seed))
    ahead = walk.log["body"][-1, :2] - walk.log["body"][3000, :2]
    assert np.hypot(*ahead) > 1.2
