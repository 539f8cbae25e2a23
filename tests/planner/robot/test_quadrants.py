"""The box four legs have in common."""

import pytest

from walking_console.planner.robot.quadrants import SIDES, mirrored_part, ordered


def test_the_mirrored_part_lies_in_every_box():
    boxes = [(sx * 0.2, sx * 0.7, sy * 0.3, sy * 0.6) for sx, sy in SIDES]
    boxes = [(min(a, b) + 0.05, max(a, b) + 0.05, min(c, d), max(c, d)) for a, b, c, d in boxes]
    part = mirrored_part(boxes)
    assert part == pytest.approx((0.25, 0.65, 0.3, 0.6))
    assert mirrored_part([(0.2, 0.3, 0.1, 0.2), *boxes[1:3], (0.5, 0.6, -0.2, -0.1)]) is None


@pytest.mark.parametrize("pair", [(1.0, 2.0), (2.0, 1.0)])
def test_two_numbers_are_put_in_order(pair):
    assert ordered(*pair) == (1.0, 2.0)
