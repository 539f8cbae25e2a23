"""What the eye sees of the ground, and what the ground hides from it."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

from walking_console.planner.robot.model import load_machine
from walking_console.sim.range_sensor import EyeSettings, RangeSensor
from walking_console.sim.terrain.ground import Ground

MACHINE = load_machine("titan3")
CLEAR = {"noise": 0.0, "dropout": 0.0}
STANDING = (0.0, 0.0, 0.85, 0.0, 0.0, 0.0)
CELL = 0.05


def level(size=16.0, cell=CELL):
    count = round(size / cell)
    return np.zeros((count, count))


def ground_of(heights, cell=CELL):
    return Ground(heights, cell, (-heights.shape[1] * cell / 2, -heights.shape[0] * cell / 2))


def at(v, cell=CELL, size=16.0):
    return round((v + size / 2) / cell)


def eye_over(heights, seed=1, cell=CELL, **settings):
    return RangeSensor(
        MACHINE,
        ground_of(heights, cell),
        np.random.default_rng(seed),
        EyeSettings(**{**CLEAR, **settings}),
    )


def seen(eye, looks=12, body=STANDING, direction=0.0):
    """Height of every cell after some looks, −inf where nothing was seen."""
    found = np.full(eye.ground.heights.shape, -np.inf)
    for _ in range(looks):
        scan = eye.scan(body, direction)
        found[scan.rows, scan.columns] = scan.heights
    return found


def places(eye, found):
    rows, columns = np.nonzero(found != -np.inf)
    x, y = eye.ground.centre(rows, columns)
    return np.asarray(x), np.asarray(y)


def test_level_ground_ahead_is_seen_as_it_is_and_nowhere_else():
    eye = eye_over(level())
    found = seen(eye)
    x, y = places(eye, found)
    assert np.all(found[found != -np.inf] == 0.0)
    assert x.min() > 0.5 and np.hypot(x - 0.2, y).max() <= 4.0
    assert np.degrees(np.abs(np.arctan2(y, x - 0.2))).max() < 63.0
    for px in np.arange(1.0, 2.0, 0.05):
        assert found[at(0.01), at(px + 0.001)] == 0.0


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("direction", [0.0, math.pi / 2])
def test_the_eye_turns_to_the_course(yaw, direction):
    eye = eye_over(level())
    x, y = places(eye, seen(eye, body=(0.0, 0.0, 0.85, 0.0, 0.0, yaw), direction=direction))
    assert math.remainder(
        math.atan2(y.mean(), x.mean()) - yaw - direction, math.tau
    ) == pytest.approx(0.0, abs=0.25)


def test_a_fixed_eye_looks_along_the_torso():
    eye = eye_over(level(), pans=False)
    x, _ = places(eye, seen(eye, direction=math.pi))
    assert x.min() > 0.5


def test_a_wall_hides_what_is_behind_it():
    heights = level()
    heights[:, at(2.0) : at(2.2)] = 1.6  # taller than the eye
    found = seen(eye_over(heights))
    assert np.all(found[:, at(2.2) :] == -np.inf)
    assert np.all(found[at(0.0), at(1.2) : at(1.9)] == 0.0)


def test_of_a_wall_taller_than_the_eye_only_a_side_is_seen():
    heights = level()
    heights[:, at(2.0) : at(2.2)] = 3.0
    eye = eye_over(heights)
    scan = eye.scan(STANDING)
    wall = scan.columns == at(2.0)
    assert wall.any() and scan.sides[wall].all()
    assert np.all(scan.heights[wall] < 3.0)


def test_a_block_is_seen_from_above_and_throws_a_shadow():
    heights = level()
    heights[at(-0.5) : at(0.5), at(2.0) : at(2.3)] = 0.4
    found = seen(eye_over(heights))
    assert np.all(found[at(-0.4) : at(0.4), at(2.05) : at(2.25)] == 0.4)
    # eye 1.35 m up: the shadow is 0.9 m long
    assert np.all(found[at(-0.2) : at(0.2), at(2.3) : at(2.7)] == -np.inf)


def test_a_hole_is_looked_into_from_near_and_not_from_far():
    heights = level()
    heights[at(-0.05) : at(0.1), at(1.2) : at(1.35)] = np.nan
    heights[at(-0.05) : at(0.1), at(3.6) : at(3.65)] = np.nan
    found = seen(eye_over(heights), looks=30)
    assert np.isnan(found[at(0.0), at(1.2) : at(1.35)]).sum() >= 2
    assert np.all(found[at(-0.05) : at(0.1), at(3.6)] == -np.inf)


def test_ground_below_an_edge_is_hidden_until_the_eye_comes_near():
    heights = level()
    heights[:, at(2.0) :] = -1.0
    eye = eye_over(heights)
    far = seen(eye)
    near = seen(eye, body=(1.2, 0.0, 0.85, 0.0, 0.0, 0.0))
    assert np.all(far[at(0.0), at(2.0) : at(2.8)] == -np.inf)
    assert np.any(near[at(0.0), at(2.0) : at(2.8)] == -1.0)


def test_what_is_seen_is_true_on_any_ground():
    rng = np.random.default_rng(8)
    heights = level()
    y, x = np.indices(heights.shape) * CELL
    heights += 0.15 * np.sin(3 * x) * np.cos(2 * y)
    heights[rng.random(heights.shape) < 0.1] = np.nan
    eye = eye_over(heights)
    for _ in range(5):
        scan = eye.scan(STANDING, float(rng.uniform(-3, 3)))
        truth = eye.ground.heights[scan.rows, scan.columns]
        assert np.array_equal(np.isnan(scan.heights), np.isnan(truth))
        assert np.array_equal(scan.heights[~scan.sides], truth[~scan.sides], equal_nan=True)
        assert np.all(scan.heights[scan.sides] <= truth[scan.sides])
        assert np.unique(scan.rows * 10_000 + scan.columns).size == scan.rows.size


def test_noise_and_dropouts_are_as_set_and_repeatable():
    one, other, third = (
        eye_over(level(), seed=seed, noise=0.01, dropout=0.5) for seed in (3, 3, 4)
    )
    a, b, c = one.scan(STANDING), other.scan(STANDING), third.scan(STANDING)
    assert all(np.array_equal(p, q) for p, q in zip(a, b, strict=True))
    assert not np.array_equal(a.heights[:100], c.heights[:100])
    assert a.heights.std() == pytest.approx(0.01, rel=0.1)
    assert a.rows.size == pytest.approx(0.5 * eye_over(level()).scan(STANDING).rows.size, rel=0.1)


def test_a_nose_down_torso_sees_nearer():
    eye = eye_over(level())
    flat, down = (
        seen(eye, body=(0.0, 0.0, 0.85, 0.0, pitch, 0.0))[at(0.0)] for pitch in (0.0, 0.2)
    )
    assert np.argmax(down == 0.0) < np.argmax(flat == 0.0) - 3


def test_the_edge_of_the_map_is_not_a_hole():
    eye = eye_over(level(size=4.0))
    scan = eye.scan(STANDING)
    assert scan.rows.size > 0 and not np.isnan(scan.heights).any()


@pytest.mark.parametrize(
    "wrong",
    [
        {"range": math.inf},
        {"every": 0},
        {"resolution_deg": [0.0, 1.0]},
        {"colour": True},
        {"dropout": 2.0},
    ],
)
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ValidationError):
        EyeSettings(**wrong)


def test_a_scan_spread_over_ticks_finds_what_one_at_once_finds():
    rng = np.random.default_rng(4)
    heights = level() + 0.1 * rng.standard_normal(level().shape)
    heights[at(1.0) : at(1.4), at(1.0) : at(1.4)] = np.nan
    settings = {"noise": 0.003, "dropout": 0.02}
    whole, spread = (eye_over(heights, seed=7, **settings) for _ in range(2))
    for k in range(3):
        body = (0.3 * k, 0.0, 0.85, 0.02, 0.01, 0.4 * k)
        job = spread.scanning(body, 0.2)
        pauses = 0
        while True:
            try:
                next(job)
            except StopIteration as done:
                found = done.value
                break
            pauses += 1
        assert pauses == spread.pauses > 3
        for one, other in zip(whole.scan(body, 0.2), found, strict=True):
            assert np.array_equal(one, other, equal_nan=True)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_scan_meets_what_rays_followed_one_by_one_meet(seed):
    rng = np.random.default_rng(seed)
    heights = np.cumsum(0.02 * rng.standard_normal((120, 120)), axis=0)
    heights[rng.random(heights.shape) < 0.05] = np.nan
    eye = eye_over(heights, seed)
    body = (0.7, -0.4, 0.85 + float(np.nanmax(heights)), 0.02, -0.03, 0.4)
    turned = eye_over(heights, seed).rng.uniform(-0.5, 0.5)
    bearings = eye.bearings + turned * math.radians(eye.settings.resolution_deg[0])
    wanted = {}
    for bearing, lowest in zip(bearings, eye._lowest(body, bearings), strict=True):
        _follow(eye, eye.place(body), bearing + body[5], lowest, wanted)
    scan = eye.scan(body)
    found = zip(scan.rows.tolist(), scan.columns.tolist(), strict=True)
    assert dict(zip(found, zip(scan.heights, scan.sides, strict=True), strict=True)) == {
        cell: (pytest.approx(height, nan_ok=True), side) for cell, (height, side) in wanted.items()
    }


def _follow(eye, place, bearing, lowest, found):
    """One profile of the ground, ray after ray from the lowest: what stops each."""
    x, y, z = place
    resolution = math.radians(eye.settings.resolution_deg[1])
    rays = math.floor(eye.settings.height_deg / eye.settings.resolution_deg[1]) + 1
    ray, rim = 0, -math.inf
    for d in eye.distances:
        cell = eye.ground.cell_at(x + math.cos(bearing) * d, y + math.sin(bearing) * d)
        height = math.nan if cell is None else eye.ground.heights[cell]
        came_in = None
        while ray < rays and lowest + ray * resolution <= math.atan2(height - z, d):
            came_in = z + (d - eye.distances[0]) * math.tan(lowest + ray * resolution)
            ray += 1
        if came_in is not None and math.hypot(d, height - z) <= eye.settings.range:
            top = came_in >= height - 1e-6
            before, side = found.get(cell, (-math.inf, True))
            if top:
                found[cell] = height, False
            elif side:
                found[cell] = max(before, came_in), True
        if not math.isnan(height):
            rim = height
            continue
        flying = z + d * math.tan(lowest + ray * resolution)
        seen = math.hypot(d, flying - z) <= eye.settings.range
        if cell is not None and ray < rays and flying < rim - 0.02 and seen:
            found[cell] = math.nan, False
