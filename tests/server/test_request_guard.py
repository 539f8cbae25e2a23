"""What every request must show before a route sees it."""

import socket
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from starlette.testclient import WebSocketDenialResponse

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.launch import app_settings
from walking_console.server.limits import BODY_MAX
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.serve_options import ServeOptions

HERE = "http://127.0.0.1:8000"


def test_a_body_beyond_its_limit_is_refused_declared_or_not(client: TestClient) -> None:
    problem_of(client.put("/api/v1/console/command", content=b" " * (BODY_MAX + 1)), 413)

    def endless() -> Any:
        for _ in range(40):
            yield b" " * 65536

    problem_of(client.put("/api/v1/console/command", content=endless()), 413)


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


@pytest.mark.parametrize(
    "body", [b'{"scenario": ' + b"[" * 50_000, b'{"x": ' + b"1" * 50_000 + b"}"]
)
def test_json_that_no_reader_should_bear_is_refused_before_it_is_read(
    client: TestClient, body: bytes
) -> None:
    kind = {"content-type": "application/json"}
    for method, path in (("PUT", "console/scenario"), ("PUT", "console/command"), ("POST", "runs")):
        problem_of(client.request(method, f"/api/v1/{path}", content=body, headers=kind), 422)


@pytest.mark.parametrize("path", ["/api/v1/runs", "/api/v1/runs/flat-0001/replay.html"])
def test_no_foreign_page_makes_the_interface_work_for_it(client: TestClient, path: str) -> None:
    for site in ("cross-site", "same-site"):
        problem_of(client.get(path, headers={"sec-fetch-site": site}), 403)
    problem_of(client.get(path, headers={"origin": "http://evil.example"}), 403)


def test_a_person_may_follow_a_link_to_the_interface_and_to_the_page(client: TestClient) -> None:
    followed = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    clicked = {**followed, "sec-fetch-user": "?1"}
    assert client.get("/api/v1/runs", headers=clicked).status_code == 200
    assert client.get("/", headers=followed).status_code == 200


def test_our_own_page_may(client: TestClient) -> None:
    assert client.post("/api/v1/console/stop", headers={"origin": HERE}).status_code == 200


def test_no_get_changes_anything(client: TestClient) -> None:
    for path, entry in client.get("/openapi.json").json()["paths"].items():
        assert "get" not in entry or not path.endswith(
            ("stop", "reset", "pause", "resume", "advance", "rate", "rearm", "command")
        )


AT = "ws://127.0.0.1:8000"  # the test client ignores its base URL for WebSockets


@pytest.mark.parametrize("path", ["/drive", "/view", "/view/"])
@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9", "https://127.0.0.1:8000.evil"]
)
def test_no_foreign_page_opens_a_socket(client: TestClient, path: str, origin: str) -> None:
    with (
        pytest.raises(WebSocketDenialResponse) as caught,
        client.websocket_connect(AT + path, headers={"origin": origin}),
    ):
        pass
    assert caught.value.status_code == 403


@pytest.mark.parametrize("path", ["/drive", "/view"])
def test_no_foreign_host_opens_a_socket(client: TestClient, path: str) -> None:
    headers = {"origin": "http://evil.example"}
    with (
        pytest.raises(WebSocketDenialResponse) as caught,
        client.websocket_connect(f"ws://evil.example{path}", headers=headers),
    ):
        pass
    assert caught.value.status_code == 403


def test_a_request_for_two_hosts_is_refused(client: TestClient) -> None:
    headers = [("host", "127.0.0.1"), ("host", "evil.example")]
    problem_of(client.get("/api/v1/health", headers=headers), 403)


TOKEN = "k" * 40


@pytest.fixture
def named(loop: RealtimeLoop, tmp_path: Path) -> TestClient:
    """A console beyond loopback that also answers for two names of proxies."""
    names = ("labserver.example.edu", "pi.example.edu:8443")
    options = ServeOptions(host="0.0.0.0", token=TOKEN, allow_host=names, data=tmp_path)
    headers = {"authorization": f"Bearer {TOKEN}"}
    return TestClient(create_app(loop, app_settings(options)), base_url=HERE, headers=headers)


def test_names_that_were_allowed_and_those_of_this_computer_are_let_in(named: TestClient) -> None:
    own = socket.gethostname()
    for host in (
        own,
        f"{own.split('.')[0]}.local:8000",
        "labserver.example.edu",
        "LabServer.Example.edu:8000",
        "labserver.example.edu.",
        "pi.example.edu",
        "192.168.1.5:8000",
    ):
        assert named.get("/api/v1/health", headers={"host": host}).status_code == 200, host


@pytest.mark.parametrize(
    "host",
    ["other.example.edu", "x.labserver.example.edu", "labserver.example.edu.evil", "a.local"],
)
def test_names_that_nobody_allowed_stay_out(named: TestClient, host: str) -> None:
    problem_of(named.get("/api/v1/health", headers={"host": host}), 403)


@pytest.mark.parametrize(
    ("host", "origin", "status"),
    [
        ("labserver.example.edu", "https://labserver.example.edu", 200),  # Host kept
        ("127.0.0.1:8811", "https://labserver.example.edu", 200),  # Host written anew
        ("127.0.0.1:8811", "https://pi.example.edu:8443", 200),
        ("127.0.0.1:8811", "https://pi.example.edu", 403),
        ("127.0.0.1:8811", "https://labserver.example.edu:9999", 403),
        ("127.0.0.1:8811", "https://labserver.example.edu.evil", 403),
        ("labserver.example.edu", "https://evil.example", 403),
    ],
)
def test_a_tls_proxy_s_page_may_whether_it_keeps_the_host_or_not(
    named: TestClient, host: str, origin: str, status: int
) -> None:
    headers = {"host": host, "origin": origin}
    assert named.post("/api/v1/console/stop", headers=headers).status_code == status
