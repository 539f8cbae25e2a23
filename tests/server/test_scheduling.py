"""Thread scheduling: harmless where it is not allowed, and threads give way quickly."""

import gc
import os
import sys
import threading
from collections.abc import Iterator

import pytest

from walking_console.server.scheduling import SWITCH_INTERVAL, raise_priority, shorten_pauses


@pytest.fixture
def restored() -> Iterator[None]:
    interval = sys.getswitchinterval()
    yield
    sys.setswitchinterval(interval)
    gc.unfreeze()


def test_threads_give_way_quickly_and_what_is_loaded_is_not_collected(restored: None) -> None:
    shorten_pauses()
    assert sys.getswitchinterval() <= SWITCH_INTERVAL * 1.01 and gc.get_freeze_count() > 0


def test_where_the_system_refuses_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def refuse(*_: object) -> None:
        asked.append("asked")
        raise PermissionError

    monkeypatch.setattr(os, "setpriority", refuse, raising=False)
    monkeypatch.setattr(os, "sched_setscheduler", refuse, raising=False)
    raise_priority()
    assert len(asked) == (2 if sys.platform == "linux" else 0)


@pytest.mark.skipif(sys.platform != "linux", reason="a thread's own scheduling is Linux's")
def test_only_the_thread_that_asks_goes_first() -> None:
    before = os.sched_getscheduler(0)
    thread = threading.Thread(target=raise_priority)
    thread.start()
    thread.join()
    assert os.sched_getscheduler(0) == before
