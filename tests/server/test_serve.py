"""The served console as a process: one URL line, one clear line for what is wrong, and an end in
time.
"""

import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from websockets.sync.client import connect

from walking_console.server.launch import ServeError, check_token, is_loopback, listen, url_of

COMMAND = (sys.executable, "-m", "walking_console", "--no-open", "--scenario", "flat")


@contextmanager
def served(folder: Path, *more: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A console in a process of its own, and the address it printed."""
    command = [*COMMAND, "--port", "0", "--data", str(folder), *more]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().strip()
        finally:
            if process.poll() is None:
                process.kill()


def test_it_prints_one_address_answers_there_and_ends_in_time_whatever_is_open(
    tmp_path: Path,
) -> None:
    with served(tmp_path) as (process, url):
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+", url)
        port = int(url.rsplit(":", 1)[1])
        health = httpx.get(f"{url}/api/v1/health").json()
        assert health["ok"], health
        with connect(f"ws://127.0.0.1:{port}/drive", origin=url, compression="deflate") as drive:  # type: ignore[arg-type]
            assert drive.protocol.extensions == [], "a compressed frame can be a bomb"
            assert "hello" in str(drive.recv())
            slow = socket.create_connection(("127.0.0.1", port))
            slow.sendall(
                b"PUT /api/v1/console/command HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100\r\n\r\n{"
            )
            begun = time.monotonic()
            process.send_signal(signal.SIGTERM)
            assert process.wait(10) == 0
            assert time.monotonic() - begun < 5.0
            slow.close()
        assert process.stdout is not None and process.stdout.read() == "", "one line, and no other"


def test_a_port_in_use_is_one_clear_line_and_exit_2(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        answer = subprocess.run(
            [*COMMAND, "--port", str(port), "--data", str(tmp_path)],
            capture_output=True,
            text=True,
            timeout=60,
        )
    assert answer.returncode == 2 and answer.stdout == ""
    assert (
        len(answer.stderr.splitlines()) == 1
        and f"port {port}" in answer.stderr
        and "in use" in answer.stderr
    )


def test_beyond_loopback_it_refuses_to_start_without_a_token(tmp_path: Path) -> None:
    answer = subprocess.run(
        [*COMMAND, "--host", "0.0.0.0", "--port", "0"],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=tmp_path,
    )
    assert (
        answer.returncode == 2
        and "--token" in answer.stderr
        and len(answer.stderr.splitlines()) == 1
    )


@pytest.mark.parametrize("token", ["", "short", "k" * 31, "k" * 40 + " ", "k" * 40 + ";", "ü" * 40])
def test_a_token_that_is_too_short_or_odd_is_refused(token: str) -> None:
    with pytest.raises(ServeError, match="at least 32"):
        check_token("127.0.0.1", token)


def test_a_good_token_lets_it_listen_anywhere_with_a_warning(
    capsys: pytest.CaptureFixture[str],
) -> None:
    check_token("0.0.0.0", "k" * 32)
    assert "without TLS" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("host", "alone"),
    [
        ("127.0.0.1", True),
        ("127.0.0.2", True),
        ("localhost", True),
        ("::1", True),
        ("0.0.0.0", False),
        ("10.0.0.1", False),
        ("::", False),
    ],
)
def test_loopback_is_known(host: str, alone: bool) -> None:
    assert is_loopback(host) == alone


def test_the_address_names_the_picked_port_and_carries_the_token() -> None:
    with listen("127.0.0.1", 0) as listening:
        port = listening.getsockname()[1]
        assert port > 0 and listening.proto == socket.IPPROTO_TCP, (
            "asyncio sets TCP_NODELAY only then"
        )
        assert url_of(listening, "127.0.0.1", None) == f"http://127.0.0.1:{port}"
        assert url_of(listening, "0.0.0.0", "t") == f"http://127.0.0.1:{port}/login?token=t"


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.1", "a" * 300])
def test_an_address_that_cannot_be_had_is_said(host: str) -> None:
    with pytest.raises(ServeError, match="cannot listen"):
        listen(host, 0)
