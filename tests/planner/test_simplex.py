"""The linear programme: known answers, and none where there is none."""

import pytest

from walking_console.planner.simplex import least_cost


def test_a_blend_by_hand():
    # x + y = 10, x - s = 4 (x at least 4): cheapest is as little x as allowed
    assert least_cost([2.0, 1.0, 0.0], [[1, 1, 0], [1, 0, -1]], [10, 4]) == pytest.approx((4, 6, 0))


def test_equations_that_contradict_each_other_have_no_answer():
    assert least_cost([1.0], [[1.0], [1.0]], [1.0, 2.0]) is None
    assert least_cost([1.0], [[1.0]], [-1.0]) is None


def test_a_cost_without_a_least_has_no_answer():
    assert least_cost([-1.0, 0.0], [[1.0, -1.0]], [0.0]) is None


def test_an_equation_that_says_nothing_new_does_no_harm():
    assert least_cost([1.0, 3.0], [[1, 1], [2, 2]], [2, 4]) == pytest.approx((2.0, 0.0))


def test_a_programme_that_makes_careless_rules_run_in_circles_ends():
    # Beale's example
    rows = [
        [0.25, -60.0, -0.04, 9.0, 1.0, 0.0, 0.0],
        [0.5, -90.0, -0.02, 3.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    ]
    best = least_cost([-0.75, 150.0, -0.02, 6.0, 0.0, 0.0, 0.0], rows, [0.0, 0.0, 1.0])
    assert best is not None
    assert best[0] == pytest.approx(0.04) and best[2] == pytest.approx(1.0)


def test_an_equation_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="equation 1 must have 2 terms, got 1"):
        least_cost([1.0, 1.0], [[1.0]], [1.0])
