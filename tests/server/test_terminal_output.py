"""What the command line shows people."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from walking_console.server.terminal_output import print_list, print_summary, progress_shown

SUMMARY: dict[str, Any] = {
    "result": "completed", "reason": "time", "seconds": 4.0, "ticks": 200, "distance": 0.25,
    "mean_speed": 0.0625, "steps": 7, "forbidden_steps": 0, "falls": 0, "margin_min": 0.0123,
    "emergent": {"early": 2}, "ground": "mesh of 60 triangles", "state_hash": "00ff",
    "body": "sway",
    "expect": {"distance_min": {"wanted": 1.0, "got": 0.25, "pass": False}},
}  # fmt: skip


def test_one_screen_has_result_figures_and_every_expectation(
    capsys: pytest.CaptureFixture[str],
) -> None:
    print_summary(SUMMARY, Path("runs/flat-0001"))
    shown = capsys.readouterr().out
    for told in ("completed (time)", "4.00 s, 200 ticks", "0.250 m, mean speed 0.0625 m/s"):
        assert told in shown
    for told in (
        "7, forbidden 0, falls 0",
        "12.3 mm",
        "early 2",
        "mesh of 60 triangles",
        "runs/flat-0001",
    ):
        assert told in shown
    assert "FAIL: wanted 1, got 0.25" in shown


def test_what_was_not_measured_is_said_to_be_none(capsys: pytest.CaptureFixture[str]) -> None:
    print_summary(SUMMARY | {"margin_min": None, "emergent": {}, "expect": {}}, Path("here"))
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["least", "margin", "none"] in lines and ["emergent", "none"] in lines


@pytest.mark.parametrize(("body", "said"), [("straight", True), ("sway", False)])
def test_a_walk_with_its_body_straight_as_printed_says_so(
    capsys: pytest.CaptureFixture[str], body: str, said: bool
) -> None:
    print_summary(SUMMARY | {"body": body}, Path("here"))
    assert ("straight, as printed" in capsys.readouterr().out) == said


def test_progress_is_json_lines_when_asked_and_silence_without_a_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    walk = SimpleNamespace(tick_count=50, distance=0.1)
    with progress_shown(as_json=True) as report:
        assert report is not None
        report(walk, 0.5)
    line = json.loads(capsys.readouterr().out)
    assert line == {"progress": 0.5, "tick": 50, "distance_m": 0.1}
    with progress_shown(as_json=False) as nothing:
        assert nothing is None


def test_a_list_stands_in_two_columns(capsys: pytest.CaptureFixture[str]) -> None:
    print_list([("a", "one"), ("longer", "two")])
    assert capsys.readouterr().out == "a       one\nlonger  two\n"
