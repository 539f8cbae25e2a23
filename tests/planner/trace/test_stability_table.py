"""Which sets of standing feet are stable on which samples, against the margin of the polygon."""

import itertools

import numpy as np
import pytest

from walking_console.planner.stability import polygon_margin, support_polygon
from walking_console.planner.trace.footholds import AIR, Foothold
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.samples import SampleGrid
from walking_console.planner.trace.stability_table import MARGIN, StabilityTable

COUNT = 60
NEAR = 1e-8


def lane() -> Lane:
    along = np.linspace(-0.5, 0.9, COUNT)
    return Lane(
        np.stack([along, along]),
        np.stack([0.3 * np.sin(3 * along), 0.3 * np.sin(3 * along) + 0.05]),
        np.zeros(COUNT),
        np.full(COUNT, 0.5),
    )


def table(seed: int) -> StabilityTable:
    rng = np.random.default_rng(seed)
    holds = [Foothold(leg, *rng.uniform(-0.8, 0.8, 2).tolist(), 0.0, 0) for leg in range(6)]
    return StabilityTable(lane(), SampleGrid(2, COUNT), holds)


@pytest.mark.parametrize("seed", range(6))
def test_feet_are_stable_where_the_margin_is_kept_inside_their_polygon(seed: int) -> None:
    stability = table(seed)
    poses = lane()
    for lifted in itertools.combinations(range(6), 2):
        feet = tuple(AIR if leg in lifted else leg for leg in range(6))
        mask = stability.stable(feet)
        standing = [stability.footholds[f] for f in feet if f >= 0]
        polygon = support_polygon([(hold.x, hold.y) for hold in standing])
        for row, k in itertools.product((0, 1), range(0, COUNT, 5)):
            margin = polygon_margin(polygon, poses.x[row, k], poses.y[row, k])
            if abs(margin - MARGIN) > NEAR:
                assert bool(mask >> (row * (COUNT + 1) + k) & 1) is bool(margin > MARGIN)


def test_two_feet_are_stable_nowhere() -> None:
    assert table(0).stable((0, 1, AIR, AIR, AIR, AIR)) == 0


def square(x: float) -> StabilityTable:
    """Four feet round the origin, the front ones at ``x``; the body goes along x from 0."""
    holds = [
        Foothold(0, x, 0.5, 0.0, 0),
        Foothold(1, -0.5, 0.5, 0.0, 0),
        Foothold(2, -0.5, -0.5, 0.0, 0),
        Foothold(3, x, -0.5, 0.0, 0),
    ]
    along = -0.01 * np.arange(COUNT)
    poses = Lane(along[None], np.zeros((1, COUNT)), np.zeros(COUNT), np.full(COUNT, 0.5))
    return StabilityTable(poses, SampleGrid(1, COUNT), holds)


def test_where_it_stands_less_stable_than_the_margin_it_may_become_more_so_never_less() -> None:
    near = square(0.004)
    feet = (0, 1, 2, 3)
    assert not near.stable(feet) & 1
    near = square(0.004)
    assert near.accept(feet, 0)
    assert near.stable(feet) & 3 == 3
    assert square(-0.0005).accept(feet, 0), "a margin of −1 mm counts as none"


def test_what_does_not_stand_is_not_accepted() -> None:
    assert not square(-0.01).accept((0, 1, 2, 3), 0)
    assert not square(0.5).accept((0, 1, AIR, AIR), 0)
