"""Files of multipart forms come out as they went in."""

import random

import httpx
import pytest

from walking_console.server.forms import FILES_MAX, FormFault, FormFile, files_of, is_form


def form(files: list[tuple[str, tuple[str, bytes]]]) -> tuple[str, bytes]:
    """Content type and body as a client sends them."""
    request = httpx.Request("POST", "http://here/", files=files, data={"note": "x"})
    return request.headers["content-type"], request.read()


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"\r\n",
        b"a\rb\nc\r\n\r\n",
        b"--\r\n--x--\r\n",
        bytes(range(256)) * 300,
        random.Random(3).randbytes(100_000),
    ],
)
def test_a_file_comes_out_byte_by_byte(body: bytes) -> None:
    kind, sent = form([("file", ("g.npy", body))])
    assert is_form(kind)
    assert files_of(kind, sent) == [FormFile("g.npy", body)]


@pytest.mark.parametrize("name", ["g.npy", "mine\\g.npy", "/there/g.npy", "../g.npy"])
def test_folders_of_a_file_name_are_left_away(name: str) -> None:
    assert files_of(*form([("file", (name, b"x"))]))[0].name == "g.npy"


def test_a_form_without_a_file_or_with_too_many_is_refused() -> None:
    with pytest.raises(FormFault, match="no file"):
        files_of("multipart/form-data; boundary=x", b"--x--\r\n")
    with pytest.raises(FormFault, match="no file"):
        files_of("multipart/form-data", b"garbage")
    many = [("file", (f"{k}.npy", b"x")) for k in range(FILES_MAX + 1)]
    with pytest.raises(FormFault, match=f"at most {FILES_MAX}"):
        files_of(*form(many))
