"""Walks by eye and by touch over ground that is mostly forbidden, up and down stairs, at walls."""

from __future__ import annotations

import pytest

from tests.sweeps.seams import Told, walk


def assert_stands_well(told: Told) -> None:
    assert told.falls == 0
    assert told.margin >= -0.001
    assert told.slide <= 0.005
    assert told.at_one_place <= 6


@pytest.mark.parametrize(
    ("sensing", "fraction", "seed"), [("eye", 0.04, 0), ("eye", 0.04, 2), ("none", 0.3, 1)]
)
def test_six_legs_cross_sparse_ground_that_is_seen_late_or_only_felt(
    sensing: str, fraction: float, seed: int
) -> None:
    told = walk(
        "k-curve",
        f"sensing={sensing}",
        f"terrain.fraction={fraction}",
        f"seed={seed}",
        "end={distance=8.0, time=900.0}",
    )
    assert told.ending == ("completed", "distance")
    assert_stands_well(told)


@pytest.mark.parametrize(("fraction", "seed"), [(0.3, 6), (0.1, 4)])
def test_six_swaying_legs_that_find_no_ground_stop_over_the_feet_that_stand(
    fraction: float, seed: int
) -> None:
    told = walk(
        "k-curve",
        "sensing=none",
        "gait.body=sway",
        f"terrain.fraction={fraction}",
        f"seed={seed}",
        "end={distance=2.5, time=150.0}",
    )
    assert_stands_well(told)


@pytest.mark.parametrize("name", ["fig15", "fig17-up", "fig17-down"])
@pytest.mark.parametrize("rise", [0.10, 0.15, 0.20])
@pytest.mark.parametrize("body", ["straight", "sway"])
def test_stairs_are_walked_by_touch_alone_in_the_papers_mode(
    name: str, rise: float, body: str
) -> None:
    told = walk(name, "sensing=none", "mode=paper", f"terrain.rise={rise}", f"gait.body={body}")
    assert told.ending == ("completed", "distance")
    assert told.forbidden == 0 and told.encounters.get("hit", 0) <= 15
    assert_stands_well(told)


# downwards: an edge just ahead of a sole, and just behind it, shown or not; no ground but far below
@pytest.mark.parametrize(
    ("name", "at"),
    [
        ("fig17-up", 1.225),
        ("fig17-up", 1.375),
        ("fig17-down", 1.225),
        ("fig17-down", 1.325),
        ("fig17-down", 1.35),
        ("fig17-down", 1.4),
        ("fig15", 1.325),
        ("fig15", 1.4),
    ],
)
def test_so_they_are_wherever_they_begin(name: str, at: float) -> None:
    told = walk(name, "sensing=none", "mode=paper", f"terrain.at={at}", "gait.body=sway", "seed=1")
    assert told.ending == ("completed", "distance")
    assert told.forbidden == 0 and told.encounters.get("hit", 0) <= 15
    assert_stands_well(told)


@pytest.mark.parametrize("mode", ["predictive", "paper"])
@pytest.mark.parametrize("angle", [0, 30, 60])
@pytest.mark.parametrize("height", [0.4, 1.0])
def test_a_wall_met_by_touch_is_gone_round_or_ends_in_a_reason(
    mode: str, angle: int, height: float
) -> None:
    told = walk(
        "block",
        "sensing=none",
        f"mode={mode}",
        f"terrain.height={height}",
        f"terrain.angle_deg={angle}",
        "terrain.at=2.0",
        "drive=[{t=0.0, speed=0.05}]",
        "end={time=240.0, distance=5.0}",
    )
    assert told.ending[0] == "blocked" or told.distance >= 5.0
    assert_stands_well(told)


def test_a_foot_that_cannot_be_drawn_over_a_wall_goes_back_to_where_it_stood() -> None:
    told = walk(
        "block",
        "sensing=none",
        "mode=predictive",
        'gait.body="straight"',
        "terrain.height=1.0",
        "terrain.angle_deg=60",
        "terrain.at=1.5",
        "end={time=40.0}",
    )
    assert told.ending[0] == "blocked" and "lifted foot" not in told.ending[1]
    assert_stands_well(told)


@pytest.mark.parametrize(
    ("mode", "height", "angle"),
    [
        ("predictive", 0.6, 15),
        ("predictive", 0.6, 30),
        ("paper", 0.4, 0),
        ("paper", 0.6, 30),
        ("paper", 1.0, 45),
    ],
)
def test_a_wall_that_is_seen_is_gone_round_with_legs_body_and_sway_clear_of_it(
    mode: str, height: float, angle: int
) -> None:
    told = walk(
        "block",
        "sensing=eye",
        f"mode={mode}",
        f"terrain.height={height}",
        f"terrain.angle_deg={angle}",
        "terrain.at=2.4",
        "drive=[{t=0.0, speed=0.08}]",
        "end={time=240.0, distance=6.0}",
    )
    assert told.ending == ("completed", "distance") and told.encounters == {}
    assert_stands_well(told)
