"""What a browser loads comes from here, by name, and nothing else does."""

from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.server.viser_bridge import ViserBridge


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


@pytest.mark.parametrize("path", ["a" * 5000 + ".js", "😀" * 80 + ".js"])
def test_a_path_too_long_for_any_file_is_not_found(client: TestClient, path: str) -> None:
    problem_of(client.get(f"/{path}"), 404)


HERE = "http://127.0.0.1:8000"


OWN = {"origin": HERE}


AT = "ws://127.0.0.1:8000"


@pytest.mark.parametrize("path", ["/view", "/view/"])
def test_the_page_is_served_under_a_policy_without_eval(
    viewing: TestClient, bridge: ViserBridge, path: str
) -> None:
    response = viewing.get(path)
    assert response.content == bridge.page
    policy = response.headers["content-security-policy"]
    assert (
        "'unsafe-eval'" not in policy
        and "frame-ancestors 'self'" in policy
        and "default-src 'none'" in policy
    )
    assert "script-src 'self' blob: 'wasm-unsafe-eval' 'nonce-" in policy
    assert viewing.get(path, headers={"if-none-match": response.headers["etag"]}).status_code == 304


def test_the_page_itself_moves_on_without_them(viewing: TestClient) -> None:
    response = viewing.get("/view?websocket=ws://evil.example")
    assert (response.status_code, response.headers["location"]) == (307, "view/")


def test_a_link_out_of_the_page_s_folder_is_not_followed(
    loop: RealtimeLoop, tmp_path: Path
) -> None:
    web = tmp_path / "web"
    (web / "page").mkdir(parents=True)
    (tmp_path / "secret.txt").write_text("secret")
    (web / "page" / "own.txt").write_text("own")
    (web / "page" / "link.txt").symlink_to(tmp_path / "secret.txt")
    app = create_app(loop, AppSettings(data=tmp_path, web=web))
    with TestClient(app, base_url=HERE) as client:
        assert client.get("/own.txt").text == "own"
        problem_of(client.get("/link.txt"), 404)


def test_what_browsers_and_people_ask_for_by_habit_leads_somewhere(client: TestClient) -> None:
    for asked, there in {"/docs/": "../docs", "/favicon.ico": "favicon.svg"}.items():
        answer = client.get(asked, follow_redirects=False)
        assert (answer.status_code, answer.headers["location"]) == (307, there)
        assert client.get(asked).status_code == 200


def test_a_browser_that_asks_for_what_there_is_not_gets_a_page(client: TestClient) -> None:
    answer = client.get("/no<b>", headers={"accept": "text/html,*/*"})
    assert answer.status_code == 404 and answer.headers["content-type"].startswith("text/html")
    assert "there is nothing at /no&lt;b&gt;" in answer.text
