"""What feet carried over a whole walk, by statics."""

import numpy as np
import pytest

from walking_console import load_machine
from walking_console.planner.stability import GRAVITY
from walking_console.planner.statics import planned_loads
from walking_console.sim.load_history import accelerations, loads_over, shares_over
from walking_console.sim.margins import true_centre

TITAN = load_machine("titan3")
WEIGHT = TITAN.mass * GRAVITY


def test_it_is_what_statics_says_row_by_row():
    rng = np.random.default_rng(3)
    feet = np.array([[0.5, 0.4, 0], [-0.5, 0.4, 0], [-0.5, -0.4, 0], [0.5, -0.4, 0]], float)
    body = np.zeros((40, 6))
    body[:, :2] = rng.uniform(-0.45, 0.45, (40, 2))
    body[:, 2] = TITAN.height
    shares = np.ones((40, 4))
    shares[10:20, 1] = rng.uniform(0.0, 1.0, 10)
    shares[20:, 2] = 0.0
    loads = loads_over(TITAN, body, np.repeat(feet[None], 40, axis=0), shares)
    for row in range(40):
        x, y, _ = true_centre(TITAN, body[row].tolist(), feet.tolist())
        wanted = planned_loads(WEIGHT, (x, y), feet.tolist(), shares[row].tolist()).newtons
        assert loads[row] == pytest.approx(wanted, abs=1e-6 * WEIGHT)
        assert loads[row].sum() == pytest.approx(WEIGHT)


def test_a_body_that_speeds_up_presses_where_its_zero_moment_point_is():
    feet = np.array([[0.5, 0.4, 0], [-0.5, 0.4, 0], [-0.5, -0.4, 0], [0.5, -0.4, 0]], float)
    body = np.zeros((30, 6))
    body[:, 2] = TITAN.height
    body[:, 0] = 0.1 * (np.arange(30) * 0.02) ** 2  # 0.2 m/s²
    changes = accelerations(body)
    assert changes[3:-3] == pytest.approx(np.tile([0.2, 0.0], (24, 1)), abs=1e-9)
    shares = np.ones((30, 4))
    loads = loads_over(TITAN, body, np.repeat(feet[None], 30, axis=0), shares, changes)
    x, _, z = true_centre(TITAN, body[10].tolist(), feet.tolist())
    pushed = float((loads[10] * feet[:, 0]).sum() / loads[10].sum())
    assert pushed == pytest.approx(x - 0.2 * z / GRAVITY)


def test_a_jump_of_its_speed_is_no_acceleration():
    body = np.zeros((30, 6))
    body[15:, 0] = 0.0016 * np.arange(15)  # from rest to 0.08 m/s
    assert accelerations(body) == pytest.approx(np.zeros((30, 2)), abs=1e-9)


def test_without_rows_there_are_no_loads():
    none = np.zeros((0, 6)), np.zeros((0, 4, 3)), np.zeros((0, 4))
    assert loads_over(TITAN, *none).shape == (0, 4)


def test_a_leg_takes_its_load_up_and_gives_it_away_in_time():
    support = np.ones((60, 2), bool)
    support[20:40, 0] = False
    shares = shares_over(support)
    assert (shares[:, 1] == 1.0).all() and (shares[20:40, 0] == 0.0).all()
    assert (np.diff(shares[5:20, 0]) <= 0.0).all() and (np.diff(shares[40:, 0]) >= 0.0).all()
    assert np.abs(np.diff(shares[:, 0])).max() < 0.3
