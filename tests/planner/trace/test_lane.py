"""The body's poses along a window of a trace: through where it is, back to the trace, beside it."""

import math

import numpy as np
import pytest

from tests.planner.trace.rollout import gait_of
from walking_console.planner.geometry.path_kinds import STEP
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.lane import (
    ASIDE_TURNING,
    JOIN,
    ROWS,
    TraceWindow,
    body_heights,
    lane_along,
)
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.types import Stance

HEXAPOD = load_machine("hexapod")
GAIT = gait_of(HEXAPOD)
LEVEL = TerrainMap(np.zeros((80, 80)), np.zeros((80, 80), bool), 0.1, (-4.0, -4.0))
NOW = 50
STRETCH = TraceWindow(20, 220, NOW)


def lane(kind: str, beside: float = 0.0, yaw: float = 0.0, aside: float = 0.0):
    """A lane of a body ``beside`` m to the left of its sample and turned by ``yaw``."""
    trace = trace_for({"kind": kind}, HEXAPOD)
    x, y, heading = (float(values[NOW]) for values in (trace.x, trace.y, trace.yaw))
    x -= beside * math.sin(heading)
    y += beside * math.cos(heading)
    feet = tuple((*leg.centre, 0.0) for leg in HEXAPOD.legs)
    stance = Stance((x, y, GAIT.height, heading + yaw), feet)
    return trace, stance, lane_along(trace, STRETCH, stance, LEVEL, HEXAPOD, GAIT, aside)


@pytest.mark.parametrize("yaw", [0.0, 0.2, 2 * math.pi])
def test_the_lane_goes_through_the_body_and_is_back_on_the_trace_after_join(yaw: float) -> None:
    trace, stance, found = lane("sine", 0.05, yaw)
    at = NOW - STRETCH.first
    assert (found.x[0, at], found.y[0, at]) == pytest.approx(stance.body[:2])
    assert found.yaw[at] == pytest.approx(stance.body[3])
    beyond = at + math.ceil(JOIN * HEXAPOD.torso[0] / STEP) + 1
    assert found.x[0, beyond:] == pytest.approx(trace.x[STRETCH.first + beyond : STRETCH.last + 1])
    turns = (found.yaw[beyond:] - trace.yaw[STRETCH.first + beyond : STRETCH.last + 1]) / math.tau
    assert turns == pytest.approx(np.full(turns.shape, round(yaw / math.tau)), abs=1e-9)


def test_on_level_ground_the_body_keeps_its_height() -> None:
    assert lane("line")[2].z == pytest.approx(np.full(201, GAIT.height))


def test_rows_lie_beside_the_trace_by_parts_of_the_width() -> None:
    _, _, found = lane("circle", aside=0.1)
    assert found.x.shape == (len(ROWS), 201)
    away = np.hypot(found.x - found.x[0], found.y - found.y[0])
    for row, share in enumerate(ROWS):
        assert away[row] == pytest.approx(np.full(201, abs(share) * 0.1))


def test_on_the_spot_rows_lie_nearer() -> None:
    _, _, found = lane("turn", aside=0.1)
    away = np.hypot(found.x - found.x[0], found.y - found.y[0])
    assert away.max() == pytest.approx(ASIDE_TURNING)


def test_a_body_beside_its_trace_has_no_row_farther_out_than_the_width() -> None:
    _, stance, found = lane("line", beside=0.08, aside=0.1)
    trace_y = 0.0
    assert np.abs(found.y[1:] - trace_y).max() <= 0.1 + 1e-9


def test_the_body_is_h_above_the_mean_of_the_ground_and_between_it_over_holes() -> None:
    heights = np.zeros((80, 80))
    heights[:, 40:] = 0.2
    heights[:, 10:30] = np.nan
    terrain = TerrainMap(heights, np.isnan(heights), 0.1, (-4.0, -4.0))
    x = np.linspace(-3.5, 3.0, 200)
    z = body_heights(x, np.zeros_like(x), terrain, HEXAPOD, GAIT)
    assert np.isfinite(z).all()
    assert z[0] == pytest.approx(GAIT.height)
    assert z[-1] == pytest.approx(GAIT.height + 0.2)
    assert z.min() >= GAIT.height - 1e-12 and z.max() <= GAIT.height + 0.2 + 1e-12


def test_over_a_bottomless_map_it_keeps_its_height_over_nothing() -> None:
    nothing = np.full((8, 8), np.nan)
    nothing[0, 0] = 0.0
    nothing[0, 1] = 1.0
    terrain = TerrainMap(nothing, np.isnan(nothing), 0.1, (50.0, 50.0))
    x = np.full(5, 50.75)
    z = body_heights(x, np.full(5, 50.75), terrain, load_machine("phantomx"), GAIT)
    assert z == pytest.approx(np.full(5, GAIT.height))
