"""The console over HTTP: what is answered, what is refused and how the refusal reads."""

import json
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server.api.kept_world import KeptWorld
from walking_console.server.api.state import WORLD
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.uploads import Uploads
from walking_console.sim.requests import Push
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.world import prepare

COMMAND = {"crab_angle_rad": 0.0, "speed_m_s": 0.08, "turn_rate_rad_s": 0.0, "ttl_s": 0.5}


def test_the_snapshot_has_every_promised_key(client: TestClient) -> None:
    snapshot = client.get("/api/v1/console").json()
    example = client.get("/openapi.json").json()["components"]["schemas"]["SnapshotFrame"][
        "examples"
    ][0]
    assert set(snapshot) == set(example)
    assert (
        snapshot["robot"] == "titan3" and len(snapshot["body"]) == 6 and len(snapshot["feet"]) == 4
    )


def test_a_command_moves_the_machine_until_it_lapses(
    client: TestClient, loop: RealtimeLoop
) -> None:
    assert client.put("/api/v1/console/command", json=COMMAND).status_code == 202
    loop.tick()
    assert client.get("/api/v1/console").json()["speed_m_s"] == 0.08
    for _ in range(25):
        loop.tick()
    assert client.get("/api/v1/console").json()["speed_m_s"] == 0.0


def test_a_posture_is_taken_from_a_standstill_and_shown(
    client: TestClient, loop: RealtimeLoop
) -> None:
    client.put("/api/v1/console/command", json=COMMAND)
    loop.tick()
    answer = client.post("/api/v1/console/posture", json={"posture": "sit"})
    assert answer.status_code == 202 and answer.json()["posture"] == "sit"
    seen = set()
    for _ in range(150):
        loop.tick()
        seen.add(client.get("/api/v1/console").json()["mode"])
    assert "sit_down" in seen
    snapshot = client.get("/api/v1/console").json()
    assert (snapshot["mode"], snapshot["posture"], snapshot["speed_m_s"]) == ("sit", "sit", 0.0)
    assert client.post("/api/v1/console/posture", json={"posture": "standard"}).status_code == 202
    for _ in range(600):
        loop.tick()
    snapshot = client.get("/api/v1/console").json()
    assert (snapshot["mode"], snapshot["posture"]) == ("stand", "standard")


NOT_POSTURES = [
    {},
    {"posture": "lie"},
    {"posture": 1},
    {"posture": None},
    {"posture": "sit", "speed": 1.0},
    {"posture": ["sit"]},
]


@pytest.mark.parametrize("body", NOT_POSTURES)
def test_a_posture_that_is_none_is_refused_by_name(
    client: TestClient, body: dict[str, Any]
) -> None:
    told = problem_of(client.post("/api/v1/console/posture", json=body), 422)
    assert told["field"] == ("speed" if "speed" in body else "posture")


def test_a_push_moves_the_body_in_the_ticks_that_follow(
    client: TestClient, loop: RealtimeLoop
) -> None:
    body = {"fx_n": 0.0, "fy_n": 3000.0, "duration_s": 1.2}
    answer = client.post("/api/v1/console/push", json=body)
    assert answer.status_code == 202 and answer.json()["ticks"] == 60
    for _ in range(200):
        loop.tick()
    assert client.get("/api/v1/console").json()["mode"] == "fallen"


@pytest.mark.parametrize(
    "body", [{"fx_n": 1.0}, {"fx_n": 1.0, "fy_n": 1e6}, {"fx_n": 0, "fy_n": 0, "duration_s": 0.001}]
)
def test_a_push_beyond_all_measure_is_refused(client: TestClient, body: dict[str, Any]) -> None:
    problem_of(client.post("/api/v1/console/push", json=body), 422)


def test_no_posture_through_a_stop(client: TestClient, loop: RealtimeLoop) -> None:
    client.post("/api/v1/console/stop")
    assert (
        "stopped"
        in problem_of(client.post("/api/v1/console/posture", json={"posture": "sit"}), 409)[
            "detail"
        ]
    )


