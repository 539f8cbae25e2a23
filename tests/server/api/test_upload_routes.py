"""The routes of files that people bring: kept, listed, removed, and refused with advice."""

import io

import numpy as np
from fastapi.testclient import TestClient

from tests.server.problem_json import problem_of

UPLOADS = "/api/v1/uploads"


def ground() -> bytes:
    file = io.BytesIO()
    np.save(file, np.zeros((80, 80)))
    return file.getvalue()


def test_a_file_is_kept_listed_and_removed(client: TestClient) -> None:
    assert client.put(f"{UPLOADS}/level.npy", content=ground()).status_code == 201
    assert client.get(UPLOADS).json() == {"uploads": ["level.npy"]}
    assert client.delete(f"{UPLOADS}/level.npy").status_code == 204
    assert client.get(UPLOADS).json() == {"uploads": []}


def test_a_form_is_answered_with_how_to_send_the_file(client: TestClient) -> None:
    answer = client.put(f"{UPLOADS}/level.npy", files={"file": ground()})
    assert "curl -T FILE" in str(problem_of(answer, 415))
    assert client.get(UPLOADS).json() == {"uploads": []}


def test_what_is_not_there_cannot_be_removed(client: TestClient) -> None:
    assert "no upload 'none.npy'" in str(problem_of(client.delete(f"{UPLOADS}/none.npy"), 404))
