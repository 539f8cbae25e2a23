"""Behind a proxy that shows the console below a path."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import urljoin

import pytest
from fastapi.testclient import TestClient
from starlette.types import ASGIApp, Receive, Scope, Send

from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.path_prefix import forwarded_prefix, placed_under
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.viser_bridge import ViserBridge

SITE = "http://127.0.0.1:8812"
PAGE = Path(__file__).parents[2] / "web" / "page"
HERE = ("127.0.0.1", 50000)
PREFIX = "/user/x/proxy/8000"


class PrefixProxy:
    """A proxy that shows an app below a path and nothing beside it, as nginx with
    ``location PREFIX/ { proxy_pass http://127.0.0.1:8811/; }``, or passing whole paths on.
    """

    def __init__(self, app: ASGIApp, takes_off: bool) -> None:
        self.app = app
        self.takes_off = takes_off

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] in ("http", "websocket"):
            assert scope["path"].startswith(PREFIX), f"{scope['path']} leads out of {PREFIX}"
            if self.takes_off:
                scope = {**scope, "path": scope["path"].removeprefix(PREFIX)}
        await self.app(scope, receive, send)


@pytest.fixture(params=["taken off by the proxy", "told by --root-path", "told by the proxy"])
def proxied(
    request: pytest.FixtureRequest, loop: RealtimeLoop, bridge: ViserBridge, tmp_path: Path
) -> TestClient:
    """A browser that sees the console through a proxy only."""
    root_path = PREFIX if request.param == "told by --root-path" else ""
    headers = {"x-forwarded-prefix": PREFIX} if request.param == "told by the proxy" else {}
    app = create_app(loop, AppSettings(data=tmp_path, root_path=root_path), bridge)
    proxy = PrefixProxy(app, takes_off=request.param == "taken off by the proxy")
    return TestClient(proxy, base_url=SITE, client=HERE, headers=headers, follow_redirects=False)


def test_the_page_and_all_it_names_are_there_below_the_path(proxied: TestClient) -> None:
    for page in ("/", "/docs"):
        address = f"{SITE}{PREFIX}{page}"
        answer = proxied.get(address)
        assert answer.status_code == 200
        named = re.findall(r'(?:href|src)="([^"#]+)"', answer.text)
        assert len(named) >= 3
        for name in named:
            assert proxied.get(urljoin(address, name)).status_code == 200, name


def test_the_description_of_the_interface_leads_to_it(proxied: TestClient) -> None:
    address = f"{SITE}{PREFIX}/openapi.json"
    assert 'url: "openapi.json"' in proxied.get(f"{SITE}{PREFIX}/docs/start.js").text
    server = proxied.get(address).json()["servers"][0]["url"]
    health = urljoin(address, f"{server}/api/v1/health")
    assert health == f"{SITE}{PREFIX}/api/v1/health"
    assert proxied.get(health).status_code == 200


def test_it_connects_and_drives(proxied: TestClient) -> None:
    with proxied.websocket_connect(f"ws://127.0.0.1:8812{PREFIX}/drive", headers={"origin": SITE}):
        stop = proxied.post(f"{SITE}{PREFIX}/api/v1/console/stop", headers={"origin": SITE})
    assert stop.status_code == 200


def test_the_canvas_is_led_to_a_clean_address_below_the_path(proxied: TestClient) -> None:
    for path in ("/view/", "/view"):
        address = f"{SITE}{PREFIX}{path}?websocket=ws://evil.example"
        answer = proxied.get(address)
        assert answer.status_code == 307
        assert urljoin(address, answer.headers["location"]) == f"{SITE}{PREFIX}/view/"


def test_no_file_of_the_page_names_an_absolute_path() -> None:
    for path in sorted((*PAGE.glob("*.js"), *PAGE.glob("*.html"), *PAGE.glob("*.css"))):
        absolute = re.findall(r"""(?:["'`(])/(?!/)[a-z][^"'`)\s]*""", path.read_text("utf-8"))
        assert not absolute, (path.name, absolute)


def test_without_its_slash_the_path_is_led_to_the_page(loop: RealtimeLoop, tmp_path: Path) -> None:
    app = create_app(loop, AppSettings(data=tmp_path, root_path="/lab/console"))
    client = TestClient(app, base_url=SITE, follow_redirects=False)
    answer = client.get("/lab/console")
    assert urljoin(f"{SITE}/lab/console", answer.headers["location"]) == f"{SITE}/lab/console/"
    assert client.get("/").status_code == 200, "the printed address still works"


def test_the_token_is_kept_for_the_path_alone(loop: RealtimeLoop, tmp_path: Path) -> None:
    token = "k" * 40
    app = create_app(loop, AppSettings(data=tmp_path, token=token))
    proxy = PrefixProxy(app, takes_off=True)
    client = TestClient(proxy, base_url=SITE, follow_redirects=False)
    answer = client.get(f"{PREFIX}/login", params={"token": token})
    assert answer.headers["location"] == "./" and "path" not in answer.headers["set-cookie"].lower()
    assert client.get(f"{PREFIX}/api/v1/health").status_code == 200


@pytest.mark.parametrize(
    ("peer", "given", "believed"),
    [
        ("127.0.0.1", "/console", "/console"),
        ("::1", "/a/b/", "/a/b"),
        ("192.168.1.7", "/console", ""),
        ("testclient", "/console", ""),
        ("127.0.0.1", "//evil.example", ""),
        ("127.0.0.1", "/a/../b", ""),
        ("127.0.0.1", "console", ""),
    ],
)
def test_only_a_proxy_on_this_computer_is_believed(peer: str, given: str, believed: str) -> None:
    headers = [(b"x-forwarded-prefix", given.encode())]
    scope = {"type": "http", "path": "/", "client": (peer, 1), "headers": headers}
    assert forwarded_prefix(scope) == believed


def test_a_path_is_placed_under_its_prefix_once() -> None:
    for path in ("/drive", "/a/drive"):
        assert placed_under({"path": path}, "/a") == {"path": "/a/drive", "root_path": "/a"}
    assert placed_under({"path": "/a"}, "/b")["path"] == "/b/a"