def test_a_machine_that_has_fallen_takes_no_posture(client: TestClient, loop: RealtimeLoop) -> None:
    loop.request(Push(0.0, 3000.0, 60))
    for _ in range(200):
        loop.tick()
    assert (
        "fallen"
        in problem_of(client.post("/api/v1/console/posture", json={"posture": "stand"}), 409)[
            "detail"
        ]
    )


def test_the_body_follows_the_ground_from_the_next_tick_on(
    client: TestClient, loop: RealtimeLoop
) -> None:
    assert client.get("/api/v1/console").json()["attitude"] == "level"
    for attitude in ("ground", "level"):
        answer = client.put("/api/v1/console/attitude", json={"attitude": attitude})
        assert answer.status_code == 202 and answer.json()["attitude"] == attitude
        loop.tick()
        assert client.get("/api/v1/console").json()["attitude"] == attitude


def test_a_planner_that_walks_level_is_not_told_to_lean(
    client: TestClient, loop: RealtimeLoop
) -> None:
    loop.load(prepare(scenario_from({"name": "printed", "mode": "paper"})))
    loop.tick()
    assert (
        "predictive"
        in problem_of(client.put("/api/v1/console/attitude", json={"attitude": "ground"}), 409)[
            "detail"
        ]
    )
    assert client.put("/api/v1/console/attitude", json={"attitude": "level"}).status_code == 202
    assert (
        problem_of(client.put("/api/v1/console/attitude", json={"attitude": "askew"}), 422)["field"]
        == "attitude"
    )


def test_a_stop_stays_until_it_is_ended(client: TestClient, loop: RealtimeLoop) -> None:
    client.put("/api/v1/console/command", json=COMMAND)
    client.post("/api/v1/console/stop")
    loop.tick()
    snapshot = client.get("/api/v1/console").json()
    assert snapshot["stopped"] and snapshot["speed_m_s"] == 0.0
    assert (
        "stopped" in problem_of(client.put("/api/v1/console/command", json=COMMAND), 409)["detail"]
    )
    client.post("/api/v1/console/reset")
    assert client.get("/api/v1/console").json()["stopped"], "a reset does not end a stop"
    assert "at rest" in problem_of(client.post("/api/v1/console/rearm"), 409)["detail"]
    rest = {**COMMAND, "speed_m_s": 0.0, "turn_rate_rad_s": 0.0}
    assert client.put("/api/v1/console/command", json=rest).status_code == 202
    assert client.post("/api/v1/console/rearm").status_code == 200
    assert client.put("/api/v1/console/command", json=COMMAND).status_code == 202


def test_advance_needs_the_paused_state_and_walks_exactly_so_many_ticks(client: TestClient) -> None:
    assert (
        "paused"
        in problem_of(client.post("/api/v1/console/advance", json={"ticks": 10}), 409)["detail"]
    )
    before = client.post("/api/v1/console/pause").json()
    assert before["paused"]
    after = client.post("/api/v1/console/advance", json={"ticks": 250}).json()
    assert after["tick"] == before["tick"] + 250
    assert client.post("/api/v1/console/reset").json()["tick"] == 0
    assert not client.post("/api/v1/console/resume").json()["paused"]


def test_a_script_that_drives_while_paused_walks_the_same_way_every_time(
    client: TestClient,
) -> None:
    def walked() -> list[float]:
        client.post("/api/v1/console/reset")
        for _ in range(6):
            client.put("/api/v1/console/command", json={**COMMAND, "ttl_s": 1.0})
            client.post("/api/v1/console/advance", json={"ticks": 50})
        body: list[float] = client.get("/api/v1/console").json()["body"]
        return body

    client.post("/api/v1/console/pause")
    first = walked()
    assert first[0] > 0.3
    assert walked() == first


def test_the_rate_changes_and_shows(client: TestClient, loop: RealtimeLoop) -> None:
    assert client.post("/api/v1/console/rate", json={"rate": 4}).json() == {"rate": 4}
    loop.tick()
    assert client.get("/api/v1/console").json()["rate"] == 4.0


