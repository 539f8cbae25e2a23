"""A run directory is enough to walk the run again, wherever it is taken."""

import json
import shutil
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from walking_console.sim.requests import Edit
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.replay import replay
from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.runner import run_scenario, summarise
from walking_console.sim.scenario import Scenario
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

TITAN = resources.files("walking_console.planner.robot") / "descriptions" / "titan3.toml"
SCENARIO = """
robot = "mine.toml"
terrain = {file = "maps/hills.npy", cell = 0.025}
drive = [{speed = 0.08, crab_angle_deg = 10.0}]
end = {time = 20.0}
"""


def of_files(folder: Path) -> Scenario:
    """A scenario with a robot file and a ground file of heights that no float32 holds."""
    (folder / "maps").mkdir(parents=True)
    rows, columns = np.indices((300, 300))
    hills = 0.02 * np.sin(columns / 30.0) * np.cos(rows / 30.0) / 3.0
    assert not np.array_equal(hills.astype(np.float32), hills)
    np.save(folder / "maps" / "hills.npy", hills)
    (folder / "mine.toml").write_text(TITAN.read_text("utf-8"), "utf-8")
    (folder / "mine-walks.toml").write_text(SCENARIO, "utf-8")
    return load_scenario(str(folder / "mine-walks.toml"))


@pytest.fixture(scope="module")
def moved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run walked on files that are gone, in a directory that was moved since."""
    folder = tmp_path_factory.mktemp("here")
    run_scenario(of_files(folder / "sources"), folder / "run")
    shutil.rmtree(folder / "sources")
    return Path(shutil.move(folder / "run", tmp_path_factory.mktemp("elsewhere") / "run"))


def test_a_run_replays_where_its_robot_and_its_ground_file_are_not(moved: Path) -> None:
    assert replay(moved)["equal"]


def test_nothing_in_it_names_a_place_on_the_machine_it_was_walked_on(moved: Path) -> None:
    text = (moved / "run.json").read_text("utf-8")
    assert "/here" not in text and "\\\\" not in text
    scenario = json.loads(text)["scenario"]
    assert scenario["robot"] == "mine.toml"
    assert scenario["terrain"]["file"] == "hills.npy"


def test_the_ground_is_kept_to_the_last_bit_beside_what_readers_take(moved: Path) -> None:
    with np.load(moved / "terrain.npz") as terrain:
        assert terrain["heights"].dtype == np.float32
        assert terrain["start_heights"].dtype == np.float64
        assert np.array_equal(terrain["start_heights"].astype(np.float32), terrain["heights"])


def test_ground_that_float32_holds_is_kept_once(tmp_path: Path) -> None:
    run_scenario(load_scenario("holes", ("end={time=1.0}", "expect={}")), tmp_path)
    with np.load(tmp_path / "terrain.npz") as terrain:
        assert "start_heights" not in terrain.files
    assert replay(tmp_path)["equal"]


def test_poles_and_steps_stand_where_they_stood(tmp_path: Path) -> None:
    settings = ("end={time=25.0}", "expect={}")
    for name in ("poles", "stairs-up"):
        run_scenario(load_scenario(name, settings), tmp_path / name)
        assert replay(tmp_path / name)["equal"]


def test_a_walk_over_ground_that_was_edited_begins_on_the_ground_of_before(tmp_path: Path) -> None:
    simulation = Simulation(load_scenario("flat"))
    recorder = Recorder(simulation)
    simulation.drive(speed=0.08)
    for tick in range(300):
        if tick == 100:
            simulation.request(Edit("raise", ((240, 260), (240, 261)), 0.013))
        simulation.step()
        recorder.note()
    recorder.write(tmp_path, summarise(simulation, recorder, "interrupted", "enough"))
    assert replay(tmp_path)["equal"]


def test_it_says_with_which_versions_it_was_walked(moved: Path) -> None:
    summary = json.loads((moved / "run.json").read_text("utf-8"))
    assert summary["plant"] == "kinematic"
    assert set(summary["versions"]) == {"python", "numpy", "pymunk"}
    assert summary["versions"]["numpy"] == np.__version__


def test_a_run_of_before_the_ground_was_kept_replays_while_its_files_are_there(
    tmp_path: Path,
) -> None:
    scenario = of_files(tmp_path / "sources")
    summary = run_scenario(scenario, tmp_path / "run")
    del summary["start_ground"], summary["versions"], summary["plant"]
    old = {**summary, "scenario": scenario.as_data()}
    (tmp_path / "run" / "run.json").write_text(json.dumps(old), "utf-8")
    assert replay(tmp_path / "run")["equal"]
    shutil.rmtree(tmp_path / "sources")
    with pytest.raises(RunError, match=r"hills\.npy"):
        replay(tmp_path / "run")


@pytest.mark.parametrize(
    ("name", "array", "words"),
    [
        ("start_heights", np.zeros((2, 2)), "shape"),
        ("start_heights", np.full((300, 300), np.inf), "within 100 m"),
        ("cell", np.array(0.0), "positive"),
        ("obstacles", np.zeros((2, 3)), "obstacles"),
    ],
)
def test_a_ground_that_is_none_is_refused_in_one_line(
    moved: Path, tmp_path: Path, name: str, array: np.ndarray, words: str
) -> None:
    run = shutil.copytree(moved, tmp_path / "run")
    with np.load(run / "terrain.npz") as terrain:
        arrays = {**terrain, name: array}
    np.savez(run / "terrain.npz", **arrays)
    with pytest.raises(RunError, match=words) as refusal:
        replay(run)
    assert "\n" not in str(refusal.value)
