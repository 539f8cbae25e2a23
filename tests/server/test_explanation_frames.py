"""What goes out beside snapshots: why a step was chosen, and what a trace walker foresees."""

import json

import pytest
from fastapi.testclient import TestClient

from walking_console.planner.types import Command
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.explanation_frames import CANDIDATES_SHOWN, ahead_frame, decision_frame
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

HERE = {"origin": "http://127.0.0.1:8000"}


def walked(console: Simulation, command: Command, ticks: int) -> Simulation:
    for _ in range(ticks):
        console.order(command)
        console.step()
    return console


def hexapod() -> Simulation:
    terrain = {"kind": "footholds", "fraction": 0.1}
    scenario = scenario_from(
        {
            "name": "six",
            "robot": "hexapod",
            "planner": "trace",
            "trace": {"kind": "sine"},
            "terrain": terrain,
        },
        None,
    )
    return walked(Simulation(prepare(scenario), explain=True), Command(speed=0.1), 200)


@pytest.mark.parametrize("mode", ["paper", "predictive"])
def test_a_crab_step_says_who_was_tried_and_where_it_searched(mode: str) -> None:
    console = walked(
        Simulation(prepare(load_scenario("holes", [f'mode="{mode}"'])), explain=True),
        Command(0.0, 0.1),
        300,
    )
    told = decision_frame(console.snapshot())
    assert told is not None
    assert told.leg in (1, 2, 3, 4) and told.legs and told.domain_m and told.landing_m
    assert bool(told.search) == (mode == "predictive") and len(told.candidates) <= CANDIDATES_SHOWN
    xs, ys = zip(*told.domain_m, strict=True)
    assert (
        min(xs) - 0.03 <= told.landing_m[0] <= max(xs) + 0.03
        and min(ys) - 0.03 <= told.landing_m[1] <= max(ys) + 0.03
    )
    json.dumps(told.model_dump(), allow_nan=False)


@pytest.mark.parametrize("turn_rate", [0.1, -0.1])
def test_a_turning_step_says_what_was_weighed(turn_rate: float) -> None:
    console = walked(
        Simulation(prepare(load_scenario("flat")), explain=True), Command(0.0, 0.08, turn_rate), 200
    )
    told = decision_frame(console.snapshot())
    assert told is not None
    assert told.search == "turn" and told.candidates and len(told.legs) == 4
    json.dumps(told.model_dump(), allow_nan=False)


def test_a_walker_that_cannot_step_says_why_of_every_leg() -> None:
    console = Simulation(
        prepare(load_scenario("river", ['mode="paper"', "terrain.width=1.6", "detours=false"])),
        explain=True,
    )
    for _ in range(40):
        walked(console, Command(0.0, 0.15), 50)
        if console.snapshot().mode.name == "BLOCKED":
            break
    frame = decision_frame(console.snapshot())
    assert frame is not None and frame.shift_m is None
    assert all(trial["reason"] for trial in frame.legs) and frame.legs


def test_a_console_that_keeps_no_reasons_has_none() -> None:
    assert (
        decision_frame(
            walked(Simulation(prepare(load_scenario("flat"))), Command(0.0, 0.08), 100).snapshot()
        )
        is None
    )


def test_a_trace_walker_tells_what_it_foresees_in_a_few_kilobytes() -> None:
    console = hexapod()
    told = ahead_frame(console.snapshot())
    assert told is not None
    assert (
        told.complete and len(told.segments_m) == 6 and told.reached_m > console.snapshot().course
    )
    assert len(json.dumps(told.model_dump(), allow_nan=False)) < 16_000
    decided = decision_frame(console.snapshot())
    assert decided is not None and "states met" in decided.notes[0]


def test_pages_and_rest_are_told_once_for_every_change() -> None:
    loop = RealtimeLoop(hexapod())
    with TestClient(create_app(loop, AppSettings()), base_url=HERE["origin"]) as client:
        assert client.get("/api/v1/console/ahead").json()["type"] == "ahead"
        assert client.get("/api/v1/console/decision").json()["type"] == "decision"
        with client.websocket_connect("ws://127.0.0.1:8000/drive", headers=HERE) as socket:
            kinds = [socket.receive_json()["type"] for _ in range(5)]
            assert kinds == ["hello", "lease", "snapshot", "ahead", "decision"]
