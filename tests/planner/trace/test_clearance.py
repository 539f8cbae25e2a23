"""What stands too tall on the way: for feet in the air and for the torso."""

import numpy as np

from tests.planner.trace.rollout import gait_of
from walking_console.planner.motion.swing import CLEARANCE
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.clearance import Clearance
from walking_console.planner.trace.footholds import Foothold
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.samples import SampleGrid

HEXAPOD = load_machine("hexapod")
HEIGHT = gait_of(HEXAPOD).height
COUNT = 100  # samples of 2 cm along x


def clearance(height: float, x: tuple[float, float], y: tuple[float, float]) -> Clearance:
    """A straight way along x over level ground with one box on it."""
    heights = np.zeros((160, 160))
    columns = slice(round((x[0] + 4) / 0.05), round((x[1] + 4) / 0.05))
    rows = slice(round((y[0] + 4) / 0.05), round((y[1] + 4) / 0.05))
    heights[rows, columns] = height
    terrain = TerrainMap(heights, heights > 0.0, 0.05, (-4.0, -4.0), HEXAPOD.foot_radius)
    along = np.arange(COUNT) * 0.02
    lane = Lane(along[None], np.zeros((1, COUNT)), np.zeros(COUNT), np.full(COUNT, HEIGHT))
    return Clearance(lane, SampleGrid(1, COUNT), terrain, HEXAPOD)


def test_on_ground_lower_than_a_lift_nothing_is_tall() -> None:
    low = clearance(0.05, (0.5, 0.6), (0.6, 0.8))
    assert not low.has_tall
    assert not low.torso_grazes
    assert low.torso_room == low.samples.all


def test_a_post_beside_the_way_leaves_no_room_for_a_leg_in_the_air_that_would_meet_it() -> None:
    tall = clearance(0.8, (1.0, 1.1), (0.6, 0.7))
    assert tall.has_tall
    left = [leg for leg, spec in enumerate(HEXAPOD.legs) if spec.centre[1] > 0]
    for leg in left:
        room = tall.room(leg)
        for k in range(COUNT):
            x1, x2 = (0.02 * k + edge for edge in HEXAPOD.legs[leg].x)
            if x1 < 1.0 < 1.1 < x2:
                assert not room >> k & 1
    right = [leg for leg in range(6) if leg not in left]
    assert all(tall.room(leg) == tall.samples.all for leg in right)


def test_a_foot_is_not_carried_across_what_is_too_tall() -> None:
    tall = clearance(0.8, (1.0, 1.1), (0.6, 0.7))
    before, beyond = Foothold(0, 0.8, 0.65, 0.0, 90), Foothold(0, 1.3, 0.65, 0.0, 99)
    beside = Foothold(0, 0.8, 1.0, 0.0, 90)
    assert not tall.crosses(0, 1, (before, beyond), tall.samples.all)
    assert tall.crosses(0, 2, (before, beside), tall.samples.all)


def test_the_torso_grazes_a_block_on_its_way_and_only_there() -> None:
    block = clearance(HEIGHT, (1.5, 1.6), (-0.1, 0.1))
    assert block.torso_grazes
    half = HEXAPOD.torso[0] / 2
    for k in range(COUNT):
        x = 0.02 * k
        if x + half < 1.4:
            assert block.torso_room >> k & 1
        if x - half < 1.5 < x + half:
            assert not block.torso_room >> k & 1


def test_the_machine_is_taken_where_it_is() -> None:
    block = clearance(HEIGHT, (0.0, 0.1), (-0.1, 0.1))
    assert not block.torso_room & 1
    block.accept([0], 0)
    assert block.torso_room & 1
    assert block.room(0) & 1


def test_a_leg_has_room_where_its_rectangle_and_what_is_beside_it_meet_nothing_too_tall() -> None:
    """Turning and climbing among many posts, in three rows; held against the whole rectangle of
    every sample.
    """
    rng = np.random.default_rng(3)
    heights = np.where(rng.random((160, 160)) < 0.004, rng.random((160, 160)), 0.0)
    heights[rng.random((160, 160)) < 0.1] = np.nan
    terrain = TerrainMap(heights, heights != 0.0, 0.05, (-4.0, -4.0), HEXAPOD.foot_radius)
    along = np.linspace(-1.0, 1.0, COUNT)
    rows = np.array([[0.0], [0.05], [-0.05]])
    climb = HEIGHT + 0.2 * along
    lane = Lane(along + 0.0 * rows, 0.3 * along**2 + rows, 2.0 * along, climb)
    tall = Clearance(lane, SampleGrid(3, COUNT), terrain, HEXAPOD)
    some = 0
    for leg, spec in enumerate(HEXAPOD.legs):
        room = tall.samples.row_of(tall.room(leg), 0)
        some += room.bit_count()
        for k in range(COUNT):
            c, d = np.cos(lane.yaw[k]), np.sin(lane.yaw[k])
            corners = [(bx, by) for bx in spec.x for by in spec.y]
            px = [lane.x[0, k] + c * bx - d * by for bx, by in corners]
            py = [lane.y[0, k] + d * bx + c * by for bx, by in corners]
            aside = 0.05 + HEXAPOD.foot_radius
            top = terrain.crest_in(
                min(px) - aside, max(px) + aside, min(py) - aside, max(py) + aside
            )
            if room >> k & 1:
                assert top <= climb[k] + spec.z[1] + HEXAPOD.overreach[2] - CLEARANCE
    assert 0 < some < 6 * COUNT