def test_a_timeline_is_played_on_at_another_rate_and_after_a_pause(
    client: TestClient, loop: RealtimeLoop
) -> None:
    loop.play()
    loop.tick()
    client.post("/api/v1/console/rate", json={"rate": 4.0}).raise_for_status()
    loop.tick()
    for switch in ("pause", "resume"):
        client.post(f"/api/v1/console/{switch}").raise_for_status()
        loop.tick()
    for _ in range(20):
        loop.tick()
    played = client.get("/api/v1/console").json()
    assert played["playing"] and played["rate"] == 4.0 and played["distance_m"] > 0.0
    client.put("/api/v1/console/command", json=COMMAND).raise_for_status()
    loop.tick()
    assert not client.get("/api/v1/console").json()["playing"]


def test_the_world_last_loaded_is_kept_for_a_restart(client: TestClient, tmp_path: Path) -> None:
    client.put("/api/v1/console/scenario", json={"name": "stairs-up"})
    disk = client.app.state.console.kept_world._disk  # type: ignore[attr-defined]
    assert disk.write(lambda: None, "").wait(10.0)
    world = KeptWorld(tmp_path / WORLD).made(Uploads(tmp_path))
    assert world is not None and world.scenario.name == "stairs-up"


def test_a_scenario_is_loaded_by_name_and_inline(client: TestClient) -> None:
    assert (
        client.put("/api/v1/console/scenario", json={"name": "river"}).json()["scenario"] == "river"
    )
    inline = {"title": "a ditch", "terrain": {"kind": "gap"}}
    snapshot = client.put(
        "/api/v1/console/scenario", json={"scenario": inline, "robot": "titan3"}
    ).json()
    assert snapshot["scenario"] == "inline" and snapshot["tick"] <= 2


def test_a_scenario_is_loaded_with_another_mode(client: TestClient) -> None:
    assert (
        client.put("/api/v1/console/scenario", json={"name": "flat", "mode": "paper"}).json()[
            "planner_mode"
        ]
        == "paper"
    )
    assert (
        client.put("/api/v1/console/scenario", json={"name": "flat", "mode": "bold"}).status_code
        == 422
    )


def test_a_scenario_is_loaded_on_rigid_bodies_and_with_its_body_straight(
    client: TestClient,
) -> None:
    pytest.importorskip("mujoco")
    body = {"name": "flat", "plant": "physics", "body_way": "straight"}
    snapshot = client.put("/api/v1/console/scenario", json=body).json()
    assert (snapshot["plant"], snapshot["body_way"]) == ("physics", "straight")
    inline = {"terrain": {"kind": "flat"}, "gait": {"margin": 0.03}, "plant": "physics"}
    body = {"scenario": inline, "plant": "kinematic", "body_way": "sway"}
    snapshot = client.put("/api/v1/console/scenario", json=body).json()
    assert (snapshot["plant"], snapshot["body_way"]) == ("kinematic", "sway")
    for wrong in ({"plant": "wheels"}, {"body_way": "bent"}):
        answer = client.put("/api/v1/console/scenario", json={"name": "flat", **wrong})
        assert answer.status_code == 422
        assert answer.json()["errors"][0]["field"] == next(iter(wrong))


