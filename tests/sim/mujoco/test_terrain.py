"""The ground as boxes: exact, and nothing where there is nothing."""

import math

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco-core")

from walking_console.planner.robot.model import load_machine
from walking_console.sim.mujoco.library import mujoco
from walking_console.sim.mujoco.model import build
from walking_console.sim.mujoco.near_ground import NearGround, lay, shares
from walking_console.sim.mujoco.settings import Physics
from walking_console.sim.mujoco.terrain import merged
from walking_console.sim.scenario_files import list_scenarios, load_scenario
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import prepare


def built(heights):
    """A ground and its model, with every box in its pool."""
    ground = Ground(np.array(heights, dtype=float), 0.1, (-1.0, 2.0))
    near = NearGround(ground, 0.004, 0.5)
    count = len(near.tops)
    made = build(load_machine("titan3"), ground, Physics(), shares(count))
    if not ground.relief:
        lay(made.model, made.pool, near, range(count))
    return ground, made.model


def height_by_ray(model, x, y):
    data = mujoco.MjData(model)
    data.qpos[2] = 50.0
    mujoco.mj_forward(model, data)
    shape = np.array([-1], dtype=np.int32)
    far = mujoco.mj_ray(model, data, [x, y, 20.0], [0.0, 0.0, -1.0], None, 1, -1, shape, None)
    return math.nan if far < 0 else 20.0 - far


def merged_one_by_one(heights):
    """The boxes as one would draw them: a run of equal cells, as far down as it goes on."""
    rows, columns = heights.shape
    runs = set()
    for row in range(rows):
        ends = [
            0,
            *(c for c in range(1, columns) if heights[row, c] != heights[row, c - 1]),
            columns,
        ]
        for c0, c1 in zip(ends, ends[1:], strict=False):
            if not math.isnan(heights[row, c0]):
                runs.add((row, c0, c1, heights[row, c0]))
    boxes = []
    for row, *run in sorted(runs):
        if (row - 1, *run) not in runs:
            end = row
            while (end, *run) in runs:
                end += 1
            boxes.append((row, end, *run))
    return sorted(boxes)


@pytest.mark.parametrize("seed", range(5))
def test_boxes_are_runs_of_equal_cells_joined_downwards_in_order(seed):
    chance = np.random.default_rng(seed)
    heights = chance.choice([0.0, 0.1, np.nan], size=(20, 30), p=[0.6, 0.2, 0.2])
    assert list(zip(*merged(heights)[:5], strict=True)) == merged_one_by_one(heights)


def test_rectangles_cover_every_cell_once_and_no_hole():
    chance = np.random.default_rng(1)
    heights = chance.choice([0.0, 0.1, np.nan], size=(20, 30))
    covered = np.full(heights.shape, np.nan)
    boxes = merged(heights)
    for number, (r0, r1, c0, c1, height) in enumerate(zip(*boxes[:5], strict=True)):
        patch = covered[r0:r1, c0:c1]
        assert np.isnan(patch).all()
        patch[:] = height
        assert (boxes.number[r0:r1, c0:c1] == number).all()
    assert np.array_equal(covered, heights, equal_nan=True)
    assert np.array_equal(boxes.number < 0, np.isnan(heights))


def test_level_ground_is_one_box_and_no_ground_none():
    assert len(merged(np.zeros((50, 60))).height) == 1
    assert len(merged(np.full((50, 60), np.nan)).height) == 0


def test_boxes_stand_where_the_cells_are_and_a_hole_has_no_bottom():
    ground, model = built([[0.0, 0.2, 0.2], [math.nan, 0.2, 0.5], [0.0, 0.0, 0.5]])
    for row in range(3):
        for column in range(3):
            x, y = ground.centre(row, column)
            wanted = ground.height_at(x, y)
            got = height_by_ray(model, x, y)
            assert (math.isnan(got) and math.isnan(wanted)) or got == pytest.approx(wanted)


def test_every_shipped_ground_with_holes_is_made_of_boxes():
    """In a height field holes begin half a cell too early, and feet beside them slide in."""
    grounds = [prepare(load_scenario(name)).ground for name, _ in list_scenarios()]
    holed = [ground for ground in grounds if np.isnan(ground.heights).any()]
    assert len(holed) > 5
    assert not any(ground.relief for ground in holed)


def test_relief_is_a_height_field_that_is_what_everybody_takes_for_the_ground():
    ground, model = built(np.random.default_rng(1).uniform(0.0, 0.4, (9, 11)))
    assert model.nhfield == 1
    for x, y in np.random.default_rng(2).uniform((-0.94, 2.06), (0.04, 2.84), (300, 2)):
        assert height_by_ray(model, x, y) == pytest.approx(ground.height_at(x, y), abs=1e-6)


@pytest.mark.parametrize("rise", [0.4, 2e-4])
def test_a_height_field_filled_afterwards_is_the_one_that_is_handed_over(rise):
    heights = np.random.default_rng(3).uniform(-0.1, rise - 0.1, (40, 30))
    ground, model = built(heights)
    assert ground.relief
    spec = mujoco.MjSpec()
    lowest = heights.min()
    shares = (heights - lowest) / max(heights.max() - lowest, 1e-3)
    spec.add_hfield(
        name="same", nrow=40, ncol=30, size=[1.0, 1.0, 1.0, 0.5], userdata=shares.ravel()
    )
    handed_over = spec.compile()
    np.testing.assert_allclose(model.hfield_data, handed_over.hfield_data, atol=1e-7)
    assert model.hfield_data.min() == 0.0 and model.hfield_data.max() == 1.0
