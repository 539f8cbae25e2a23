"""How a map is brought up to date one part at a time."""

import numpy as np
import pytest

from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.mapping import ElevationMapper
from walking_console.planner.terrain.working_map import BLOCK, Prior

MACHINE = load_machine("titan3")
CELL = 0.025
SHAPE = (110, 150)
FEET = [(0.4, 0.4, 0.15), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.03), (0.4, -0.4, 0.0)]


def blank(unknown: str = "flat") -> ElevationMapper:
    return ElevationMapper(SHAPE, CELL, (-1.0, -1.0), MACHINE, unknown=unknown)


def broken(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    heights = 0.02 * rng.standard_normal(SHAPE)
    heights[30:45, 60:90] += 0.5
    heights[80:86, 20:30] = np.nan
    return heights


def some_cells(seed: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    return np.nonzero(np.random.default_rng(seed).random(SHAPE) < share)


@pytest.mark.parametrize("unknown", ["flat", "forbidden"])
def test_a_map_worked_on_block_by_block_is_the_map_worked_out_at_once(unknown: str) -> None:
    at_once, in_parts = blank(unknown), blank(unknown)
    heights = broken(1)
    blocks = -(-SHAPE[0] // BLOCK) * -(-SHAPE[1] // BLOCK)
    for mapper in (at_once, in_parts):
        mapper.set_prior(FEET)
    for seed, share in enumerate((0.1, 0.3, 0.02)):
        rows, columns = some_cells(seed, share)
        for mapper in (at_once, in_parts):
            mapper.see(rows, columns, heights[rows, columns])
            mapper.touch(FEET[:2])
        whole = at_once.publish()
        for _ in range(5 * blocks):  # before each block the arrays that were given away
            in_parts.work_on()
            part_by_part = in_parts.publish_worked()
        assert in_parts.publish() is part_by_part, "something was left to do"
        for name in ("heights", "forbidden", "known", "crests"):
            one, other = getattr(whole, name), getattr(part_by_part, name)
            assert np.array_equal(one, other, equal_nan=name == "heights"), name
        assert whole.highest == part_by_part.highest and whole.is_level is part_by_part.is_level


def test_a_map_that_is_out_does_not_change_while_the_next_is_worked_on() -> None:
    mapper = blank()
    rows, columns = some_cells(3, 0.5)
    first = mapper.observe(rows, columns, np.zeros(rows.size))
    before = [array.copy() for array in (first.heights, first.forbidden, first.known, first.crests)]
    mapper.see(rows, columns, broken(4)[rows, columns])
    second = mapper.publish()
    assert second is not first and second.forbidden.any()
    after = (first.heights, first.forbidden, first.known, first.crests)
    assert all(np.array_equal(old, new) for old, new in zip(before, after, strict=True))


def test_what_has_been_seen_comes_into_the_map_a_block_at_a_time() -> None:
    mapper = blank()
    rows, columns = (index.ravel() for index in np.indices(SHAPE))
    mapper.see(rows, columns, np.zeros(rows.size))
    for _ in range(5):  # an array that was given away, or a block
        known = int(mapper.publish_worked().known.sum())
        mapper.work_on()
        grown = int(mapper.publish_worked().known.sum())
        assert 0 <= grown - known <= BLOCK * BLOCK
    assert mapper.publish().known.all()


def test_every_block_has_its_turn_though_the_first_is_seen_anew_all_the_time() -> None:
    mapper = blank()
    rows, columns = (index.ravel() for index in np.indices(SHAPE))
    mapper.see(rows, columns, np.zeros(rows.size))
    for tick in range(30):
        mapper.see(np.array([1]), np.array([1]), np.array([0.1 * (tick % 2)]))
        mapper.work_on()
    assert mapper.publish_worked().known.all()


def test_ground_is_supposed_to_be_as_high_as_the_nearest_foot_stands() -> None:
    terrain = TerrainMap(np.zeros(SHAPE), np.zeros(SHAPE, dtype=bool), CELL, (-1.0, -1.0))
    window = slice(10, 90), slice(20, 100)
    heights = Prior(0.0, tuple(FEET)).heights(window, terrain)
    for row, column in ((0, 0), (79, 79), (40, 3), (13, 60)):
        x, y = terrain.centre(10 + row, 20 + column)
        nearest = min(FEET, key=lambda foot: (foot[0] - x) ** 2 + (foot[1] - y) ** 2)
        assert heights[row, column] == nearest[2]
    assert Prior(0.7).heights(window, terrain) == 0.7
