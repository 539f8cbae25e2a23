"""Where the walks of a sweep are walked: processes of this computer, or of a Dask cluster.

Both are executors of ``concurrent.futures``; a process walks many.
"""

from __future__ import annotations

import gc
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Any, NamedTuple

from walking_console.sim.runs.run_files import RunError

HERE = "processes"
DASK = "dask://"
CLUSTER_TIMEOUT = 10.0  # s to reach a scheduler
# processes at most: more than any one computer has, and Windows waits for no more than 61
JOBS_MAX = 60


class Workers(NamedTuple):
    """How an executor is made, anew where a process has died of its walk, and how many walk."""

    make: Callable[[], Executor]
    size: int
    close: Callable[[], None]


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def open_workers(on: str = HERE, jobs: int | None = None) -> Workers:
    """Workers on this computer, ``jobs`` of them or one for each core, or on the cluster of
    ``dask://HOST:PORT``. Raises ``RunError``.
    """
    if on == HERE:
        count = min(jobs or cores(), JOBS_MAX)
        return Workers(lambda: _processes(count), count, lambda: None)
    if on.startswith(DASK) and len(on) > len(DASK):
        return _dask(on.removeprefix(DASK))
    raise RunError(f"--on wants {HERE!r} or {DASK}HOST:PORT, got {on!r:.200}")


def _processes(count: int) -> Executor:
    # spawned, not forked: the progress bar has a thread, and a fork of threads may hang
    return ProcessPoolExecutor(
        count, multiprocessing.get_context("spawn"), initializer=begin_worker
    )


def begin_worker() -> None:
    """Leave interrupts to the process that collects, end with it, and let the collector forget what
    stays.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    gc.collect()
    gc.freeze()


def _end_with(sentinel: int) -> None:
    """A collector that was killed leaves no process behind."""
    multiprocessing.connection.wait([sentinel])
    os._exit(1)


def _dask(address: str) -> Workers:
    """Every thread of every worker of a cluster is one that walks."""
    try:
        from distributed import Client
    except ModuleNotFoundError:
        extra = "pip install 'walking-console[dask]'"
        raise RunError(f"walking on a Dask cluster needs distributed: {extra}") from None
    try:
        make: Any = Client  # untyped, and where it is not installed unknown
        client = make(address, timeout=CLUSTER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise RunError(f"cannot reach the Dask cluster {address!r:.200}: {error}") from None
    count = sum(client.nthreads().values())
    if count == 0:
        client.close()
        raise RunError(f"the Dask cluster {address!r:.200} has no workers")
    # never the answer of an earlier call: what is asked twice is walked twice
    return Workers(lambda: client.get_executor(pure=False), count, client.close)
