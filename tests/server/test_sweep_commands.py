"""The command line of sweeps."""

import json
from pathlib import Path

import pytest

from tests.server.command_line import called
from walking_console.server.sweep_commands import RemainingTime
from walking_console.sim.runs.sweep.runner import SweepProgress

SHORT = ("--set", "end={time=1.0}", "--set", "expect={}", "--jobs", 1)


def test_a_sweep_writes_its_table_and_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "s"
    result = called("sweep", "flat", *SHORT, "--set", "drive.0.speed=0.05,0.08", "--out", out)
    assert result.exit_code == 0, result.output
    assert "2 of 2 runs passed" in result.output
    drawn = called("sweep", "plot", out, "--out", tmp_path / "s.svg")
    assert drawn.exit_code == 0 and "drive.0.speed" in (tmp_path / "s.svg").read_text()
    refused = called("sweep", "plot", out, "--out", tmp_path / "s.gif")
    assert refused.exit_code == 2 and ".svg" in refused.stderr


def test_progress_is_a_line_of_json_for_every_run(tmp_path: Path) -> None:
    result = called("sweep", "flat", *SHORT, "--seeds", "1:2", "--out", tmp_path / "s",
                    "--progress-json")  # fmt: skip
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert [line["done"] for line in lines] == [0, 1, 2]
    assert lines[0]["left_s"] is None and lines[1]["left_s"] > 0.0 and lines[2]["left_s"] == 0.0


def test_a_whole_sweep_is_not_walked_again(tmp_path: Path) -> None:
    words = ("sweep", "flat", *SHORT, "--out", tmp_path / "s", "--progress-json")
    called(*words)
    again = called(*words)
    assert [json.loads(line)["done"] for line in again.stdout.splitlines()] == [1]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("flatt",), "unknown scenario"),
        (("flat", "--set", "speeed=1,2"), "speeed"),
        (("flat", "--set", "end.time=1.0,soon"), "end.time"),
        (("flat", "--seeds", "3:1"), "--seeds"),
        (("flat", "--on", "ssh://x"), "--on"),
        (("flat", "--jobs", "0"), "--jobs"),
        (("flat", "--keep", "some"), "--keep"),
    ],
)
def test_bad_input_is_exit_2_and_nothing_is_written(tmp_path: Path, words, said) -> None:
    result = called("sweep", *words, "--out", tmp_path / "s")
    assert result.exit_code == 2 and said in result.stderr
    assert not (tmp_path / "s").exists()


def test_a_folder_that_is_no_sweep_is_not_drawn(tmp_path: Path) -> None:
    result = called("sweep", "plot", tmp_path, "--out", tmp_path / "s.svg")
    assert result.exit_code == 2 and "sweep.json" in result.stderr


def test_time_left_is_judged_by_what_was_walked_now(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [100.0]
    monkeypatch.setattr("walking_console.server.sweep_commands.time.monotonic", lambda: clock[0])
    remaining = RemainingTime()
    assert remaining.left(SweepProgress(10, before=4, done=4)) is None
    clock[0] = 106.0
    assert remaining.left(SweepProgress(10, before=4, done=6)) == pytest.approx(12.0)
