"""F1, F2 and F3 (H §9.3) over whole walks, as the log has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from walking_console.planner.control.handshake import FlagChange
from walking_console.planner.types import Mode

from .telling import walked

ALL_SIX = (1 << len(FlagChange)) - 1


def has(walk, change: FlagChange) -> np.ndarray:
    return (walk.log["handshake"] >> change & 1).astype(bool)


@pytest.fixture(scope="module")
def by_touch(tmp_path_factory):
    folder: Path = tmp_path_factory.mktemp("handshake")
    return walked(folder, "fig17-up", "sensing=none", "end={time=60.0}", "expect={}")


def test_every_flag_is_what_its_changes_have_made_of_it(by_touch) -> None:
    flags = by_touch.log["flags"]
    for k, (sets, resets) in enumerate(
        [
            (FlagChange.CALLED, FlagChange.COMPLETED),
            (FlagChange.NOTIFIED, FlagChange.TAKEN),
            (FlagChange.WANTED, FlagChange.SUPPLIED),
        ]
    ):
        before = np.concatenate([[False], flags[:-1, k]])
        risen = flags[:, k] & ~before
        fallen = ~flags[:, k] & before
        assert (has(by_touch, sets) | ~risen).all() and (has(by_touch, resets) | ~fallen).all()
        assert risen.any()


def test_at_a_step_switching_point_level_c_receives_and_calls_for_the_next(by_touch) -> None:
    step, flags = by_touch.log["step"], by_touch.log["flags"]
    walks = by_touch.log["mode"][:-1] != Mode.STAND
    begun = np.flatnonzero((np.diff(step) > 0) & walks) + 1
    assert begun.size > 5
    for change in (FlagChange.TAKEN, FlagChange.SUPPLIED, FlagChange.CALLED):
        assert has(by_touch, change)[begun].all()
    assert not flags[begun, 2].any()  # it waits for nothing while it walks


def test_a_hit_calls_and_wants_at_once_until_the_encounter_is_over(by_touch) -> None:
    emergent = by_touch.log["mode"] == Mode.EMERGENT
    begins = np.flatnonzero(np.diff(emergent.astype(int)) > 0) + 1
    flags = by_touch.log["flags"]
    called = [k for k in begins if flags[k].tolist() == [True, False, True]]
    assert called and by_touch.summary["emergent"]["hit"] <= len(called)
    for k in called:
        assert has(by_touch, FlagChange.CALLED)[k] and has(by_touch, FlagChange.WANTED)[k]


def test_a_landing_that_is_searched_for_passes_through_all_six_changes(tmp_path: Path) -> None:
    walk = walked(
        tmp_path, "pit", "sensing=none", "terrain.depth=1.5", "end={time=60.0}", "expect={}"
    )
    searched = (walk.log["handshake"] == ALL_SIX) & (walk.log["mode"] == Mode.EMERGENT)
    assert searched.any()
