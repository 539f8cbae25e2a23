"""The processes a sweep is walked by."""

import os
from concurrent.futures.process import BrokenProcessPool

import pytest

from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.sweep.executors import JOBS_MAX, cores, open_workers


@pytest.mark.parametrize("on", ["dask", "dask://", "ssh://somewhere", ""])
def test_where_nothing_can_walk_is_refused(on):
    with pytest.raises(RunError, match="--on wants"):
        open_workers(on)


def test_a_cluster_that_is_not_there_is_one_clear_line(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("walking_console.sim.runs.sweep.executors.CLUSTER_TIMEOUT", 0.2)
    with pytest.raises(RunError, match="cannot reach the Dask cluster"):
        open_workers("dask://127.0.0.1:1")


def test_there_is_a_process_for_each_core_or_as_many_as_asked():
    assert open_workers().size == min(cores(), JOBS_MAX)
    assert open_workers(jobs=3).size == 3


def test_a_process_does_many_and_one_that_dies_is_told():
    workers = open_workers(jobs=1)
    with workers.make() as pool:
        assert len({pool.submit(os.getpid).result() for _ in range(3)}) == 1
        with pytest.raises(BrokenProcessPool):
            pool.submit(os._exit, 1).result()
