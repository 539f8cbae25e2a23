"""HTTP in process: what is answered, what is refused and how the refusal reads."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from walking_console.server import explanation_frames, frames, schemas
from walking_console.server.api.app import Settings, create_app
from walking_console.server.realtime_loop import WalkingClock
from walking_console.server.request_guard import BODY_MAX
from walking_console.sim.requests import Push
from walking_console.sim.scenario import scenario_from
from walking_console.sim.world import prepare

HERE = "http://127.0.0.1:8000"
COMMAND = {"crab_angle_rad": 0.0, "speed_m_s": 0.08, "turn_rate_rad_s": 0.0, "ttl_s": 0.5}


def problem_of(response: Any, status: int) -> dict[str, Any]:
    """The refusal, checked to be one as promised."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    body: dict[str, Any] = response.json()
    assert body["status"] == status and body["detail"] and body["title"]
    return body


# what is answered


def test_health_says_version_uptime_and_lateness(client: TestClient) -> None:
    health = client.get("/api/v1/health").json()
    assert (
        health["ok"]
        and health["uptime_s"] >= 0
        and set(health["tick_late_s"]) == {"last_second", "worst"}
    )


@pytest.mark.parametrize(
    ("route", "name"), [("robots", "titan3"), ("terrains", "river"), ("scenarios", "dem")]
)
def test_lists_name_what_there_is_with_a_title(client: TestClient, route: str, name: str) -> None:
    entries = {entry["name"]: entry["title"] for entry in client.get(f"/api/v1/{route}").json()}
    assert entries[name]


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
    client: TestClient, clock: WalkingClock
) -> None:
    assert client.put("/api/v1/console/command", json=COMMAND).status_code == 202
    clock.beat()
    assert client.get("/api/v1/console").json()["speed_m_s"] == 0.08
    for _ in range(25):
        clock.beat()
    assert client.get("/api/v1/console").json()["speed_m_s"] == 0.0


def test_a_posture_is_taken_from_a_standstill_and_shown(
    client: TestClient, clock: WalkingClock
) -> None:
    client.put("/api/v1/console/command", json=COMMAND)
    clock.beat()
    answer = client.post("/api/v1/console/posture", json={"posture": "sit"})
    assert answer.status_code == 202 and answer.json()["posture"] == "sit"
    seen = set()
    for _ in range(150):
        clock.beat()
        seen.add(client.get("/api/v1/console").json()["mode"])
    assert "sit_down" in seen
    snapshot = client.get("/api/v1/console").json()
    assert (snapshot["mode"], snapshot["posture"], snapshot["speed_m_s"]) == ("sit", "sit", 0.0)
    assert client.post("/api/v1/console/posture", json={"posture": "standard"}).status_code == 202
    for _ in range(600):
        clock.beat()
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


def test_no_posture_through_a_stop(client: TestClient, clock: WalkingClock) -> None:
    client.post("/api/v1/console/stop")
    assert (
        "stopped"
        in problem_of(client.post("/api/v1/console/posture", json={"posture": "sit"}), 409)[
            "detail"
        ]
    )


def test_a_machine_that_has_fallen_takes_no_posture(
    client: TestClient, clock: WalkingClock
) -> None:
    clock.request(Push(0.0, 3000.0, 60))
    for _ in range(200):
        clock.beat()
    assert (
        "fallen"
        in problem_of(client.post("/api/v1/console/posture", json={"posture": "stand"}), 409)[
            "detail"
        ]
    )


def test_the_body_follows_the_ground_from_the_next_tick_on(
    client: TestClient, clock: WalkingClock
) -> None:
    assert client.get("/api/v1/console").json()["attitude"] == "level"
    for attitude in ("ground", "level"):
        answer = client.put("/api/v1/console/attitude", json={"attitude": attitude})
        assert answer.status_code == 202 and answer.json()["attitude"] == attitude
        clock.beat()
        assert client.get("/api/v1/console").json()["attitude"] == attitude


def test_a_planner_that_walks_level_is_not_told_to_lean(
    client: TestClient, clock: WalkingClock
) -> None:
    clock.load(prepare(scenario_from({"name": "printed", "mode": "paper"})))
    clock.beat()
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


def test_a_stop_stays_until_it_is_ended(client: TestClient, clock: WalkingClock) -> None:
    client.put("/api/v1/console/command", json=COMMAND)
    client.post("/api/v1/console/stop")
    clock.beat()
    snapshot = client.get("/api/v1/console").json()
    assert snapshot["stopped"] and snapshot["speed_m_s"] == 0.0
    assert (
        "stopped" in problem_of(client.put("/api/v1/console/command", json=COMMAND), 409)["detail"]
    )
    client.post("/api/v1/console/reset")
    assert client.get("/api/v1/console").json()["stopped"], "a reset does not end a stop"
    client.post("/api/v1/console/rearm")
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


def test_the_rate_changes_and_shows(client: TestClient, clock: WalkingClock) -> None:
    assert client.post("/api/v1/console/rate", json={"rate": 4}).json() == {"rate": 4}
    clock.beat()
    assert client.get("/api/v1/console").json()["rate"] == 4.0


