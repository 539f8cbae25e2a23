"""The states a trace walk goes through: K's order, the search behind it, and what no search can
do.
"""

import numpy as np
import pytest

from tests.planner.trace.exhaustive import farthest_reachable
from tests.planner.trace.rollout import field_of, gait_of
from walking_console.planner.geometry.path_kinds import STEP, SinePath, sampled
from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import Machine, load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.lane import Lane
from walking_console.planner.trace.reachability import Reachability
from walking_console.planner.trace.state_search import search
from walking_console.planner.trace.state_sequence import SupportState, end_of

HEXAPOD = load_machine("hexapod")


def field_on_trace(
    terrain: TerrainMap, samples: int, machine: Machine = HEXAPOD, step: float = STEP
) -> tuple[Reachability, SupportState]:
    course = sampled(SinePath(), machine.yaw_length, (0.0, 0.0, 0.0), step)
    part = slice(0, samples + 1)
    lane = Lane(
        course.x[None, part],
        course.y[None, part],
        course.yaw[part],
        np.full(samples + 1, gait_of(machine).height),
    )
    reachable = Reachability(lane, terrain, machine).find_all()
    return reachable, SupportState(
        tuple(
            reachable.foothold_of(leg, (*description.centre, 0.0), 0)
            for leg, description in enumerate(machine.legs)
        ),
        0,
    )


def test_successive_states_overlap() -> None:
    """K: the necessary and sufficient condition for a stable motion."""
    reachable, start = field_on_trace(field_of(0.04, 3, HEXAPOD), 320)
    path = run_to_completion(search(reachable, start, 320, 40_000))
    assert path.complete
    for before, after in zip(path.states, path.states[1:], strict=False):
        assert reachable.valid(before.feet) & reachable.valid(after.feet)
        assert sum(f >= 0 for f in after.feet) >= 3
        assert end_of(reachable, after) >= after.at


@pytest.mark.parametrize("seed", (101, 104, 106, 107, 110, 111))
def test_where_an_exhaustive_search_finds_a_way_so_does_the_planner_and_nowhere_else(
    seed: int,
) -> None:
    """Thin ground, 0.75 m of trace in coarse samples: some of these fields can be crossed, some
    cannot.
    """
    samples, step = 15, 0.05
    terrain = field_of(0.01, seed, HEXAPOD, (-1.0, 1.8, -1.0, 1.4))
    reachable, start = field_on_trace(terrain, samples, step=step)
    course = sampled(SinePath(), HEXAPOD.yaw_length, (0.0, 0.0, 0.0), step)
    short = SampledPath(
        step,
        course.x[: samples + 1].copy(),
        course.y[: samples + 1].copy(),
        course.yaw[: samples + 1].copy(),
    )
    most = farthest_reachable(HEXAPOD, terrain, short, tuple(leg.centre for leg in HEXAPOD.legs))
    path = run_to_completion(search(reachable, start, samples, 1_000_000))
    assert path.farthest == most
    assert path.complete == (most == samples)


def test_the_answer_does_not_depend_on_how_the_search_is_sliced() -> None:
    paths = []
    for slices in (1, 3):
        reachable, start = field_on_trace(field_of(0.03, 5, HEXAPOD), 320)
        thinking = search(reachable, start, 320, 2000)
        while True:
            try:
                for _ in range(slices):
                    next(thinking)
            except StopIteration as done:
                paths.append(done.value)
                break
    assert paths[0] == paths[1]


def field_beside(
    terrain: TerrainMap, aside: tuple[float, ...]
) -> tuple[Reachability, SupportState]:
    """The footholds with rows so far beside the trace, and the stance at its beginning."""
    course = sampled(SinePath(), HEXAPOD.yaw_length, (0.0, 0.0, 0.0))
    x, y, yaw = (array[:321] for array in (course.x, course.y, course.yaw))
    tx, ty = np.gradient(x), np.gradient(y)
    size = np.hypot(tx, ty)
    lane = Lane(
        np.stack([x - off * ty / size for off in aside]),
        np.stack([y + off * tx / size for off in aside]),
        yaw,
        np.full(321, 0.5),
    )
    reachable = Reachability(lane, terrain, HEXAPOD).find_all()
    feet = tuple(
        reachable.foothold_of(leg, (*description.centre, 0.0), 0)
        for leg, description in enumerate(HEXAPOD.legs)
    )
    return reachable, SupportState(feet, 0)


def reached_beside(terrain: TerrainMap, aside: tuple[float, ...]) -> int:
    """The sample of 320 the search reaches with rows so far beside the trace."""
    path = run_to_completion(search(*field_beside(terrain, aside), 320, 40_000))
    assert path.exhausted or path.complete
    return path.farthest


def test_beside_the_trace_a_field_can_be_crossed_that_the_trace_alone_cannot() -> None:
    terrain = field_of(0.015, 2, HEXAPOD)
    assert reached_beside(terrain, (0.0,)) == 99, "on the trace there is no way"
    assert reached_beside(terrain, (0.0, 0.05, -0.05, 0.1, -0.1)) == 320
