"""How far any way can lead: never less than a way does lead, and nothing but time comes of it."""

from collections.abc import Generator

import numpy as np
import pytest

from tests.planner.trace.rollout import field_of, gait_of
from tests.planner.trace.test_state_search import HEXAPOD, field_beside, field_on_trace
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace import state_search
from walking_console.planner.trace.clearance import Clearance
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.prediction import Prediction, predicting
from walking_console.planner.trace.state_search import search
from walking_console.planner.trace.upper_bound import farthest_possible
from walking_console.planner.types import Command

ASIDE = (0.0, 0.05, -0.05, 0.1, -0.1)


def nothing_known(*_: object) -> Generator[None, None, None]:
    """Stands in for ``farthest_possible`` where a search is to go on to its end."""
    return
    yield


@pytest.mark.parametrize("seed", (101, 104, 106, 107, 110, 111))
def test_no_way_leads_beyond_it(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fields of which the whole can be searched; asked about every place a search may be stuck."""
    monkeypatch.setattr(state_search, "farthest_possible", nothing_known)
    terrain = field_of(0.01, seed, HEXAPOD, (-1.0, 1.8, -1.0, 1.4))
    reachable, start = field_on_trace(terrain, 15, step=0.05)
    most = run_to_completion(search(reachable, start, 15, 1_000_000)).farthest
    for stuck in range(most + 1):
        bound = run_to_completion(farthest_possible(reachable, 0, stuck))
        assert bound is None or bound >= most


@pytest.mark.parametrize(("seed", "asked"), ((0, 195), (9, 140)))
def test_where_the_trace_cannot_be_walked_it_says_so(seed: int, asked: int) -> None:
    reachable, _ = field_on_trace(field_of(0.02, seed, HEXAPOD), 320)
    assert run_to_completion(farthest_possible(reachable, 0, asked)) == asked


def test_beside_the_trace_rows_are_joined() -> None:
    """Each row alone is barred somewhere before the goal; going from row to row it is reached."""
    terrain = field_of(0.015, 2, HEXAPOD)
    reachable, start = field_beside(terrain, ASIDE)
    path = run_to_completion(search(reachable, start, 320, 40_000))
    assert path.complete
    for stuck in range(0, 320, 20):
        assert run_to_completion(farthest_possible(reachable, 0, stuck)) is None
    for aside in ASIDE:
        alone, start = field_beside(terrain, (aside,))
        assert run_to_completion(search(alone, start, 320, 40_000)).farthest < 320


def test_where_the_torso_is_barred_the_search_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wall across the trace: the way up to it is the same as of a search that looks on."""
    thin = field_of(0.06, 1, HEXAPOD)
    heights = np.zeros(thin.forbidden.shape)
    heights[:, 100:102] = 0.8  # from x = 2.0 m on
    walled = TerrainMap(heights, thin.forbidden | (heights > 0.0), thin.cell, thin.origin)
    reachable, start = field_on_trace(walled, 320)
    barred = reachable.clearance.leads_to(0)
    assert 0 < barred < 200
    early = run_to_completion(search(reachable, start, 320, 2000))
    vain = run_to_completion(search(reachable, start, 320, 2000, whole_only=True))
    assert (vain.looked, vain.most, vain.complete) == (1, barred, False)
    monkeypatch.setattr(Clearance, "leads_to", lambda *_: 320)
    monkeypatch.setattr(state_search, "farthest_possible", nothing_known)
    late = run_to_completion(search(reachable, start, 320, 2000))
    assert early.states == late.states
    assert early.farthest == late.farthest == barred
    assert early.exhausted
    assert early.looked < 200 < late.looked


@pytest.mark.parametrize("seed", (0, 9, 11))
def test_what_is_predicted_is_the_same(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Searches that end early where they lead nowhere, and searches that go on all the same."""
    early = predicted(seed)
    monkeypatch.setattr(state_search, "farthest_possible", nothing_known)
    late = predicted(seed)
    assert early.looked < late.looked
    assert early.moves == late.moves
    assert (early.reached, early.complete) == (late.reached, late.complete)


def predicted(seed: int) -> Prediction:
    """Ahead on a field of which the exact trace cannot be walked."""
    terrain = field_of(0.02, seed, HEXAPOD)
    gait = gait_of(HEXAPOD)
    stance = square_stance(HEXAPOD, gait, Placement((0.0, 0.0, 0.0), terrain.height_at))
    trace = trace_for({"kind": "sine"}, HEXAPOD)
    job = predicting(
        stance, Command(speed=0.1), terrain, HEXAPOD, gait, trace=trace, limit=1500, limit_wide=1500
    )
    return run_to_completion(job)
