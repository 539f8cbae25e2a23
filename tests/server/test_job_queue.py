"""Children in their turn."""

import subprocess
import sys
import threading

import pytest

from walking_console.server.job_queue import JobQueue

SLEEPS = [sys.executable, "-c", "import sys; sys.stdin.read()"]


class Children:
    """Begins children that live until they are told to end."""

    def __init__(self) -> None:
        self.begun: list[subprocess.Popen[bytes]] = []
        self.another = threading.Semaphore(0)

    def begin(self) -> "subprocess.Popen[bytes]":
        child = subprocess.Popen(SLEEPS, stdin=subprocess.PIPE)
        self.begun.append(child)
        self.another.release()
        return child

    def end(self, number: int) -> None:
        pipe = self.begun[number].stdin
        assert pipe is not None
        pipe.close()
        self.begun[number].wait(30)


@pytest.fixture
def children():
    made = Children()
    yield made
    for child in made.begun:
        if child.stdin is not None:
            child.stdin.close()
        child.wait(30)


def test_so_many_are_at_work_and_the_next_begins_when_one_ends(children: Children) -> None:
    queue = JobQueue(at_once=2)
    jobs = [queue.add(children.begin) for _ in range(4)]
    assert [job.working for job in jobs] == [True, True, False, False]
    assert [queue.place(job) for job in jobs] == [None, None, 0, 1]
    for _ in range(2):
        assert children.another.acquire(timeout=30)
    children.end(0)
    assert children.another.acquire(timeout=30), "the third begins with nobody asking"
    assert jobs[2].process is children.begun[2] and queue.place(jobs[3]) == 0
    queue.stop()


def test_one_that_waits_is_cancelled_and_never_begun(children: Children) -> None:
    queue = JobQueue(at_once=1)
    first, second = queue.add(children.begin), queue.add(children.begin)
    queue.cancel(second)
    children.end(0)
    queue.stop()
    assert len(children.begun) == 1 and second.cancelled_at is not None
    assert not first.working and not second.waiting


def test_one_at_work_is_asked_to_end(children: Children) -> None:
    queue = JobQueue(at_once=1)
    job = queue.add(children.begin)
    queue.cancel(job)
    assert job.process is not None and job.process.wait(30) != 0
    queue.stop()


def test_one_that_cannot_begin_says_why_and_the_next_gets_its_turn(children: Children) -> None:
    def broken() -> "subprocess.Popen[bytes]":
        raise OSError(12, "no memory")

    queue = JobQueue(at_once=1)
    job = queue.add(broken)
    assert "no memory" in job.fault and not job.waiting
    assert queue.add(children.begin).working
    queue.stop()


def test_a_queue_that_was_stopped_begins_nothing_more(children: Children) -> None:
    queue = JobQueue(at_once=1)
    working, waiting = queue.add(children.begin), queue.add(children.begin)
    queue.stop()
    assert not working.working and not waiting.waiting and len(children.begun) == 1


def test_so_many_may_wait(children: Children, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("walking_console.server.job_queue.WAITING_MAX", 2)
    queue = JobQueue(at_once=0)
    for full in (False, False, True):
        assert queue.full is full
        if not full:
            queue.add(children.begin)
