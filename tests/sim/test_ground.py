"""The true ground: what every kind looks like, and what no height file may be."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image
from pydantic import TypeAdapter, ValidationError

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.sim.terrain.generators import (
    KINDS,
    AnyTerrain,
    Dem,
    Generated,
    Poles,
    Stairs,
    list_terrains,
)
from walking_console.sim.terrain.ground import Ground, GroundError, make_ground

TITAN = load_machine("titan3")
GENERATED = [kind for kind in KINDS if kind != "file"]
SMOOTH = ("slope", "rough", "wave", "dem")
FEET = [(0.5, 0.475), (-0.4, 0.475), (-0.6, -0.475), (0.3, -0.475)]
START = (0.0, 0.0, 0.0)


def terrain(kind: str, **parameters: Any) -> Any:
    return TypeAdapter(AnyTerrain).validate_python({"kind": kind, **parameters})


def ground(
    kind: str,
    *,
    span: Any = 0.0,
    seed: int = 1,
    stand: Any = (),
    start: Any = START,
    **parameters: Any,
) -> Ground:
    return make_ground(terrain(kind, **parameters), TITAN, start, seed, span, None, stand)


def from_file(path: Path, **parameters: Any) -> Ground:
    return make_ground(terrain("file", file=path.name, **parameters), TITAN, base=path.parent)


# every kind


@pytest.mark.parametrize("kind", GENERATED)
def test_maps_reach_two_metres_beyond_the_course(kind: str) -> None:
    x_min, x_max, y_min, y_max = ground(kind, span=(0.0, 9.0, -1.0, 3.0)).bounds
    assert x_min <= -2.0 and x_max >= 11.0 and y_min <= -3.0 and y_max >= 5.0


def test_flat_ground_reaches_twelve_metres_from_the_start_in_every_direction() -> None:
    x_min, x_max, y_min, y_max = ground("flat", start=(3.0, -2.0, 1.0)).bounds
    assert x_min <= -9.0 and x_max >= 15.0 and y_min <= -14.0 and y_max >= 10.0


def test_flat_ground_holds_an_hour_of_walking_in_a_million_cells() -> None:
    far = ground("flat", span=360.0)
    assert far.heights.size <= 1_000_000 and far.bounds[1] >= 362.0 and far.level == 0.0


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_ground_has_cells_of_at_most_25_millimetres(kind: str) -> None:
    assert ground(kind).cell <= 0.025
    with pytest.raises(ValidationError):
        terrain(kind, cell=0.05)


@pytest.mark.parametrize("kind", GENERATED)
def test_the_start_posture_finds_ground(kind: str) -> None:
    made = ground(kind, stand=FEET, seed=3)
    assert all(math.isfinite(made.height_at(x, y)) for x, y in FEET)


@pytest.mark.parametrize(
    "kind", [kind for kind in GENERATED if kind not in ("slope", "dem", "rough", "wave")]
)
def test_the_ground_around_the_start_is_level(kind: str) -> None:
    made = ground(kind, seed=3)
    assert {made.height_at(x, y) for x, y in FEET} == {0.0}


@pytest.mark.parametrize("kind", GENERATED)
def test_a_longer_course_finds_the_same_ground(kind: str) -> None:
    near, far = ground(kind, span=1.0), ground(kind, span=9.0)
    row, column = (
        round((a - b) / near.cell) for a, b in zip(near.origin[::-1], far.origin[::-1], strict=True)
    )
    same = far.heights[row : row + near.rows, column : column + near.columns]
    np.testing.assert_allclose(same, near.heights, atol=1e-12)


@pytest.mark.parametrize("kind", GENERATED)
def test_the_same_seed_gives_the_same_ground_bit_for_bit(kind: str) -> None:
    assert ground(kind, seed=7).heights.tobytes() == ground(kind, seed=7).heights.tobytes()


@pytest.mark.parametrize("kind", ["rough", "holes", "footholds", "poles", "stepping_stones"])
def test_another_seed_gives_other_ground_and_the_terrains_own_seed_wins(kind: str) -> None:
    one, two = ground(kind, seed=1), ground(kind, seed=2)
    assert one.heights.tobytes() != two.heights.tobytes()
    own = make_ground(terrain(kind, seed=1), TITAN, START, 2)
    assert own.heights.tobytes() == one.heights.tobytes()


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


def test_cells_sit_on_multiples_of_their_size_and_agree_with_the_belief() -> None:
    made = ground("holes", fraction=0.5)
    belief = TerrainMap(made.heights, np.isnan(made.heights), made.cell, made.origin)
    for x, y in np.random.default_rng(1).uniform(-6.5, 6.5, (500, 2)):
        assert made.index(x, y) == belief.index(x, y)
        assert made.height_at(x, y) == belief.height_at(x, y) or math.isnan(made.height_at(x, y))


# the shapes


def test_outside_the_map_there_is_no_ground() -> None:
    assert math.isnan(ground("flat").height_at(100.0, 0.0))


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


def test_the_elevation_model_is_matplotlibs_at_walking_scale() -> None:
    """H has no such ground; the contract says 344 x 403 heights, 13 degrees median and 36 at most
    in nature.
    """
    sample = np.load(_matplotlib_sample())
    elevation = sample["elevation"][::-1].astype(float)
    made = ground(
        "dem", scale=1000.0, relief=1000.0, offset=[10.0, 10.0], span=(0.0, 15.0, -5.0, 5.0)
    )
    east, north = 0.074266, 0.092667
    column, row = 200, 120
    here = made.height_at(column * east - 10.0, row * north - 10.0) - made.height_at(
        150 * east - 10.0, row * north - 10.0
    )
    assert here == pytest.approx((elevation[row, column] - elevation[row, 150]) / 1000.0, abs=0.02)
    slope = np.degrees(np.arctan(np.hypot(*np.gradient(elevation, 92.667, 74.266))))
    assert np.median(slope) == pytest.approx(13.0, abs=0.5) and slope.max() == pytest.approx(
        36.0, abs=0.5
    )


def _matplotlib_sample() -> Path:
    cbook = pytest.importorskip("matplotlib.cbook")
    return Path(cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False))


def test_the_elevation_model_has_hills_to_walk_and_no_walls() -> None:
    made = ground("dem", span=(0.0, 16.0, -3.0, 3.0))
    assert abs(made.height_at(0.0, 0.0)) < 0.005
    assert np.ptp([made.height_at(x, 0.0) for x in np.arange(0.0, 16.0, 0.1)]) > 0.15
    assert classify(made.heights, made.cell, TITAN).mean() < 0.01


def test_the_elevation_model_goes_on_mirrored_beyond_its_edges() -> None:
    made = ground("dem", offset=[1.0, 16.0], span=4.0)
    for depth in (0.25, 1.0, 2.0):
        assert made.height_at(-1.0 - depth, 0.5) == pytest.approx(
            made.height_at(-1.0 + depth, 0.5), abs=0.02
        )


def test_the_elevation_model_can_be_turned() -> None:
    east, north = ground("dem", span=3.0), ground("dem", span=3.0, heading_deg=90.0)
    askew = ground("dem", span=3.0, heading_deg=30.0)
    assert north.height_at(0.0, -2.0) == pytest.approx(east.height_at(2.0, 0.0), abs=0.01)
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    assert askew.height_at(c * 2.0, -s * 2.0) == pytest.approx(east.height_at(2.0, 0.0), abs=0.01)


def test_a_course_too_long_for_a_map_is_refused_in_words() -> None:
    with pytest.raises(GroundError, match="shorten"):
        ground("rough", span=200.0)


def test_a_start_over_a_hole_is_refused_in_words() -> None:
    with pytest.raises(GroundError, match="foot 1 .* over a hole"):
        ground("river", at=0.4, width=0.3, stand=FEET)


# edits


def test_edited_ground_is_new_ground() -> None:
    before = ground("flat")
    after = before.edited([(3, 4, -0.2), (5, 6, math.nan)])
    assert after.heights[3, 4] == -0.2 and math.isnan(after.heights[5, 6]) and before.level == 0.0
    with pytest.raises(ValueError):
        after.heights[0, 0] = 1.0


@pytest.mark.parametrize("cell", [(-1, 0, 0.0), (0, 480, 0.0), (0, 0, math.inf), (0, 0, 1e6)])
def test_edits_outside_the_map_or_of_infinite_height_are_refused(
    cell: tuple[int, int, float],
) -> None:
    with pytest.raises(GroundError):
        ground("flat").edited([cell])


# files


def hills(shape: tuple[int, int] = (40, 60)) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(1).uniform(-0.1, 0.1, shape)


def test_an_array_is_the_ground_cell_by_cell(tmp_path: Path) -> None:
    heights = hills()
    np.save(tmp_path / "h.npy", heights)
    made = from_file(tmp_path / "h.npy", cell=0.05)
    assert made.cell == 0.05 and np.array_equal(made.heights, heights)
    assert made.origin == pytest.approx((-1.5, -1.0))
    assert (
        made.height_at(-1.49, -0.99) == heights[0, 0]
        and made.height_at(1.49, -0.99) == heights[0, 59]
    )


@pytest.mark.parametrize("dtype", ["f2", "f4", ">f8", "i2", "u1"])
def test_arrays_of_any_kind_of_number_load(tmp_path: Path, dtype: str) -> None:
    np.save(tmp_path / "h.npy", np.asfortranarray(np.ones((4, 5))).astype(dtype))
    assert from_file(tmp_path / "h.npy").level == 1.0


def test_smooth_files_are_resampled_to_25_millimetres(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.outer(np.ones(30), np.arange(30) * 0.01))
    made = from_file(tmp_path / "h.npy", cell=0.1, smooth=True)
    assert made.cell == pytest.approx(0.025) and made.heights.shape == (120, 120)
    assert np.diff(made.heights[5, 2:-2]) == pytest.approx(0.0025)


@pytest.mark.parametrize("mask", [np.savez, np.savez_compressed])
def test_a_runs_own_terrain_loads_with_its_cell_and_origin(tmp_path: Path, mask: Any) -> None:
    made = ground("holes")
    forbidden = np.isnan(made.heights)
    mask(
        tmp_path / "terrain.npz",
        heights=made.heights.astype(np.float32),
        cell=made.cell,
        origin=made.origin,
        forbidden=forbidden,
        believed_heights=made.heights.astype(np.float32),
        believed_forbidden=forbidden,
    )
    again = from_file(tmp_path / "terrain.npz", nan="hole")
    assert again.cell == made.cell and again.origin == made.origin
    np.testing.assert_array_equal(again.heights, made.heights)
    with pytest.raises(GroundError, match=r"cell \[0, \d+\] is NaN"):
        from_file(tmp_path / "terrain.npz")


@pytest.mark.parametrize(("kind", "white"), [(np.uint8, 255), (np.uint16, 65535)])
def test_grey_pictures_are_heights_up_to_white(tmp_path: Path, kind: Any, white: int) -> None:
    levels = np.zeros((20, 30), dtype=kind)
    levels[3, 7] = white
    Image.fromarray(levels).save(tmp_path / "h.png")
    made = from_file(tmp_path / "h.png", cell=0.1, scale=0.25)
    assert made.heights[20 - 1 - 3, 7] == 0.25 and np.count_nonzero(made.heights) == 1  # north up


@given(
    heights=arrays.arrays(
        np.float64,
        arrays.array_shapes(min_dims=0, max_dims=3, max_side=5),
        elements=st.floats(width=64),
    )
)
@settings(max_examples=80, deadline=None)
def test_an_array_either_is_ground_or_is_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, heights: Any
) -> None:
    path = tmp_path_factory.mktemp("h") / "h.npy"
    np.save(path, heights)
    try:
        made = from_file(path, nan="hole", origin=[-0.1, -0.1])
    except GroundError as refusal:
        assert "\n" not in str(refusal)
    else:
        assert min(heights.shape) >= 2 and heights.ndim == 2
        assert not np.isinf(made.heights).any() and np.nanmax(abs(made.heights)) <= 100.0


@pytest.mark.parametrize(
    ("heights", "says"),
    [
        (np.zeros((1, 1)), "at least 2 x 2"),
        (np.zeros(9), "at least 2 x 2"),
        (np.zeros((2, 2, 2)), "must be"),
        (np.zeros((0, 4)), "must be"),
        (np.zeros((6001, 6000), dtype=np.int8), "at most 36000000 cells"),
        (np.array([[0.0, 0.0], [np.inf, 0.0]]), r"cell \[1, 0\] is infinite"),
        (np.array([[0.0, np.nan], [0.0, 0.0]]), r"cell \[0, 1\] is NaN"),
        (np.array([[0.0, 250.0], [0.0, 0.0]]), r"cell \[0, 1\] is more than 100 m"),
        (np.array([["a", "b"], ["c", "d"]]), "numbers wanted"),
        (np.zeros((3, 3), dtype=complex), "numbers wanted"),
        (np.zeros((3, 3), dtype=bool), "numbers wanted"),
    ],
)
def test_arrays_that_are_no_ground_are_refused_with_the_cell(
    tmp_path: Path, heights: Any, says: str
) -> None:
    np.save(tmp_path / "h.npy", heights)
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / "h.npy")


def test_infinite_heights_are_refused_even_where_nan_is_a_hole(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.array([[0.0, -np.inf], [np.nan, 0.0]]))
    with pytest.raises(GroundError, match=r"\[0, 1\] is infinite"):
        from_file(tmp_path / "h.npy", nan="hole")


class Canary:
    """Unpickling this would show."""

    sang = False

    def __reduce__(self) -> Any:
        return setattr, (Canary, "sang", True)


@pytest.mark.parametrize("save", ["npy", "npz"])
def test_pickles_are_not_opened(tmp_path: Path, save: str) -> None:
    evil = np.array([[Canary(), 1], [2, 3]], dtype=object)
    path = tmp_path / f"h.{save}"
    np.save(path, evil, allow_pickle=True) if save == "npy" else np.savez(path, heights=evil)
    with pytest.raises(GroundError, match="numbers wanted"):
        from_file(path)
    path.write_bytes(__import__("pickle").dumps(Canary()))
    with pytest.raises(GroundError):
        from_file(path)
    assert not Canary.sang


def test_a_header_that_promises_more_than_the_file_holds_is_refused_before_reading(
    tmp_path: Path,
) -> None:
    whole = io.BytesIO()
    np.save(whole, np.zeros((500, 500)))
    (tmp_path / "h.npy").write_bytes(whole.getvalue()[:1000])
    with pytest.raises(GroundError, match="ends before"):
        from_file(tmp_path / "h.npy")


def test_a_zip_bomb_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "h.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("heights.npy", bytes(300_000_000))
    assert path.stat().st_size < 400_000
    with pytest.raises(GroundError, match="unpacks to 300000000 bytes"):
        from_file(path)


@pytest.mark.parametrize(
    ("members", "says"),
    [
        ({"other": np.zeros(3)}, "no 'heights' in it, only other"),
        ({"heights": np.zeros((3, 3)), "cell": -7.0}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "cell": np.nan}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "cell": [0.1, 0.2]}, "cell must be"),
        ({"heights": np.zeros((3, 3)), "origin": [0.0, np.inf]}, "origin must be"),
        ({"heights": np.zeros((3, 3)), **{f"m{i}": 0 for i in range(20)}}, "members"),
    ],
)
def test_archives_that_are_no_ground_are_refused(
    tmp_path: Path, members: dict[str, Any], says: str
) -> None:
    np.savez(tmp_path / "h.npz", **members)
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / "h.npz")


def test_coloured_pictures_are_refused_with_the_pixel(tmp_path: Path) -> None:
    picture = Image.new("RGB", (8, 8))
    picture.putpixel((5, 2), (255, 0, 0))
    picture.save(tmp_path / "h.png")
    with pytest.raises(GroundError, match=r"coloured: pixel \[2, 5\] is red 1.000, green 0.000"):
        from_file(tmp_path / "h.png")


def test_a_picture_too_large_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    whole = io.BytesIO()
    Image.new("L", (6001, 6000)).save(whole, "PNG")
    (tmp_path / "h.png").write_bytes(whole.getvalue()[:60])  # the header alone
    with pytest.raises(GroundError, match="6001 x 6000 cells"):
        from_file(tmp_path / "h.png")


@pytest.mark.parametrize("suffix", ["npy", "npz", "png"])
@given(junk=st.binary(max_size=300))
@settings(max_examples=25, deadline=None)
def test_junk_is_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, junk: bytes
) -> None:
    head = {"npy": b"\x93NUMPY\x01\x00", "npz": b"PK\x03\x04", "png": b"\x89PNG\r\n\x1a\n"}[suffix]
    path = tmp_path_factory.mktemp("junk") / f"h.{suffix}"
    for content in (junk, head + junk):
        path.write_bytes(content)
        with pytest.raises(GroundError) as refusal:
            from_file(path)
        assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("suffix", ["npy", "npz", "png"])
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_flipped_bytes_never_raise_anything_else(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("flip") / f"h.{suffix}"
    heights = np.zeros((6, 6), dtype=np.uint8)
    if suffix == "png":
        Image.fromarray(heights).save(path)
    else:
        np.save(path, heights) if suffix == "npy" else np.savez_compressed(
            path, heights=heights, cell=0.05, origin=[-0.15, -0.15]
        )
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(
        bytes(
            content[: data.draw(st.integers(0, len(content)))]
            if data.draw(st.booleans())
            else content
        )
    )
    try:
        from_file(path)
    except GroundError as refusal:
        assert "\n" not in str(refusal)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("none.npy", "does not exist"),
        ("none.doc", r"must end in one of: \.asc, \.csv, \.npy, \.npz, \.obj"),
    ],
)
def test_missing_and_unknown_files_are_refused_in_words(
    tmp_path: Path, name: str, says: str
) -> None:
    with pytest.raises(GroundError, match=says):
        from_file(tmp_path / name)


def test_a_start_outside_the_file_is_refused_in_words(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.zeros((4, 4)))
    with pytest.raises(GroundError, match="outside the map"):
        from_file(tmp_path / "h.npy", origin=[5.0, 5.0])


def test_kinds_say_their_own_parameters() -> None:
    assert (
        Stairs(kind="stairs").count == 3
        and Poles(kind="poles").radius == 0.05
        and Dem(kind="dem").relief == 2000.0
    )