REFUSED: list[tuple[str, str, Any, str]] = [
    ("PUT", "command", {**COMMAND, "speed_m_s": 9.0}, "speed_m_s"),
    ("PUT", "command", {**COMMAND, "speed_m_s": -0.1}, "speed_m_s"),
    ("PUT", "command", {**COMMAND, "speed_m_s": True}, "speed_m_s"),
    ("PUT", "command", {**COMMAND, "speed_m_s": "0.1"}, "speed_m_s"),
    ("PUT", "command", {**COMMAND, "speed_m_s": None}, "speed_m_s"),
    ("PUT", "command", {**COMMAND, "crab_angle_rad": 4.0}, "crab_angle_rad"),
    ("PUT", "command", {**COMMAND, "turn_rate_rad_s": -2.0}, "turn_rate_rad_s"),
    ("PUT", "command", {**COMMAND, "ttl_s": 1.5}, "ttl_s"),
    ("PUT", "command", {**COMMAND, "ttl_s": 0.0}, "ttl_s"),
    ("PUT", "command", {"speed_m_s": 0.1}, "ttl_s"),
    ("PUT", "command", {**COMMAND, "speed": 0.1}, "speed"),
    ("PUT", "command", [], "body"),
    ("POST", "advance", {"ticks": 0}, "ticks"),
    ("POST", "advance", {"ticks": 1.5}, "ticks"),
    ("POST", "advance", {"ticks": True}, "ticks"),
    ("POST", "advance", {"ticks": 10**9}, "ticks"),
    ("POST", "rate", {"rate": 9}, "rate"),
    ("POST", "rate", {"rate": 0}, "rate"),
    ("PUT", "scenario", {"name": "rivr"}, "name"),
    ("PUT", "scenario", {"name": "../../etc/passwd"}, "name"),
    ("PUT", "scenario", {"name": "flat", "scenario": {}}, "body"),
    ("PUT", "scenario", {}, "body"),
    ("PUT", "scenario", {"name": "flat", "robot": "titan9"}, "robot"),
    ("PUT", "scenario", {"scenario": {"robot": "/etc/passwd.toml"}}, "scenario"),
    ("PUT", "scenario", {"scenario": {"terrain": {"file": "/etc/passwd"}}}, "scenario"),
    ("PUT", "scenario", {"scenario": {"terrain": {"kind": "moon"}}}, "scenario"),
    ("PATCH", "terrain", {"action": "dig"}, "body"),
    ("PATCH", "terrain", {"action": "paint", "cells": [[1, 1]]}, "action"),
    ("PATCH", "terrain", {"action": "raise", "cells": [[1, 1]]}, "body"),
    ("PATCH", "terrain", {"action": "raise", "cells": [[1, 1]], "amount_m": 5.0}, "amount_m"),
    ("PATCH", "terrain", {"action": "dig", "cells": [[1, 99999]]}, "cells"),
    ("PATCH", "terrain", {"action": "dig", "cells": [[-1, 0]]}, "cells.0.0"),
    (
        "PATCH",
        "terrain",
        {"action": "dig", "circle": {"x_m": 0.0, "y_m": 0.0, "radius_m": 100.0}},
        "circle.radius_m",
    ),
    (
        "PATCH",
        "terrain",
        {"action": "dig", "circle": {"x_m": 5000.0, "y_m": 0.0, "radius_m": 1.0}},
        "circle",
    ),
]


@pytest.mark.parametrize(
    ("method", "route", "body", "field"), REFUSED, ids=lambda value: json.dumps(value)[:60]
)
def test_a_bad_body_is_refused_by_field_value_and_limit(
    client: TestClient, loop: RealtimeLoop, method: str, route: str, body: Any, field: str
) -> None:
    problem = problem_of(client.request(method, f"/api/v1/console/{route}", json=body), 422)
    assert problem["field"] == field
    assert problem["errors"][0]["message"]
    loop.tick()
    assert loop.newest.command.holds


@pytest.mark.parametrize(
    "word", ["NaN", "Infinity", "-Infinity", "1e400", "true", '"0.1"', "null", "[0.1]", "1" * 400]
)
def test_no_word_that_is_not_a_number_in_range_passes_for_a_speed(
    client: TestClient, word: str
) -> None:
    text = f'{{"crab_angle_rad": 0.0, "speed_m_s": {word}, "turn_rate_rad_s": 0.0, "ttl_s": 0.5}}'
    problem_of(
        client.put(
            "/api/v1/console/command", content=text, headers={"content-type": "application/json"}
        ),
        422,
    )


def test_a_way_is_answered_before_anything_goes(client: TestClient, loop: RealtimeLoop) -> None:
    before = loop.newest.body
    answer = client.post("/api/v1/console/route", json={"x_m": 0.6, "y_m": 0.0}).json()
    assert answer["reachable"] and answer["steps"] > 1 and answer["time_s"] > 3.0
    loop.tick()
    assert loop.newest.body == before
    problem_of(client.post("/api/v1/console/route", json={"x_m": 0.6}), 422)


def test_no_way_is_planned_for_what_sits(client: TestClient, loop: RealtimeLoop) -> None:
    client.post("/api/v1/console/posture", json={"posture": "sit"})
    for _ in range(20):
        loop.tick()
    answer = client.post("/api/v1/console/route", json={"x_m": 0.6, "y_m": 0.0})
    assert "feet" in problem_of(answer, 409)["detail"]
