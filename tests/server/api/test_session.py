"""The token's way into a browser."""

from pathlib import Path

from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
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
