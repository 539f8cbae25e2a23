"""Timing every tick of a walk: what is timed, not how much it is."""

import pytest

from walking_console.sim.runs.tick_times import SENSINGS, time_walk, time_walks, walks_to_time
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import scenario_names


def test_every_tick_counts_and_all_figures_are_of_one_measurement() -> None:
    times = time_walk("flat", seconds=2.0)
    assert (times.scenario, times.plant, times.sensing) == ("flat", "kinematic", "known")
    assert times.ticks == 100 and times.distance > 0.05
    assert 0.0 < times.median <= times.p99 <= times.p999 <= times.largest
    assert times.largest >= times.first > 0.0
    total = times.ticks * 20.0 / times.factor  # ms
    assert times.per_metre == pytest.approx(total / times.distance)
    assert times.largest <= total and times.median * times.ticks / 2 <= total


def test_a_walk_that_ends_earlier_is_timed_to_its_end() -> None:
    assert time_walk("flat", ["end={time=1.0}"], 5.0).ticks == 50


def test_where_nothing_is_walked_there_is_no_time_a_metre() -> None:
    assert time_walk("flat", ["drive=[]", "end={time=1.0}"]).per_metre is None


def test_every_scenario_is_walked_with_each_sensing_and_on_each_plant() -> None:
    walks = list(walks_to_time(["physics"]))
    assert {name for name, _ in walks} == set(scenario_names())
    assert len(walks) == len(scenario_names()) * (len(SENSINGS) + 1)
    assert ("dem", ("sensing=eye",)) in walks
    assert ("dem", ("sensing=known", "plant=physics")) in walks


def test_only_what_is_asked_for_is_walked(monkeypatch: pytest.MonkeyPatch) -> None:
    times = list(time_walks((), 0.2, ["river"]))
    assert [entry.sensing for entry in times] == list(SENSINGS)


def test_what_a_scenario_cannot_be_walked_by_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(name: str, settings: tuple[str, ...], seconds: float | None) -> None:
        raise ScenarioError("no")

    monkeypatch.setattr("walking_console.sim.runs.tick_times.time_walk", refused)
    assert list(time_walks((), 1.0)) == []


def test_figures_for_a_file_are_rounded_to_what_repeats() -> None:
    data = time_walk("flat", seconds=0.2).as_data()
    assert data["scenario"] == "flat" and data["ticks"] == 10
    assert len(f"{data['median']:g}".replace(".", "").lstrip("0")) <= 10
