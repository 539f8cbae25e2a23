"""Jobs and their folders, without HTTP."""

from pathlib import Path

from walking_console.server.job_queue import JobQueue
from walking_console.server.run_jobs import RunJobs


def test_runs_of_a_console_that_was_ended_are_interrupted(tmp_path: Path) -> None:
    (tmp_path / "jobs" / "flat-0001").mkdir(parents=True)
    runs = RunJobs(tmp_path, JobQueue())
    assert runs.state("flat-0001")["state"] == "interrupted"
