"""The folder of a sweep: what is over stays, what a kill left half is cut off."""

import json
from pathlib import Path

import pytest

from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.sweep.folder import (
    ROWS,
    SweepFolder,
    asked,
    axes_of,
    open_folder,
    read_asked,
)
from walking_console.sim.runs.sweep.grid import Case, Sweep, scenarios, sweep_of
from walking_console.sim.runs.sweep.table import read_table
from walking_console.sim.runs.sweep.walker import Keep, WalkedCase, failed

SWEEP = sweep_of("flat", ["mode=paper,predictive"], "1:2")


def opened(out: Path, sweep: Sweep = SWEEP, force: bool = False) -> SweepFolder:
    return open_folder(out, sweep, asked(sweep, scenarios(sweep), Keep.FAILED), force=force)


def case(index: int) -> Case:
    return Case(index, ("paper",), index + 1, {})


def test_a_folder_goes_on_where_it_was_left(tmp_path: Path) -> None:
    with opened(tmp_path / "s") as folder:
        folder.add(case(2), failed("because"))
    with opened(tmp_path / "s") as folder:
        assert folder.done == {2}
        folder.add(case(0), failed("because"))
    assert [row["run"] for row in read_table(tmp_path / "s")] == ["0", "2"]


def test_a_line_that_a_kill_left_half_is_cut_off_and_walked_again(tmp_path: Path) -> None:
    with opened(tmp_path / "s") as folder:
        folder.add(case(0), failed("because"))
    whole = (tmp_path / "s" / ROWS).read_bytes()
    (tmp_path / "s" / ROWS).write_bytes(whole + b'{"run": 1, "res')
    with opened(tmp_path / "s") as folder:
        assert folder.done == {0}
        folder.add(case(1), failed("because"))
    with opened(tmp_path / "s") as folder:
        assert folder.done == {0, 1}


def test_a_kept_directory_is_there_before_its_line(tmp_path: Path) -> None:
    with opened(tmp_path / "s") as folder:
        row = folder.add(case(3), WalkedCase({"passed": False}, {"run.json": b"{}"}))
    assert (tmp_path / "s" / row["directory"] / "run.json").read_bytes() == b"{}"
    assert not list((tmp_path / "s" / "runs").glob("*.part"))


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (sweep_of("flat", ["mode=paper"], "1:2"), "set"),
        (sweep_of("flat", ["mode=paper,predictive"], "1:3"), "seeds"),
        (sweep_of("river", ["mode=paper,predictive"], "1:2"), "scenario"),
    ],
)
def test_another_sweep_is_refused_and_force_empties_it(tmp_path: Path, other, said) -> None:
    with opened(tmp_path / "s") as folder:
        folder.add(case(0), failed("because"))
    with pytest.raises(RunError, match=rf"another sweep.*{said}.*--force"):
        opened(tmp_path / "s", other)
    with opened(tmp_path / "s", other, force=True) as folder:
        assert folder.done == set()


def test_a_folder_of_something_else_is_never_touched(tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine")
    for force in (False, True):
        with pytest.raises(RunError, match="new, empty or a sweep"):
            opened(tmp_path, force=force)
    assert (tmp_path / "precious.txt").read_text() == "mine"


def test_a_folder_without_a_sweep_or_with_a_broken_one_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"no sweep\.json"):
        read_asked(tmp_path)
    (tmp_path / "sweep.json").write_text("{")
    with pytest.raises(RunError, match="cannot read"):
        read_asked(tmp_path)
    (tmp_path / "sweep.json").write_text(json.dumps({"schema": 9}))
    with pytest.raises(RunError, match="schema 1"):
        read_asked(tmp_path)


def test_the_axes_are_read_back(tmp_path: Path) -> None:
    with opened(tmp_path / "s"):
        assert axes_of(read_asked(tmp_path / "s")) == SWEEP.axes
    with pytest.raises(RunError, match="pairs"):
        axes_of({"set": [1]})
