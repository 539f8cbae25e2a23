"""The last seconds of what was walked, asked for over HTTP."""

from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.planner.types import Command
from walking_console.server.realtime_loop import RealtimeLoop

RECORDING = "/api/v1/console/recording"


def test_what_was_walked_is_kept_and_drawn_as_a_page(
    client: TestClient, loop: RealtimeLoop
) -> None:
    loop.order(Command(0.0, 0.1))
    for _ in range(100):
        loop.tick()
    kept = client.get(RECORDING).json()
    assert 1.9 <= kept["seconds"] <= 2.1 and kept["seconds_max"] >= 60.0
    answer = client.get(f"{RECORDING}/replay.html", params={"seconds": 1.0})
    assert answer.status_code == 200, answer.text
    assert "attachment" in answer.headers["content-disposition"]
    assert "<title>flat: titan3" in answer.text and "sandbox" in str(answer.headers)


def test_before_anything_was_walked_there_is_nothing_to_save(client: TestClient) -> None:
    refusal = problem_of(client.get(f"{RECORDING}/replay.html"), 409)
    assert "nothing has been walked yet" in refusal["detail"]
    problem_of(client.get(f"{RECORDING}/replay.html", params={"seconds": 1e9}), 422)
