"""The token's way into a browser."""

from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.limits import GUESSES_MAX
from walking_console.server.realtime_loop import RealtimeLoop

HERE = "http://127.0.0.1:8000"


def test_with_a_token_everything_asks_for_it(loop: RealtimeLoop, tmp_path: Path) -> None:
    token = "k" * 40
    with TestClient(
        create_app(loop, AppSettings(data=tmp_path, token=token)),
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


DRIVER, VIEWER = "d" * 40, "v" * 40


@pytest.fixture
def client(loop: RealtimeLoop, tmp_path: Path) -> TestClient:
    settings = AppSettings(data=tmp_path, token=DRIVER, viewer_token=VIEWER)
    return TestClient(create_app(loop, settings), base_url=HERE, follow_redirects=False)


def test_the_viewer_s_link_watches_and_stops_and_changes_nothing_else(client: TestClient) -> None:
    assert client.get("/login", params={"token": VIEWER}).status_code == 303
    with client:
        assert client.get("/api/v1/console").status_code == 200
        for path, entry in client.get("/openapi.json").json()["paths"].items():
            for method in set(entry) - {"get"} if not path.endswith("/stop") else ():
                asked = client.request(method, path.replace("{run_id}", "a").replace("{name}", "b"))
                assert "watch and stop" in problem_of(asked, 403)["detail"], path
        assert client.post("/api/v1/console/stop").json() == {"stopped": True}


def test_on_the_viewer_s_socket_only_a_stop_is_heard(client: TestClient) -> None:
    headers = {"origin": HERE, "authorization": f"Bearer {VIEWER}"}
    frames = [{"type": "take"}, {"type": "rearm"}, {"type": "release"}, {"type": "stop"}]
    course = {"crab_angle_rad": 0.0, "speed_m_s": 0.1, "turn_rate_rad_s": 0.0}
    drive = {"type": "drive", "seq": 1, "echo_tick": 0, **course}
    with client, client.websocket_connect("ws://127.0.0.1:8000/drive", headers=headers) as socket:
        for frame in (drive, *frames):
            socket.send_json(frame)
        refused: list[str] = []
        stopped = False
        while not stopped or len(refused) < len(frames):
            frame = socket.receive_json()
            stopped = stopped or frame.get("stopped", False)
            refused += [frame["code"]] if frame["type"] == "refused" else []
    assert refused == ["watches"] * len(frames)


def test_wrong_tokens_lock_out_the_guesser_but_never_a_stop(client: TestClient) -> None:
    wrong = {"authorization": "Bearer " + "x" * 40}
    right = {"authorization": f"Bearer {DRIVER}"}
    with client:
        for _ in range(GUESSES_MAX):
            problem_of(client.get("/login", params={"token": "x" * 40}), 401)
        waits = client.get("/api/v1/health", headers=wrong)
        assert problem_of(waits, 429)["status"] == 429 and int(waits.headers["retry-after"]) <= 60
        problem_of(client.get("/login", params={"token": DRIVER}), 429)
        assert client.post("/api/v1/console/stop", headers=right).json() == {"stopped": True}
        problem_of(client.post("/api/v1/console/stop", headers=wrong), 401)
        # it has shown the right one meanwhile
        assert client.get("/api/v1/health", headers=right).status_code == 200


def test_asking_without_a_token_is_no_guess(client: TestClient) -> None:
    for _ in range(3 * GUESSES_MAX):
        problem_of(client.get("/api/v1/health"), 401)
    assert client.get("/login", params={"token": DRIVER}).status_code == 303
