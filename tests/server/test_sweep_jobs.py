"""What a sweep over HTTP gives its child."""

from pathlib import Path

from walking_console.server.job_queue import JobQueue
from walking_console.server.sweep_jobs import SweepJobs, SweepOrder


def test_a_shipped_scenario_is_named_and_the_settings_follow(tmp_path: Path) -> None:
    order = SweepOrder("flat", None, ("mode=a,b", "end={time=1.0}"), "1:3", "all")
    words = order.words(tmp_path, tmp_path / "out")
    assert words[:4] == ["sweep", "flat", "--out", str(tmp_path / "out")]
    assert words[4:10] == ["--set", "mode=a,b", "--set", "end={time=1.0}", "--seeds", "1:3"]
    assert "--progress-json" in words and words[words.index("--keep") + 1] == "all"


def test_one_of_its_own_is_written_with_the_files_it_names(tmp_path: Path) -> None:
    (tmp_path / "uploads").mkdir()
    file = tmp_path / "uploads" / "hill.npy"
    file.write_bytes(b"heights")
    folder = tmp_path / "job"
    folder.mkdir()
    scenario = {"terrain": {"kind": "file", "file": "hill.npy"}}
    words = SweepOrder("inline", scenario, (), None, "none", (file,)).words(folder, tmp_path / "o")
    assert words[1] == str(folder / "scenario.toml") and "hill.npy" in Path(words[1]).read_text()
    assert (folder / "hill.npy").read_bytes() == b"heights" and "--seeds" not in words


def test_a_sweep_of_a_console_that_was_ended_says_how_far_it_was(tmp_path: Path) -> None:
    folder = tmp_path / "sweeps" / "flat-0001"
    folder.mkdir(parents=True)
    (folder / "sweep.json").write_text('{"runs": 3}')
    sweeps = SweepJobs(tmp_path, JobQueue())
    assert sweeps.state("flat-0001")["state"] == "interrupted"
    (folder / "table.csv").write_text("run,passed\n0,1\n1,0\n")
    state = sweeps.state("flat-0001")
    assert state["state"] == "interrupted" and state["result"] == {"runs": 2, "passed": 1}
    (folder / "table.csv").write_text("run,passed\n0,1\n1,0\n2,1\n")
    state = sweeps.state("flat-0001")
    assert state["state"] == "completed" and state["result"] == {"runs": 3, "passed": 2}
