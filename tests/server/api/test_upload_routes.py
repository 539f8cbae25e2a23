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


def test_a_form_with_a_file_is_the_file_under_the_name_it_is_put_to(client: TestClient) -> None:
    form = {"file": ("other.npy", ground())}
    answer = client.put(f"{UPLOADS}/level.npy", files=form, data={"note": "mine"})
    assert answer.status_code == 201, answer.text
    assert answer.json()["bytes"] == len(ground())
    assert client.get(UPLOADS).json() == {"uploads": ["level.npy"]}


def test_the_files_of_a_form_are_kept_under_their_own_names(client: TestClient) -> None:
    form = [("file", ("a.npy", ground())), ("file", ("grounds\\b.npy", ground()))]
    answer = client.post(UPLOADS, files=form)
    assert answer.status_code == 201, answer.text
    assert [said["name"] for said in answer.json()] == ["a.npy", "b.npy"]
    assert client.get(UPLOADS).json() == {"uploads": ["a.npy", "b.npy"]}


def test_a_form_without_a_file_and_a_bad_file_in_one_are_refused(client: TestClient) -> None:
    empty = client.post(UPLOADS, files={"file": (None, "text")})
    assert "curl -F file=@ground.png" in str(problem_of(empty, 422))
    bad = client.post(UPLOADS, files={"file": ("a.npy", b"no array")})
    assert "a.npy cannot be read" in str(problem_of(bad, 422))
    assert "form is wanted" in str(problem_of(client.post(UPLOADS, content=b"x"), 415))
    assert client.get(UPLOADS).json() == {"uploads": []}


def test_what_is_not_there_cannot_be_removed(client: TestClient) -> None:
    assert "no upload 'none.npy'" in str(problem_of(client.delete(f"{UPLOADS}/none.npy"), 404))
