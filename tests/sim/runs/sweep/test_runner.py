"""Sweeps whole: the same table however many walk, wherever it was ended, here or on a cluster."""

import json
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest

from walking_console.sim.runs.sweep.executors import Workers, open_workers
from walking_console.sim.runs.sweep.folder import ROWS
from walking_console.sim.runs.sweep.grid import Case, sweep_of
from walking_console.sim.runs.sweep.runner import DIED, SweepProgress, walk_all, walk_sweep
from walking_console.sim.runs.sweep.table import CSV, read_table
from walking_console.sim.runs.sweep.walker import Keep

SETTINGS = ["end={time=1.5}", "expect={distance_min=0.085}", "drive.0.speed=0.05,0.08"]
SWEEP = sweep_of("flat", SETTINGS, "1:3")


def in_this_process() -> Workers:
    return Workers(lambda: ThreadPoolExecutor(1), 1, lambda: None)


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sweep, walked by one."""
    out = tmp_path_factory.mktemp("sweep") / "one"
    walk_sweep(SWEEP, out, in_this_process())
    return out


def table(folder: Path) -> str:
    return (folder / CSV).read_text("utf-8")


def test_there_is_a_row_for_every_run_and_failed_ones_keep_their_directories(walked: Path) -> None:
    rows = list(read_table(walked))
    assert [row["run"] for row in rows] == ["0", "1", "2", "3", "4", "5"]
    assert [row["passed"] for row in rows] == ["0", "0", "0", "1", "1", "1"]
    assert [row["directory"] for row in rows[:3]] == ["runs/000000", "runs/000001", "runs/000002"]
    summary = json.loads((walked / "runs/000002/run.json").read_text())
    assert summary["state_hash"] == rows[2]["state_hash"] and summary["scenario"]["seed"] == 3
    assert {row["directory"] for row in rows[3:]} == {""}


def test_two_processes_make_the_same_table(walked: Path, tmp_path: Path) -> None:
    reports: list[int] = []

    def note(progress: SweepProgress) -> None:
        reports.append(progress.done)

    came = walk_sweep(SWEEP, tmp_path / "two", open_workers(jobs=2), report=note)
    assert table(tmp_path / "two") == table(walked)
    assert came == SweepProgress(6, 0, 6, 3) and reports == [0, 1, 2, 3, 4, 5, 6]


def test_a_sweep_that_was_ended_goes_on_to_the_same_table(walked: Path, tmp_path: Path) -> None:
    def end_after_two(progress: SweepProgress) -> None:
        if progress.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        walk_sweep(SWEEP, tmp_path / "s", in_this_process(), report=end_after_two)
    assert len(list(read_table(tmp_path / "s"))) == 2, "the table of what was walked is there"
    came = walk_sweep(SWEEP, tmp_path / "s", in_this_process())
    assert came.before == 2 and table(tmp_path / "s") == table(walked)


@pytest.mark.skipif(os.name == "nt", reason="a kill that nothing can catch is POSIX's")
def test_a_sweep_that_was_killed_goes_on_and_leaves_no_process(
    walked: Path, tmp_path: Path
) -> None:
    words = ["sweep", "flat", "--out", "s", "--jobs", "1", "--seeds", "1:3", "--progress-json"]
    words += [word for setting in SETTINGS for word in ("--set", setting)]
    with subprocess.Popen(
        [sys.executable, "-m", "walking_console", *words],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        start_new_session=True,
    ) as child:
        assert child.stdout is not None
        for line in child.stdout:
            if json.loads(line)["done"] == 2:
                child.send_signal(signal.SIGKILL)
                break
        # its worker has the other end of this pipe: the end of file says that it has ended too
        child.stdout.read()
    lines = (tmp_path / "s" / ROWS).read_text().splitlines()
    assert 2 <= len(lines) < 6
    walk_sweep(SWEEP, tmp_path / "s", in_this_process())
    assert table(tmp_path / "s") == table(walked)


@pytest.fixture
def cluster() -> Iterator[str]:
    """A Dask cluster of two processes on this computer."""
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, worker_dashboard_address=None
        ) as made:
            yield made.scheduler_address.removeprefix("tcp://")


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_makes_the_same_table(walked: Path, tmp_path: Path, cluster: str) -> None:
    workers = open_workers(f"dask://{cluster}")
    try:
        assert workers.size == 2
        walk_sweep(SWEEP, tmp_path / "d", workers)
    finally:
        workers.close()
    assert table(tmp_path / "d") == table(walked)
    assert (tmp_path / "d/runs/000001/ticks.npz").exists()


class DiesOf(Executor):
    """A pool whose process dies of one case, and with it everything that is out."""

    def __init__(self, deadly: int) -> None:
        self.deadly = deadly
        self.out: list[Future[Any]] = []

    def submit(self, function: Any, case: Case, *rest: Any, **named: Any) -> Any:  # type: ignore[override]
        future: Future[Any] = Future()
        self.out.append(future)
        if case.index == self.deadly:
            for one in self.out:
                if not one.done():
                    one.set_exception(BrokenProcessPool("died"))
        elif len(self.out) > 1:  # the first waits, and dies with the others
            future.set_result(function(case, *rest))
        else:
            self.first = case
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        for one in self.out:
            one.cancel()


def test_only_the_walk_that_its_process_dies_of_alone_has_failed() -> None:
    pools: list[Executor] = []

    def make() -> Executor:
        # the first pool holds the first case back, so that it dies with the deadly one
        pools.append(DiesOf(1) if not pools else Alone(1))
        return pools[-1]

    some = [Case(index, (), index, {"robot": "none"}) for index in range(4)]
    came = {
        case.index: walked.row
        for case, walked in walk_all(Workers(make, 1, print), some, Keep.NONE)
    }
    assert sorted(came) == [0, 1, 2, 3]
    assert [came[index]["reason"] == DIED for index in range(4)] == [False, True, False, False]


class Alone(DiesOf):
    """Each case is done as it comes."""

    def submit(self, function: Any, case: Case, *rest: Any, **named: Any) -> Any:
        future: Future[Any] = Future()
        if case.index == self.deadly:
            future.set_exception(BrokenProcessPool("died"))
        else:
            future.set_result(function(case, *rest))
        return future
