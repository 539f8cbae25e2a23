"""The body's way between switching points: through every gate, smooth, and no farther than it
must.
"""

import math

import numpy as np
import pytest

from walking_console.planner.motion.body_path import (
    OFFSET_MAX,
    Key,
    Knot,
    at,
    largest_acceleration,
    lateral_bounds,
    monotone_rates,
    through_gates,
)
from walking_console.planner.stability import polygon_margin, support_polygon

LEFT = (0.0, 1.0)
TRIANGLE = support_polygon([(0.4, -0.02), (-0.4, -0.02), (0.0, 0.5)])


def test_within_the_bounds_the_margin_is_kept_and_beyond_them_it_is_not():
    low, high = lateral_bounds(TRIANGLE, 0.0, 0.0, LEFT, 0.02)
    assert high == OFFSET_MAX
    assert polygon_margin(TRIANGLE, 0.0, low) == pytest.approx(0.02)
    assert polygon_margin(TRIANGLE, 0.0, low - 0.001) < 0.02


def test_where_no_offset_keeps_the_margin_the_best_one_is_given():
    sliver = support_polygon([(1.0, -0.01), (-1.0, -0.01), (0.0, 0.02)])
    low, high = lateral_bounds(sliver, 0.0, 0.0, LEFT, 0.03)
    assert low == high
    best = max(polygon_margin(sliver, 0.0, y) for y in np.linspace(-OFFSET_MAX, OFFSET_MAX, 2001))
    assert polygon_margin(sliver, 0.0, low) == pytest.approx(best, abs=1e-4)


def test_without_a_polygon_there_is_no_offset():
    assert lateral_bounds((), 0.0, 0.0, LEFT, 0.02) == (0.0, 0.0)


def test_a_way_that_needs_no_offset_has_none():
    keys = [Key(0.5, -0.01, 0.02), Key(1.5, -0.03, 0.0), Key(2.0, 0.0, 0.05)]
    assert all(knot.value == knot.rate == 0.0 for knot in through_gates(Knot(0.0, 0.0, 0.0), keys))


@pytest.mark.parametrize("seed", range(50))
def test_the_way_passes_every_gate_and_stays_between_its_neighbours(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 1.5, 6))
    middles = rng.uniform(-0.04, 0.04, 6)
    widths = rng.uniform(0.0, 0.02, 6)
    keys = [
        Key(float(t), float(m - w), float(m + w))
        for t, m, w in zip(times, middles, widths, strict=True)
    ]
    knots = through_gates(Knot(0.0, float(rng.uniform(-0.03, 0.03)), 0.0), keys)
    for key, knot in zip(keys, knots[1:], strict=True):
        assert key.low <= knot.value <= key.high
    for a, b in zip(knots, knots[1:], strict=False):
        inside = [at(knots, float(t)).value for t in np.linspace(a.time, b.time, 21)]
        assert min(inside) >= min(a.value, b.value) - 1e-12
        assert max(inside) <= max(a.value, b.value) + 1e-12


def test_value_and_rate_are_continuous_and_the_rate_is_the_derivative():
    knots = through_gates(
        Knot(0.0, 0.01, 0.02), [Key(0.7, 0.02, 0.05), Key(1.4, -0.05, -0.03), Key(2.5, 0.0, 0.01)]
    )
    for t in np.linspace(0.001, 2.49, 500):
        step = 1e-6
        slope = (at(knots, t + step).value - at(knots, t - step).value) / (2 * step)
        assert slope == pytest.approx(at(knots, t).rate, abs=1e-6)
    assert at(knots, 0.0) == knots[0]
    assert at(knots, 9.0) == Knot(9.0, knots[-1].value, 0.0)


def test_the_largest_acceleration_is_that_of_the_curve():
    knots = through_gates(Knot(0.0, 0.0, 0.0), [Key(0.8, 0.03, 0.05), Key(2.0, -0.05, -0.03)])
    times = np.linspace(0.0, 2.0, 20001)
    rates = np.array([at(knots, t).rate for t in times])
    measured = np.abs(np.diff(rates) / np.diff(times)).max()
    assert largest_acceleration(knots) == pytest.approx(measured, rel=0.01)


def test_rates_turn_to_nothing_where_the_values_turn_round():
    assert monotone_rates([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], 0.0, 0.0)[1] == 0.0
    even = monotone_rates([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], 1.0, 1.0)
    assert even[1] == pytest.approx(1.0)
    assert math.isclose(even[0], 1.0)
