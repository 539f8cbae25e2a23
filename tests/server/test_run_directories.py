"""Where a run of the command line is written."""

from pathlib import Path

import pytest

from walking_console.server.run_directories import RUNS, empty_directory, next_directory
from walking_console.sim.runs.run_files import RunError


def test_without_a_name_the_next_free_number_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    taken = [next_directory("flat") for _ in range(2)] + [next_directory("My walk!")]
    assert taken == [RUNS / "flat-0001", RUNS / "flat-0002", RUNS / "my-walk-0001"]
    assert all(path.is_dir() for path in taken)


def test_a_number_in_use_is_passed_over_even_for_a_file(tmp_path: Path) -> None:
    (tmp_path / "flat-0001").write_text("mine")
    assert next_directory("flat", tmp_path) == tmp_path / "flat-0002"
    assert (tmp_path / "flat-0001").read_text() == "mine"


def test_a_file_in_the_place_of_all_runs_is_said(tmp_path: Path) -> None:
    (tmp_path / "runs").write_text("mine")
    with pytest.raises(RunError, match="runs"):
        next_directory("flat", tmp_path / "runs")


def test_a_directory_that_is_not_empty_is_refused_and_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine")
    for force in (False, True):
        with pytest.raises(RunError, match=r"run\.json" if force else "--force"):
            empty_directory(tmp_path, force)
    assert (tmp_path / "precious.txt").read_text() == "mine"


def test_force_empties_a_run_directory(tmp_path: Path) -> None:
    for name in ("run.json", "ticks.npz"):
        (tmp_path / name).write_text("{}")
    assert empty_directory(tmp_path, force=True) == tmp_path and not list(tmp_path.iterdir())


def test_a_file_is_no_directory(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    with pytest.raises(RunError, match="is a file"):
        empty_directory(tmp_path / "out", force=True)
