"""Solids: closed, facing outwards, of the size asked for."""

from collections import Counter

import numpy as np
import pytest

from walking_console.web.scene.solids import ball, circle, disc, loft, octagon, revolution


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Signed volume: positive when the faces look outwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6)


@pytest.mark.parametrize("axis", [0, 2])
def test_a_loft_is_closed_and_looks_outwards(axis: int) -> None:
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    vertices, faces = loft([(0.0, square), (3.0, square)], axis)
    sides = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = Counter(map(tuple, np.sort(sides, axis=1).tolist()))
    assert set(edges.values()) == {2}
    assert volume(vertices, faces) == pytest.approx(12.0)


def test_an_octagon_is_a_rectangle_less_its_corners() -> None:
    outline = octagon(2.0, 1.0, 0.5, lift=0.25)
    x, y = outline.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert area == pytest.approx(8.0 - 4 * 0.125)
    assert outline.mean(axis=0) == pytest.approx((0.0, 0.25))


def test_a_cut_deeper_than_the_rectangle_stops_at_its_middle() -> None:
    assert np.abs(octagon(0.2, 0.1, 5.0)).max(axis=0) == pytest.approx((0.2, 0.1))


def test_a_circle_runs_counter_clockwise_from_ahead() -> None:
    points = circle(2.0, 8)
    assert points[0] == pytest.approx((2.0, 0.0))
    assert points[2] == pytest.approx((0.0, 2.0))


def test_the_normals_of_a_cone_lean_with_its_side() -> None:
    _, _, normals = revolution([(0.0, 1.0), (0.5, 0.5), (1.0, 0.0)], 12)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    assert normals[:, 2] == pytest.approx(np.sqrt(0.5))


def test_a_ball_is_as_large_as_its_radius_and_looks_outwards() -> None:
    vertices, faces, normals = ball(0.5, 64)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(0.5)
    assert vertices == pytest.approx(0.5 * normals)
    assert volume(vertices, faces) == pytest.approx(4 / 3 * np.pi * 0.125, rel=0.01)


def test_a_disc_is_level_looks_up_and_leaves_its_middle_open() -> None:
    vertices, faces = disc(0.5, 1.0, 100)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    up = np.cross(b - a, c - a)[:, 2] / 2
    assert np.all(up >= 0.0)
    assert up.sum() == pytest.approx(np.pi * 0.75, rel=0.01)
    assert np.all(vertices[:, 2] == 0.0)
