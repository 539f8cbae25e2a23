"""A walk as one page: titled, with what was measured and curves over time."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from walking_console.server.replay_page import Reading, panel, write_replay
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World


@pytest.fixture
def walk(flat: World) -> list[Snapshot]:
    simulation = Simulation(flat)
    simulation.drive(0.0, 0.1)
    snapshots = []
    for _ in range(50):
        simulation.run(seconds=0.06)
        snapshots.append(simulation.snapshot())
    return snapshots


def test_a_page_is_titled_has_its_readings_and_names_no_other_file(
    walk: list[Snapshot], tmp_path: Path
) -> None:
    write_replay(walk, tmp_path / "walk.html", "Mine & <yours>")
    page = (tmp_path / "walk.html").read_text("utf-8")
    assert "<title>Mine &amp; &lt;yours&gt;</title>" in page
    shown = page[page.index("<details id=walk") :]
    assert f"<dd>{walk[-1].distance:.2f} m</dd>" in shown and shown.count("<svg") == 3
    assert not re.search(r'(?:src|href)="https?://', page)


def test_a_minute_takes_less_than_3_megabytes(walk: list[Snapshot], tmp_path: Path) -> None:
    minute = [replace(each, time=each.time + 3.0 * k) for k in range(20) for each in walk]
    write_replay(minute, tmp_path / "walk.html", "a minute")
    assert minute[-1].time - minute[0].time == pytest.approx(60.0, abs=0.5)
    assert (tmp_path / "walk.html").stat().st_size < 3_000_000


def test_a_reset_in_between_is_a_short_pause(walk: list[Snapshot], tmp_path: Path) -> None:
    write_replay([*walk, *walk[:10]], tmp_path / "walk.html", "twice")
    page = (tmp_path / "walk.html").read_text("utf-8")
    seconds = float(re.search(r"<dt>Time</dt><dd>([\d.]+) s", page)[1])  # type: ignore[index]
    assert seconds == pytest.approx(49 * 0.06 + 0.25 + 9 * 0.06, abs=0.06)


def test_a_curve_has_a_gap_where_there_is_no_margin(walk: list[Snapshot]) -> None:
    readings = [Reading(0.1 * k, 0.1, math.nan if k == 5 else 0.03, 0.85) for k in range(10)]
    shown = panel("gap", readings, walk[-1])
    assert shown.count("<line") == 3
    assert 'data-values="0.030 0.030 0.030 0.030 0.030 nan 0.030' in shown
    curve = re.findall(r'<path d="([^"]*)"', shown)[1]
    assert curve.count("M") == 2 and curve.count("L") == 7
    assert "<dd>30 mm</dd>" in shown
