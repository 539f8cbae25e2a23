"""Headless runs: their timeline, their end, their expectations."""

import pytest

from walking_console.sim.requests import Halt, TakePosture
from walking_console.sim.runs.run_files import RunError
from walking_console.sim.runs.runner import held, run_scenario, succeeded, timeline
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.simulation import Simulation

FREE = "expect={}"


def test_entries_come_in_ticks_with_what_they_ask_for_beside_the_command() -> None:
    drive = [
        {"t": 0.0, "speed": 0.1},
        {"t": 1.0},
        {"t": 2.0, "posture": "sit"},
    ]
    walks, holds, sits = timeline(scenario_from({"drive": drive}))
    assert (walks.tick, walks.command.speed, walks.request) == (0, 0.1, None)
    assert (holds.tick, holds.command.holds, holds.request) == (50, True, Halt())
    assert (sits.tick, sits.request) == (100, TakePosture("sit"))


def test_a_given_trace_is_one_command_at_its_speed() -> None:
    trace = {"kind": "line", "speed": 0.07}
    (entry,) = timeline(scenario_from({"planner": "trace", "trace": trace}))
    assert (entry.tick, entry.command.speed) == (0, 0.07)
    assert timeline(scenario_from({})) == []


def test_a_distance_ends_a_run_at_once_and_a_time_to_the_tick() -> None:
    walked = run_scenario(load_scenario("flat", ("end={distance=0.5}", FREE)))
    assert (walked["result"], walked["reason"]) == ("completed", "distance")
    assert 0.5 <= walked["distance"] + 1e-9 and walked["distance"] < 0.51
    timed = run_scenario(load_scenario("flat", ("end={time=3.0}", FREE)))
    assert (timed["reason"], timed["ticks"]) == ("time", 150)


def test_a_trace_walked_to_its_end_is_completed() -> None:
    trace = {"kind": "line", "length": 0.6}
    walked = run_scenario(
        scenario_from({"planner": "trace", "robot": "hexapod", "trace": trace, "end": {"time": 60}})
    )
    assert (walked["result"], walked["reason"]) == ("completed", "the trace ends here")
    assert walked["ticks"] < 3000


def test_ten_seconds_without_a_way_on_end_a_run_blocked() -> None:
    settings = ("terrain.width=3.0", "detours=false", "end={time=120.0}", FREE)
    walked = run_scenario(load_scenario("river", settings))
    assert walked["result"] == "blocked" and walked["reason"]
    assert walked["ticks"] < 6000


def test_a_run_without_a_time_ends_blocked_when_its_time_is_over(monkeypatch) -> None:
    monkeypatch.setattr("walking_console.sim.scenario.TIME_LIMIT", 2.0)
    walked = run_scenario(load_scenario("flat", ("end={distance=5.0}", FREE)))
    assert (walked["result"], walked["reason"], walked["ticks"]) == ("blocked", "time", 100)


def test_what_was_walked_before_an_interrupt_is_kept(tmp_path) -> None:
    def stop(simulation: Simulation, share: float) -> None:
        if simulation.tick_count > 300:
            raise KeyboardInterrupt

    walked = run_scenario(load_scenario("flat"), tmp_path / "run", progress=stop)
    assert walked["result"] == "interrupted" and walked["ticks"] == 501
    assert (tmp_path / "run" / "run.json").is_file()


def test_progress_is_the_share_of_what_ends_the_run() -> None:
    shares: list[float] = []
    scenario = load_scenario("flat", ("end={time=20.0}", FREE))
    run_scenario(scenario, progress=lambda simulation, share: shares.append(share))
    assert shares == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])


def test_a_directory_that_cannot_be_made_is_said(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot write the run directory"):
        run_scenario(load_scenario("flat", ("end={time=1.0}", FREE)), tmp_path / "file" / "run")


FIGURES = {
    "distance": 2.0,
    "emergent": {"early": 1, "late": 2},
    "seconds": 9.0,
    "margin_min": None,
    "polygon_margin_min": 0.02,
    "capture_margin_min": 0.019,
    "tilt_deg": 1.5,
}


@pytest.mark.parametrize(
    ("expect", "passes"),
    [
        ({"distance_min": 2.0}, True),
        ({"distance_min": 2.1}, False),
        ({"emergent_max": 3}, True),
        ({"emergent_max": 2}, False),
        ({"time_max": 9.0}, True),
        ({"margin_min": -1.0}, False),
        ({"polygon_margin_min": 0.02}, True),
        ({"capture_margin_min": 0.02}, False),
        ({"tilt_max_deg": 1.0}, False),
    ],
)
def test_an_expectation_holds_at_its_limit_and_never_for_what_was_not_measured(
    expect: dict[str, float], passes: bool
) -> None:
    (answer,) = held(scenario_from({"expect": expect}), FIGURES).values()
    assert answer["pass"] is passes
    summary = {"result": "completed", "expect": {"one": answer}}
    assert succeeded(summary) is passes
    assert not succeeded({**summary, "result": "blocked"})
