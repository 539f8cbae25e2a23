"""The record of a run on a wide map: what it depended on, no more, and enough to walk it again."""

import json
from pathlib import Path

import numpy as np
import pytest

from walking_console.sim.requests import Edit
from walking_console.sim.runs.reader import open_run
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.runner import summarise
from walking_console.sim.runs.wide_record import wide_ground
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.terrain.ground import GroundError

TERRAIN = "terrain={kind='holes', map_size=[400.0, 400.0]}"  # 64 million cells of 0.05 m


def recorded(out: Path, sensing: str) -> Simulation:
    simulation = Simulation(load_scenario("holes", (TERRAIN, f"sensing={sensing}", "expect={}")))
    recorder = Recorder(simulation)
    simulation.drive(0.0, 0.12)
    for tick in range(1500):
        if tick == 400:
            row, column = simulation.perception.ground.corner
            near = tuple((row + 180, column + c) for c in range(190, 200))
            simulation.request(Edit("clear", (*near, (7999, 0))))
        simulation.step()
        recorder.note()
    out.mkdir()
    recorder.write(out, summarise(simulation, recorder, "interrupted", ""))
    return simulation


@pytest.mark.parametrize("sensing", ["known", "eye", "none"])
def test_a_run_on_a_wide_map_walks_again_to_the_last_bit(tmp_path: Path, sensing: str) -> None:
    simulation = recorded(tmp_path / "run", sensing)
    run = open_run(tmp_path / "run")
    assert run.replay()
    perception = simulation.perception
    ground = perception.ground
    terrain, believed = run.terrain, run.believed
    assert ground.heights.size < terrain.heights.size < 400_000
    row, column = terrain.cell_at(*ground.centre(0, 0))
    here = slice(row, row + ground.rows), slice(column, column + ground.columns)
    np.testing.assert_array_equal(terrain.heights[here], ground.heights)
    assert np.array_equal(terrain.forbidden[here], perception.true_forbidden)
    np.testing.assert_allclose(believed.heights[here], perception.belief.heights, atol=1e-6)
    assert np.array_equal(believed.forbidden[here], perception.belief.forbidden)
    if sensing == "known":
        assert np.array_equal(np.isnan(terrain.heights), terrain.forbidden)


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ([0, 0, 9000, 9000], "cannot lie as place says"),
        ([7999, 0, 8000, 8000], "cannot lie as place says"),
        ([-1, 0, 8000, 8000], "cannot lie as place says"),
        ([0, 0], "place must be 4 whole numbers"),
    ],
)
def test_a_place_that_cannot_be_is_refused(place: list[int], says: str) -> None:
    arrays = {
        "place": np.array(place),
        "whole_origin": np.array([0.0, 0.0]),
        "cell": np.array(0.1),
    }
    with pytest.raises(GroundError, match=says):
        wide_ground(arrays, np.zeros((40, 40)), "flat", False)


def test_what_says_where_it_lies_is_plain_numbers(tmp_path: Path) -> None:
    recorded(tmp_path / "run", "known")
    with np.load(tmp_path / "run" / "terrain.npz") as arrays:
        assert arrays["place"].tolist()[2:] == [8000, 8000]
        assert arrays["heights"].shape == arrays["forbidden"].shape
        assert arrays["start_heights"].shape == arrays["heights"].shape
    assert json.loads((tmp_path / "run" / "run.json").read_text())["start_ground"]["final"]
