"""A run directory to look into."""

import numpy as np
import pytest

from walking_console import load_scenario, open_run, run_scenario
from walking_console.sim.runs.reader import Run

SETTINGS = ("sensing=eye", "end={time=6.0}", "expect={}")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    out = tmp_path_factory.mktemp("runs") / "holes"
    run_scenario(load_scenario("holes", SETTINGS), str(out))
    return open_run(str(out))


def test_what_was_walked_is_read_back(run: Run) -> None:
    assert run.summary["ticks"] == len(run.ticks["t"]) == 300
    assert run.machine.name == "titan3"
    assert len(run.steps) == run.summary["steps"] > 0
    assert run.ticks["feet"].shape == (300, 4, 3)


def test_the_ground_and_what_was_believed_of_it_are_maps_of_one_shape(run: Run) -> None:
    assert run.terrain.heights.shape == run.believed.heights.shape
    assert run.terrain.foot_radius == run.machine.foot_radius
    assert np.isnan(run.terrain.heights).any()
    first = run.ticks["body"][0]
    assert run.terrain.height_at(first[0], first[1]) == 0.0


def test_it_walks_again_to_the_same_state(run: Run) -> None:
    assert run.replay()


def test_a_folder_without_a_run_is_refused_at_once(tmp_path) -> None:
    with pytest.raises(ValueError, match=r"has no run\.json"):
        open_run(tmp_path)
