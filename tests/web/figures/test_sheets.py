"""Sheets: which views they are made of, and which steps they choose to show."""

import math
from dataclasses import replace

import pytest

from walking_console.web.figures.run_data import RecordedWalk
from walking_console.web.figures.sheets import (
    busiest,
    compared,
    crossing_steps,
    search_domains,
    standard_walk,
    walk_note,
)


def test_the_note_says_how_the_walk_was_commanded_and_how_far_it_went(walk: RecordedWalk) -> None:
    swayed = f"α = 28°, β = 0.8; {len(walk.steps)} steps, {walk.summary['distance']:.2f} m"
    assert walk_note(walk) == swayed
    printed = replace(walk, gait=replace(walk.gait, sways=False))
    assert walk_note(printed) == f"{swayed}; body straight as printed"


def test_the_busiest_steps_are_those_that_land_farthest_from_the_start_of_their_search(
    walk: RecordedWalk,
) -> None:
    still = [{**step, "search_start": step["landing"]} for step in walk.steps]
    moved = {"search_start": [9.0, 9.0, 0.0]}
    steps = [*still[:5], {**still[5], **moved}, {**still[6], **moved}, *still[7:]]
    first = busiest(replace(walk, steps=steps))
    assert first <= 6 and first + 3 >= 7


def test_steps_that_cross_a_river_are_shown_with_those_around_them(walk: RecordedWalk) -> None:
    angle = math.radians(28.0)
    bank = 0.8
    shown = crossing_steps(walk, bank, angle, count=6)
    assert shown == sorted(set(shown)) and len(shown) <= 6

    def along(point: tuple[float, float, float]) -> float:
        return point[0] * math.cos(angle) + point[1] * math.sin(angle)

    for k in range(1, len(walk.steps) + 1):
        leg = walk.swing(k)
        over = along(walk.stance(k).feet[leg]) > bank >= along(walk.stance(k - 1).feet[leg])
        assert not over or k in shown


def test_a_walk_that_never_crosses_shows_its_first_steps(walk: RecordedWalk) -> None:
    assert crossing_steps(walk, 100.0, 0.0, count=4) == [1, 2, 3, 4]


def test_roughness_is_compared_where_there_is_any(walk: RecordedWalk) -> None:
    level = replace(walk, summary={**walk.summary, "roughness_ratio": None})
    assert compared(level) == "level ground: nothing to compare"
    rough = {"roughness": 0.002, "roughness_average_rule": 0.008, "roughness_ratio": 0.25}
    line = compared(replace(walk, summary={**walk.summary, **rough}))
    assert line.endswith("2.00 mm, average-height rule 8.00 mm: 0.25 of it")


@pytest.mark.parametrize(("maker", "views"), [(standard_walk, 6), (search_domains, 5)])
def test_a_sheet_has_its_title_and_its_views(walk: RecordedWalk, maker, views: int) -> None:
    sheet = maker("A title", {"walk": walk})
    assert sheet.texts[0].get_text() == "A title"
    assert len(sheet.axes) == views
