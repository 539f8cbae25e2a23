"""A sweep from beginning to end: what is still to be walked is handed out, what comes back is kept.

The table depends on the walks alone: not on how many processes walked, in which order, or how often
the sweep was ended and went on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import dataclass
from pathlib import Path

from .executors import Workers
from .folder import asked, open_folder
from .grid import Case, Sweep, cases, scenarios
from .walker import Keep, WalkedCase, failed, walk_case

AHEAD = 3  # walks handed out for every worker, so that none waits for the collector
DIED = "the process that walked it died"


@dataclass
class SweepProgress:
    """How far a sweep is: runs there are, over, over before it went on, and passed."""

    total: int
    before: int = 0
    done: int = 0
    passed: int = 0


ReportSweep = Callable[[SweepProgress], None]


def walk_sweep(
    sweep: Sweep,
    out: Path,
    workers: Workers,
    *,
    keep: Keep = Keep.FAILED,
    force: bool = False,
    report: ReportSweep = lambda progress: None,
) -> SweepProgress:
    """Walk every case of a sweep that ``out`` does not hold yet, and write its tables.

    Raises ``ScenarioError`` and ``RunError`` before the first walk where something is wrong.
    """
    resolved = scenarios(sweep)
    with open_folder(out, sweep, asked(sweep, resolved, keep), force=force) as folder:
        passed = sum(bool(row["passed"]) for row in folder.rows)
        progress = SweepProgress(len(sweep), len(folder.rows), len(folder.rows), passed)
        report(progress)
        left = (case for case in cases(sweep, resolved) if case.index not in folder.done)
        for case, walked in walk_all(workers, left, keep):
            row = folder.add(case, walked)
            progress.done += 1
            progress.passed += bool(row["passed"])
            report(progress)
    return progress


def walk_all(
    workers: Workers, waiting: Iterable[Case], keep: Keep
) -> Iterator[tuple[Case, WalkedCase]]:
    """Each case with what came of it, as they end."""
    handout = _Handout(workers, iter(waiting), keep)
    try:
        while handout.hand_out():
            yield from handout.ended()
    finally:
        handout.stop()


class _Handout:
    """Which cases are out with the workers.

    A process that dies takes others' walks with it: those that were out are walked again, one by
    one, and only whoever dies alone has failed.
    """

    def __init__(self, workers: Workers, waiting: Iterator[Case], keep: Keep) -> None:
        self.workers = workers
        self.keep = keep
        self._waiting = waiting
        self._suspects = deque[Case]()
        self._executor = workers.make()
        self._out: dict[Future[WalkedCase], Case] = {}

    def hand_out(self) -> bool:
        """Keep the workers busy; False when nothing is out and nothing is left."""
        limit = 1 if self._suspects else AHEAD * self.workers.size
        while len(self._out) < limit:
            case = self._next()
            if case is None:
                break
            try:
                self._out[self._executor.submit(walk_case, case, self.keep)] = case
            except BrokenExecutor:
                self._suspects.append(case)
                break
        return bool(self._out or self._suspects)

    def _next(self) -> Case | None:
        return self._suspects.popleft() if self._suspects else next(self._waiting, None)

    def ended(self) -> Iterator[tuple[Case, WalkedCase]]:
        """Those that have ended by the time the next one has."""
        ended, _ = wait(self._out, return_when=FIRST_COMPLETED)
        if not ended or any(isinstance(f.exception(), BrokenExecutor) for f in ended):
            yield from self._after_a_death()
            return
        for future in ended:
            error = future.exception()
            case = self._out.pop(future)
            yield case, future.result() if error is None else failed(f"{DIED}: {error}")

    def _after_a_death(self) -> Iterator[tuple[Case, WalkedCase]]:
        """New workers; the one that was out alone has failed, several are suspects."""
        self._executor.shutdown(wait=False)
        self._executor = self.workers.make()
        lost = sorted(self._out.values(), key=lambda case: case.index)
        self._out.clear()
        if len(lost) == 1:
            yield lost[0], failed(DIED)
        else:
            self._suspects.extend(lost)

    def stop(self) -> None:
        """Nothing more is begun, and nobody waits for a walk that is still out."""
        for future in self._out:
            future.cancel()
        processes = list((getattr(self._executor, "_processes", None) or {}).values())
        self._executor.shutdown(wait=not self._out)
        if self._out:
            for process in processes:
                process.terminate()
