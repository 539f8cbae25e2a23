"""Files of the page: whole, packed, or not at all."""

import gzip
import os
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from walking_console.server.static_files import static_file

FILES = ["/", "/main.js", "/style.css", "/favicon.svg", "/vendor/swagger/swagger-ui-bundle.js"]


@pytest.mark.parametrize("path", FILES)
def test_a_file_that_the_browser_has_is_not_sent_again(client: TestClient, path: str) -> None:
    first = client.get(path)
    assert first.status_code == 200 and first.headers["cache-control"] == "no-cache"
    tag = first.headers["etag"]
    for told in (tag, f"W/{tag}", f'"other", {tag}'):
        again = client.get(path, headers={"if-none-match": told})
        assert again.status_code == 304 and again.content == b""
        assert again.headers["content-security-policy"] == first.headers["content-security-policy"]
    assert client.get(path, headers={"if-none-match": '"other"'}).status_code == 200


@pytest.mark.parametrize("path", [path for path in FILES if path != "/favicon.svg"])
def test_a_file_is_packed_for_who_unpacks_it(client: TestClient, path: str) -> None:
    plain = client.get(path, headers={"accept-encoding": "identity"})
    packed = client.get(path, headers={"accept-encoding": "gzip, br"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"] == plain.headers["vary"] == "accept-encoding"
    assert packed.content == plain.content, "the client has unpacked it"
    assert int(packed.headers["content-length"]) < 0.6 * len(plain.content)


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "page.js"
    path.write_text("one")
    first = static_file(path)
    path.write_text("two")
    os.utime(path, ns=(1, 1))
    second = static_file(path)
    assert (first.body, second.body) == (b"one", b"two") and first.etag != second.etag


def test_what_gains_nothing_is_not_packed(tmp_path: Path) -> None:
    for name, size in (("a.js", 10), ("a.png", 5000)):
        (tmp_path / name).write_bytes(b"x" * size)
        assert static_file(tmp_path / name).packed is None
    (tmp_path / "b.js").write_bytes(b"x" * 5000)
    packed = static_file(tmp_path / "b.js").packed
    assert packed is not None and gzip.decompress(packed) == b"x" * 5000


def test_a_file_says_what_it_is(client: TestClient) -> None:
    kinds = {path: client.get(path).headers["content-type"] for path in FILES[:4]}
    assert kinds == {
        "/": "text/html; charset=utf-8",
        "/main.js": "text/javascript; charset=utf-8",
        "/style.css": "text/css; charset=utf-8",
        "/favicon.svg": "image/svg+xml",
    }
