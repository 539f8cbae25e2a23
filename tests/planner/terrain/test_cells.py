"""Cells around a place, and which of them may be stepped on."""

import math

import numpy as np
import pytest

from walking_console.planner.terrain.cells import (
    FootholdMap,
    cells_across,
    cells_around,
    disc_of,
    foothold_map,
    one_of_each_block,
    outward,
    span_of,
)
from walking_console.planner.terrain.map import TerrainMap


def test_off_the_map_nothing_is_allowed():
    cells = FootholdMap(b"\x00" * 4, 2, 2, 0.1, 0.0, 0.0, lambda x, y: True)
    assert cells.allows(0.05, 0.15)
    assert not cells.allows(-0.01, 0.05)
    assert not cells.allows(0.05, 0.2) and not cells.allows(1e9, 0.0)


def test_it_allows_what_the_map_allows():
    rng = np.random.default_rng(1)
    forbidden = rng.random((30, 40)) < 0.4
    terrain = TerrainMap(np.zeros((30, 40)), forbidden, 0.05, (-1.0, -0.5))
    cells = foothold_map(terrain)
    for x, y in rng.uniform(-1.2, 1.2, (300, 2)).tolist():
        assert cells.allows(x, y) == terrain.allows(x, y)


def test_a_span_is_of_the_cells_whose_centres_lie_in_it_cut_to_the_map():
    assert span_of(0.12, 0.31, 0.0, 0.1, 10) == (1, 2), "centres at 0.15 and 0.25"
    assert span_of(-5.0, 0.15, 0.0, 0.1, 10) == (0, 1)
    assert span_of(0.95, 9.0, 0.0, 0.1, 10) == (9, 9)


@pytest.mark.parametrize("first", [1, -1])
def test_outward_comes_to_every_cell_once_from_the_middle_on(first):
    found = outward(2, 8, first)
    assert sorted(found) == list(range(8)) and found[:3] == (2, 2 + first, 2 - first)
    away = [abs(k - 2) for k in found]
    assert away == sorted(away)
    assert outward(10, 3, 1) == (2, 1, 0) and outward(-2, 3, 1) == (0, 1, 2)
    assert outward(5, 0, 1) == ()


def test_a_disc_has_every_cell_within_its_radius_the_nearest_first():
    cells = disc_of(0.1, 0.35)
    assert cells[0] == (0, 0, 0.0)
    away = [distance for _, _, distance in cells]
    assert away == sorted(away) and away[-1] <= 0.35
    around = [(c, r) for c in range(-4, 5) for r in range(-4, 5)]
    assert {(c, r) for c, r, _ in cells} == {p for p in around if math.hypot(*p) * 0.1 <= 0.35}


def half_free() -> FootholdMap:
    forbidden = np.random.default_rng(3).random((40, 40)) < 0.5
    return foothold_map(TerrainMap(np.zeros((40, 40)), forbidden, 0.05, (-1.0, -1.0)))


@pytest.mark.parametrize("course", [(1.0, 0.2), (-1.0, 0.4), (0.1, 1.0), (-0.3, -1.0)])
def test_rows_across_a_course_have_every_free_cell_of_the_area_once(course):
    cells, area = half_free(), (-0.4, 0.6, -0.5, 0.3)
    found = list(cells_across(cells, area, (0.1, 0.0), course))
    centres = [(x, y) for x, y, free in cells_across(cells, area, (0.1, 0.0), course, every=True)]
    assert len(set(centres)) == len(centres) == 20 * 16
    assert all(free and cells.allows(x, y) for x, y, free in found)
    assert len(found) == sum(cells.allows(x, y) for x, y in centres)
    along = 0 if abs(course[0]) >= abs(course[1]) else 1
    rows = [round(centre[along], 6) for centre in centres]
    changes = sum(a != b for a, b in zip(rows, rows[1:], strict=False))
    assert changes == len(set(rows)) - 1, "a row is not finished before the next"


@pytest.mark.parametrize("course", [(1.0, 0.2), (-1.0, 0.4), (0.1, 1.0), (-0.3, -1.0)])
@pytest.mark.parametrize("seed", range(6))
def test_half_planes_leave_out_cells_outside_of_them_and_change_no_order(course, seed):
    rng = np.random.default_rng(seed)
    cells, area = half_free(), (-0.4, 0.6, -0.5, 0.3)
    planes = [tuple(plane) for plane in rng.uniform(-1.0, 1.0, (3, 3)) * (1.0, 1.0, 0.3)]
    planes.append((0.0, 1.0, 0.35) if seed % 2 else (1.0, 0.0, 0.25))
    all_of_them = cells_across(cells, area, (0.1, 0.0), course, every=True)
    wanted = [at for at in all_of_them if all(a * at[0] + b * at[1] + c >= 0 for a, b, c in planes)]
    found = list(cells_across(cells, area, (0.1, 0.0), course, True, planes))
    assert [at for at in found if at in wanted] == wanted
    assert len(wanted) <= len(found) < 20 * 16
    outside = [at for at in found if at not in wanted]  # of a plane along the rows, looked at later
    along = abs(course[0]) >= abs(course[1])
    sloping = [(a, b, c) for a, b, c in planes if (b if along else a) != 0.0]
    assert all(a * x + b * y + c >= -1e-6 for x, y, _ in outside for a, b, c in sloping)


def test_of_each_block_the_first_free_cell_that_is_wanted_is_given():
    cells = half_free()

    def right(x: float, y: float) -> tuple[float, float] | None:
        return (x, y) if x > 0.0 else None

    found = list(one_of_each_block(cells, (-0.6, 0.6, -0.6, 0.6), 0.2, right))
    assert found and all(x > 0.0 and cells.allows(x, y) for x, y in found)
    blocks = [(math.floor((x + 1.0) / 0.2), math.floor((y + 1.0) / 0.2)) for x, y in found]
    assert len(set(blocks)) == len(blocks)


def test_cells_around_a_place_come_from_the_nearest_on():
    cells = half_free()
    free = list(cells_around(cells, (0.31, -0.12), 0.3))
    every = list(cells_around(cells, (0.31, -0.12), 0.3, every=True))
    away = [distance for _, _, distance in every]
    assert away == sorted(away) and away[-1] <= 0.3
    assert free == [cell for cell in every if cells.allows(*cell[:2])] and len(free) < len(every)