def test_a_scenario_is_loaded_by_name_and_inline(client: TestClient) -> None:
    assert (
        client.put("/api/v1/console/scenario", json={"name": "river"}).json()["scenario"] == "river"
    )
    inline = {"title": "a ditch", "terrain": {"kind": "gap"}}
    snapshot = client.put(
        "/api/v1/console/scenario", json={"scenario": inline, "robot": "titan3"}
    ).json()
    assert snapshot["scenario"] == "inline" and snapshot["tick"] <= 2


@pytest.mark.parametrize(
    ("place", "cells"),
    [
        ({"circle": {"x_m": 2.0, "y_m": 1.0, "radius_m": 0.3}}, None),
        ({"cells": [[5, 7], [6, 7]]}, 2),
    ],
)
def test_ground_is_dug_under_a_circle_and_by_cells(
    client: TestClient, clock: WalkingClock, place: dict[str, Any], cells: int | None
) -> None:
    before = np.isnan(clock.newest.terrain.heights).sum()
    answer = client.patch("/api/v1/console/terrain", json={"action": "dig", **place}).json()
    clock.beat()
    assert (
        np.isnan(clock.newest.terrain.heights).sum() - before
        == answer["cells"]
        == (cells or answer["cells"])
    )


def test_ground_is_raised_forbidden_and_cleared(client: TestClient, clock: WalkingClock) -> None:
    square = {"rectangle": {"x_m": 2.0, "y_m": 1.0, "width_m": 0.4, "depth_m": 0.4}}
    client.patch("/api/v1/console/terrain", json={"action": "raise", "amount_m": 0.1, **square})
    clock.beat()
    terrain = clock.newest.terrain
    assert np.nanmax(terrain.heights) == pytest.approx(0.1)
    client.patch("/api/v1/console/terrain", json={"action": "forbid", **square})
    clock.beat()
    marked = int(clock.newest.terrain.forbidden.sum())
    client.patch("/api/v1/console/terrain", json={"action": "clear", **square})
    clock.beat()
    assert int(clock.newest.terrain.forbidden.sum()) < marked


# what is refused

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
    ("PUT", "scenario", {"name": "flat", "robot": "titan9"}, "name"),
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
    client: TestClient, clock: WalkingClock, method: str, route: str, body: Any, field: str
) -> None:
    problem = problem_of(client.request(method, f"/api/v1/console/{route}", json=body), 422)
    assert problem["field"] == field
    assert problem["errors"][0]["message"]
    clock.beat()
    assert clock.newest.command.holds


def test_a_refusal_says_the_value_and_the_limit(client: TestClient) -> None:
    problem = problem_of(client.put("/api/v1/console/command", json={**COMMAND, "ttl_s": 7.5}), 422)
    assert (problem["value"], problem["limit"]) == (7.5, {"le": 1.0})


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


@pytest.mark.parametrize("text", ["{", "", "\x00", "[" * 100_000, '{"a":' * 50_000, "nonsense"])
def test_what_is_no_json_is_refused(client: TestClient, text: str) -> None:
    response = client.put(
        "/api/v1/console/command", content=text, headers={"content-type": "application/json"}
    )
    assert response.status_code in (400, 422)
    problem_of(response, response.status_code)


def test_a_body_beyond_its_limit_is_refused_declared_or_not(client: TestClient) -> None:
    problem_of(client.put("/api/v1/console/command", content=b" " * (BODY_MAX + 1)), 413)

    def endless() -> Any:
        for _ in range(40):
            yield b" " * 65536

    problem_of(client.put("/api/v1/console/command", content=endless()), 413)


NOWHERE = [
    "/nothing",
    "/api/v1/nothing",
    "/server/app.py",
    "/scene.py",
    "/../server/app.py",
    "/%2e%2e/app.py",
    "/vendor/..%2fscene.py",
]


@pytest.mark.parametrize("path", NOWHERE)
def test_what_there_is_not_is_404(client: TestClient, path: str) -> None:
    problem_of(client.get(path), 404)


def test_a_wrong_method_is_405(client: TestClient) -> None:
    problem_of(client.delete("/api/v1/console/stop"), 405)


# the door


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1.evil.example",
        "localhost.evil",
        "8.8.8.8",
        "",
        "127.0.0.1@evil",
        "[::1",
    ],
)
def test_a_foreign_host_is_refused(client: TestClient, host: str) -> None:
    problem_of(client.get("/api/v1/health", headers={"host": host}), 403)


@pytest.mark.parametrize(
    "host", ["localhost", "localhost:8000", "127.0.0.1:1234", "[::1]:8000", "LOCALHOST"]
)
def test_a_loopback_host_is_let_in(client: TestClient, host: str) -> None:
    assert client.get("/api/v1/health", headers={"host": host}).status_code == 200


FOREIGN = [
    "http://evil.example",
    "null",
    "http://127.0.0.1:8001",
    "http://127.0.0.1",
    "http://127.0.0.1:8000.evil",
    "http://localhost:8000",
]


