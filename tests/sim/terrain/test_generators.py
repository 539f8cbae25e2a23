"""Every kind of terrain has the shape it says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tests.sim.terrain.grounds import FEET, GENERATED, SMOOTH, ground, terrain
from walking_console.sim.terrain.generators import (
    KINDS,
    Dem,
    Generated,
    Poles,
    Stairs,
    list_terrains,
)
from walking_console.sim.terrain.ground import GroundError


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_ground_has_cells_of_at_most_25_millimetres(kind: str) -> None:
    assert ground(kind).cell <= 0.025
    with pytest.raises(ValidationError):
        terrain(kind, cell=0.05)


@pytest.mark.parametrize("kind", GENERATED)
@pytest.mark.parametrize("level", [0, 0.3, 1.0])
def test_every_kind_takes_a_difficulty_and_can_be_made_at_it(kind: str, level: float) -> None:
    assert ground(kind, difficulty=level).heights.size > 0


@pytest.mark.parametrize("kind", [kind for kind in GENERATED if KINDS[kind].RAMP])  # type: ignore[attr-defined]
def test_difficulty_sets_what_is_not_given_and_explicit_parameters_win(kind: str) -> None:
    model: type[Generated] = KINDS[kind]  # type: ignore[assignment]
    for key, (easy, hard) in model.RAMP.items():
        assert getattr(terrain(kind, difficulty=0.0), key) == easy
        assert getattr(terrain(kind, difficulty=1), key) == hard
        given_value = type(easy)(hard)
        assert getattr(terrain(kind, difficulty=0.0, **{key: given_value}), key) == given_value


@pytest.mark.parametrize("kind", GENERATED)
def test_a_dump_says_every_parameter_and_loads_back_equal(kind: str) -> None:
    spec = terrain(kind, difficulty=0.7)
    again = terrain(**spec.model_dump(exclude_none=True))
    assert again == spec


@pytest.mark.parametrize("kind", GENERATED)
@pytest.mark.parametrize(
    "bad",
    [
        {"difficulty": 1.1},
        {"difficulty": True},
        {"seed": -1},
        {"seed": True},
        {"cell": 0.001},
        {"wide": 1},
    ],
)
def test_impossible_parameters_are_refused(kind: str, bad: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        terrain(kind, **bad)


def test_every_kind_is_listed_with_one_line() -> None:
    listed = dict(list_terrains())
    assert list(listed) == list(KINDS)
    assert all(line and "\n" not in line for line in listed.values())
    assert "rise" in listed["stairs"]


def test_a_slope_climbs_by_its_angle() -> None:
    made = ground("slope", angle_deg=10.0, span=3.0)
    rise = made.height_at(3.0125, 0.0) - made.height_at(-1.9875, 0.0)
    assert rise == pytest.approx(5.0 * math.tan(math.radians(10.0)))


def test_rough_ground_keeps_within_its_amplitude_and_uses_it() -> None:
    heights = ground("rough", amplitude=0.1, span=4.0).heights
    assert heights.max() <= 0.1 and heights.min() >= -0.1 and np.ptp(heights) > 0.15


def test_stairs_go_up_and_down_again() -> None:
    made = ground(
        "stairs", rise=0.1, tread=0.5, count=2, direction="up-down", landing=1.0, at=1.0, span=4.0
    )
    walked = [made.height_at(x, 0.0) for x in (0.9, 1.1, 1.6, 2.4, 2.6, 3.1)]
    assert walked == pytest.approx([0.0, 0.1, 0.2, 0.2, 0.1, 0.0])
    assert ground("stairs", rise=0.1, count=2, direction="down", span=4.0).height_at(
        3.5, 0.0
    ) == pytest.approx(-0.2)


@pytest.mark.parametrize("direction", ["up", "down", "up-down"])
@pytest.mark.parametrize("heading", [0.0, 90.0, 33.0])
def test_the_boxes_of_stairs_are_as_high_as_the_ground_under_them(
    direction: str, heading: float
) -> None:
    made = ground("stairs", direction=direction, heading_deg=heading, span=5.0, count=2)
    assert made.obstacles
    for box in made.obstacles:
        xs, ys = (np.mean([corner[axis] for corner in box.corners]) for axis in (0, 1))
        x, y = np.clip(xs, *made.bounds[:2]), np.clip(ys, *made.bounds[2:])
        if (x, y) == (xs, ys):
            assert made.height_at(x, y) == pytest.approx(box.top)


def test_a_block_lies_turned_about_its_middle_and_stands_in_the_plane_as_a_polygon() -> None:
    made = ground("block", height=0.2, length=2.0, width=0.4, at=2.0, angle_deg=90.0, span=4.0)
    assert made.height_at(3.0, 0.9) == 0.2 and made.height_at(2.1, 0.0) == 0.0
    (box,) = made.obstacles
    assert {(round(x, 6), round(y, 6)) for x, y in box.corners} == {
        (2.8, -1.0),
        (3.2, -1.0),
        (3.2, 1.0),
        (2.8, 1.0),
    }
    (ax, ay), (bx, by), (cx, cy) = box.corners[:3]
    assert (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0  # counter-clockwise


def test_a_pit_is_a_hollow_with_a_floor() -> None:
    made = ground("pit", depth=0.2, at=2.0, length=1.0)
    assert made.height_at(2.5, 0.0) == -0.2 and made.height_at(1.9, 0.0) == 0.0


def test_a_river_is_bottomless_from_bank_to_bank() -> None:
    made = ground("river", width=0.5, at=1.2)
    bed = [math.isnan(made.height_at(x, 0.3)) for x in (1.19, 1.21, 1.69, 1.71)]
    assert bed == [False, True, True, False]


def test_gaps_lie_between_ledges_of_different_heights() -> None:
    made = ground("gap", width=0.2, count=2, spacing=1.0, drop=0.1, at=1.0)
    assert [made.height_at(x, 0.0) for x in (0.9, 1.5, 2.5)] == [0.0, -0.1, 0.0]
    assert math.isnan(made.height_at(1.1, 0.0)) and math.isnan(made.height_at(2.1, 0.0))


@given(fraction=st.floats(0.0, 1.0), seed=st.integers(0, 2**62))
@settings(max_examples=20, deadline=None)
def test_holes_take_their_share_of_the_ground(fraction: float, seed: int) -> None:
    made = ground("holes", fraction=fraction, seed=seed, stand=FEET)
    assert np.isnan(made.heights).mean() == pytest.approx(fraction, abs=0.02)
    assert made.final


def test_footholds_take_their_share_and_the_start_posture_stands_on_some() -> None:
    made = ground("footholds", fraction=0.04, stand=FEET)
    assert np.isfinite(made.heights).mean() == pytest.approx(0.04, abs=0.01)
    assert made.final and all(made.height_at(x, y) == 0.0 for x, y in FEET)
    x, y = made.centre(*made.cell_at(*FEET[0]))  # type: ignore[misc]
    assert max(abs(x - FEET[0][0]), abs(y - FEET[0][1])) <= made.cell / 2 + 1e-9


def test_stones_are_square_and_bob_within_their_jitter() -> None:
    made = ground("stepping_stones", size=0.4, spacing=0.1, jitter=0.05, span=3.0)
    assert made.height_at(2.0, 2.0) == made.height_at(2.15, 1.85) != made.height_at(2.5, 2.0)
    assert math.isnan(made.height_at(2.25, 2.0)) and np.nanmax(abs(made.heights)) <= 0.05


def test_poles_stand_apart_in_their_area_and_clear_of_the_start() -> None:
    made = ground("poles", count=20, radius=0.06, area=[-2.0, 4.0, -2.0, 2.0], height=0.4)
    assert len(made.obstacles) == 20
    for index, pole in enumerate(made.obstacles):
        assert (
            pole.radius == 0.06
            and not pole.corners
            and made.height_at(pole.x, pole.y) == pole.top == 0.4
        )
        assert math.hypot(pole.x, pole.y) > 1.0
        assert all(
            math.hypot(pole.x - other.x, pole.y - other.y) >= 0.12 + 0.25
            for other in made.obstacles[:index]
        )


def test_too_many_poles_for_their_area_are_refused_in_words() -> None:
    with pytest.raises(GroundError, match="of 500 poles fit"):
        ground("poles", count=500)


def test_a_wave_has_the_height_and_length_it_says() -> None:
    made = ground("wave", amplitude=0.1, length=1.0)
    assert made.height_at(0.5, 0.0) == pytest.approx(0.2, abs=0.001) and made.height_at(
        1.0, 0.0
    ) == pytest.approx(0.0, abs=0.002)


def test_kinds_say_their_own_parameters() -> None:
    assert (
        Stairs(kind="stairs").count == 3
        and Poles(kind="poles").radius == 0.05
        and Dem(kind="dem").relief == 2000.0
    )
