"""Files that people bring over HTTP."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of
from walking_console.server import uploads as uploads_module
from walking_console.server.limits import BODY_MAX
from walking_console.server.uploads import UploadRefused, Uploads

FIXTURES = Path(__file__).parents[1] / "fixtures"
DOG = (FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml").read_bytes()
UPLOADS = "/api/v1/uploads"
SCENARIO = "/api/v1/console/scenario"


def npy(array: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def sent(client: TestClient, name: str, body: bytes) -> dict[str, Any]:
    answer = client.put(f"{UPLOADS}/{name}", content=body)
    assert answer.status_code == 201, answer.text
    said: dict[str, Any] = answer.json()
    return said


def test_a_ground_and_a_robot_are_sent_and_walked_on(client: TestClient) -> None:
    picture = (FIXTURES / "colour-mode-pictures" / "RGBA.png").read_bytes()
    said = sent(client, "stairs.png", picture)
    assert said["kind"] == "ground" and "picture" in said["note"]
    assert sent(client, "dog.toml", DOG)["note"] == "dog: 33 kg quadruped (4 legs)"
    assert client.get(UPLOADS).json() == {"uploads": ["dog.toml", "stairs.png"]}
    terrain = {"file": "stairs.png", "cell": 0.025, "scale": 0.1}
    answer = client.put(SCENARIO, json={"scenario": {"robot": "dog.toml", "terrain": terrain}})
    assert answer.status_code == 200, answer.text
    assert answer.json()["robot"] == "dog"
    assert client.delete(f"{UPLOADS}/dog.toml").status_code == 204
    problem_of(client.delete(f"{UPLOADS}/dog.toml"), 404)
    assert client.get(UPLOADS).json() == {"uploads": ["stairs.png"]}


def test_a_file_larger_than_a_json_body_may_be_sent(client: TestClient) -> None:
    heights = npy(np.zeros((400, 400)))
    assert len(heights) > BODY_MAX
    assert "400 x 400" in sent(client, "level.npy", heights)["note"]


def test_a_ground_that_needs_a_key_is_kept_and_says_which(client: TestClient) -> None:
    heights = np.zeros((80, 80))
    heights[0, 0] = -9999.0
    said = sent(client, "dem.npy", npy(heights))
    assert "nodata = -9999" in said["needs"] and "part" not in said["needs"]
    terrain = {"file": "dem.npy", "nodata": -9999.0, "nan": "hole"}
    assert client.put(SCENARIO, json={"scenario": {"terrain": terrain}}).status_code == 200


@pytest.mark.parametrize(
    ("name", "body", "status"),
    [
        ("ground.exe", b"x", 422),
        (".hidden.npy", b"x", 422),
        ("a..npz", b"not a zip", 422),
        ("ground.png", b"not a picture", 422),
        ("evil.npy", npy(np.array([{"a": 1}], dtype=object)), 422),
        ("dog.toml", DOG.replace(b"mass = 32.7", b"mass = -1").replace(b"0.48", b"9.0"), 422),
        ("dog.toml", b"name = ", 422),
        ("dog.toml", b"#" * 1_000_001, 413),
    ],
)
def test_what_is_no_ground_and_no_robot_is_refused_and_not_kept(
    client: TestClient, name: str, body: bytes, status: int
) -> None:
    refusal = problem_of(client.put(f"{UPLOADS}/{name}", content=body), status)
    assert "part" not in refusal["detail"]
    assert client.get(UPLOADS).json() == {"uploads": []}


def test_every_fault_of_a_robot_is_said(client: TestClient) -> None:
    bad = DOG.replace(b"mass = 32.7", b"mass = -1").replace(
        b"duty_factor = 0.8", b"duty_factor = 2"
    )
    refusal = problem_of(client.put(f"{UPLOADS}/dog.toml", content=bad), 422)
    messages = [error["message"] for error in refusal["errors"]]
    assert any("mass" in said for said in messages) and any("duty" in said for said in messages)


@pytest.mark.parametrize("name", ["..%2Fdog.toml", "a%2Fb.npy", "%2e%2e", "a%00.npy", "a b.npy"])
def test_a_name_leads_nowhere_else(client: TestClient, name: str, tmp_path: Path) -> None:
    assert client.put(f"{UPLOADS}/{name}", content=DOG).status_code in (404, 405, 422)
    assert not list(tmp_path.rglob("*.toml"))


@pytest.mark.parametrize(
    "scenario",
    [
        {"terrain": {"file": "/etc/passwd"}},
        {"terrain": {"file": "../runs/x/terrain.npz"}},
        {"terrain": {"file": "other.npy"}},
        {"terrain": {"file": "ground.npy"}, "robot": "/elsewhere/robot.toml"},
        {"terrain": {"file": "ground.npy"}, "robot": "../robot.toml"},
    ],
)
def test_only_what_was_sent_may_be_named(client: TestClient, scenario: dict[str, Any]) -> None:
    sent(client, "ground.npy", npy(np.zeros((80, 80))))
    refusal = problem_of(client.put(SCENARIO, json={"scenario": scenario}), 422)
    assert "PUT /api/v1/uploads/NAME: ground.npy" in refusal["detail"]


def test_no_more_is_kept_than_there_is_room_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uploads_module, "UPLOADS_KEPT", 1)
    uploads = Uploads(tmp_path)
    uploads.store("dog.toml", DOG)
    assert uploads.store("dog.toml", DOG)["bytes"] == len(DOG), "its own place is free"
    with pytest.raises(UploadRefused, match="delete some"):
        uploads.store("cat.toml", DOG)
    assert uploads.names() == ["dog.toml"] and len(list(uploads.folder.iterdir())) == 1


def test_the_ground_of_the_console_comes_back_as_a_file_to_walk_on(client: TestClient) -> None:
    answer = client.get("/api/v1/console/terrain.npz")
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as terrain:
        ny, nx = terrain["heights"].shape
        assert terrain["forbidden"].shape == (ny, nx) and terrain["origin"].shape == (2,)
        assert 0.0 < float(terrain["cell"]) < 1.0
    assert f"{nx} x {ny}" in sent(client, "again.npz", answer.content)["note"]