@pytest.mark.parametrize("origin", FOREIGN)
def test_no_foreign_page_changes_anything(client: TestClient, origin: str) -> None:
    paths = client.get("/openapi.json").json()["paths"]
    unsafe = [
        (method.upper(), path)
        for path, entry in paths.items()
        for method in entry
        if method != "get"
    ]
    assert len(unsafe) >= 11
    for method, path in unsafe:
        problem_of(
            client.request(
                method, path.replace("{run_id}", "flat-0001"), headers={"origin": origin}
            ),
            403,
        )


@pytest.mark.parametrize(
    ("site", "status"),
    [("cross-site", 403), ("same-site", 403), ("same-origin", 200), ("none", 200)],
)
def test_without_an_origin_the_browser_s_own_word_counts(
    client: TestClient, site: str, status: int
) -> None:
    assert (
        client.post("/api/v1/console/stop", headers={"sec-fetch-site": site}).status_code == status
    )


def test_our_own_page_may(client: TestClient) -> None:
    assert client.post("/api/v1/console/stop", headers={"origin": HERE}).status_code == 200


def test_no_get_changes_anything(client: TestClient) -> None:
    for path, entry in client.get("/openapi.json").json()["paths"].items():
        assert "get" not in entry or not path.endswith(
            ("stop", "reset", "pause", "resume", "advance", "rate", "rearm", "command")
        )


def test_with_a_token_everything_asks_for_it(clock: WalkingClock, tmp_path: Path) -> None:
    token = "k" * 40
    with TestClient(
        create_app(clock, Settings(data=tmp_path, token=token)),
        base_url=HERE,
        follow_redirects=False,
    ) as client:
        problem_of(client.get("/api/v1/health"), 401)
        problem_of(client.get("/login", params={"token": "k" * 39}), 401)
        assert (
            client.get("/api/v1/health", headers={"authorization": f"Bearer {token}"}).status_code
            == 200
        )
        answer = client.get("/login", params={"token": token})
        assert answer.status_code == 303 and "httponly" in answer.headers["set-cookie"].lower()
        assert client.get("/api/v1/health").status_code == 200, "the cookie now speaks for the page"


# documents and pages


def test_every_body_and_frame_has_an_example(client: TestClient) -> None:
    schema = client.get("/openapi.json").json()
    for name, shape in schema["components"]["schemas"].items():
        if not name.startswith(("HTTPValidation", "ValidationError")):
            assert shape.get("examples"), name
    assert set(schema["x-websockets"]["/drive"]) == {"client-to-server", "server-to-client"}


def test_every_example_is_accepted_by_its_own_shape(client: TestClient) -> None:
    for name, shape in client.get("/openapi.json").json()["components"]["schemas"].items():
        model = next(
            (getattr(m, name) for m in (schemas, frames, explanation_frames) if hasattr(m, name)),
            None,
        )
        for example in shape.get("examples", ()):
            assert model is not None and model.model_validate(example)


@pytest.mark.parametrize(
    "path",
    [
        "/docs",
        "/docs/start.js",
        "/vendor/swagger/swagger-ui-bundle.js",
        "/vendor/swagger/swagger-ui.css",
    ],
)
def test_the_documents_come_from_here(client: TestClient, path: str) -> None:
    response = client.get(path)
    assert response.status_code == 200
    if path == "/docs":
        assert "http" not in response.text.replace("<!doctype", "")
        policy = response.headers["content-security-policy"]
        assert (
            "default-src 'none'" in policy
            and "unsafe-eval" not in policy
            and "script-src 'self';" in policy
        )


def test_every_answer_says_how_it_may_be_used(client: TestClient) -> None:
    headers = client.get("/api/v1/health").headers
    assert headers["x-content-type-options"] == "nosniff" and "content-security-policy" in headers


@pytest.mark.parametrize(
    "trace",
    [
        {"kind": "waypoints", "waypoints": [[0.0, 0.0], [0.0, 0.0]]},
        {"kind": "circle", "angle_deg": 0.0},
        {"kind": "sine", "amplitude": 100.0, "length": 0.1, "distance": 1000.0},
        {"kind": "waypoints", "waypoints": [[-1000.0, 0.0], [1000.0, 0.0]] * 500},
    ],
)
def test_a_trace_that_cannot_be_drawn_is_refused_before_anything_changes(
    client: TestClient, trace: dict[str, Any]
) -> None:
    before = client.get("/api/v1/console").json()
    refusal = problem_of(
        client.put(
            "/api/v1/console/scenario", json={"scenario": {"planner": "trace", "trace": trace}}
        ),
        422,
    )
    assert refusal["detail"].startswith("trace: ")
    assert client.get("/api/v1/console").json()["scenario"] == before["scenario"]


@pytest.mark.parametrize("path", ["a" * 5000 + ".js", "😀" * 80 + ".js"])
def test_a_path_too_long_for_any_file_is_not_found(client: TestClient, path: str) -> None:
    problem_of(client.get(f"/{path}"), 404)
