"""The served console as a process: one URL line, one clear line for what is wrong, and an end in
time.
"""

import logging
import os
import re
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import httpx
import pytest
from websockets.sync.client import connect

from walking_console.server.api.kept_world import KeptWorld
from walking_console.server.api.state import WORLD
from walking_console.server.launch import (
    app_settings,
    first_world,
    for_the_network,
    log_to_stderr,
)
from walking_console.server.limits import SOCKETS_BURST, SOCKETS_PER_SECOND
from walking_console.server.listening import ServeError, check_token, is_loopback
from walking_console.server.serve_options import FIRST_SCENARIO, LogLevel, ServeOptions

COMMAND = (sys.executable, "-m", "walking_console", "--no-open", "--scenario", "flat")


@contextmanager
def served(
    folder: Path, *more: str, before: tuple[str, ...] = ()
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A console in a process of its own, and the address it printed."""
    command = [*before, *COMMAND, "--port", "0", "--data", str(folder), *more]
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8"}
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8"
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
        with connect(
            f"ws://127.0.0.1:{port}/drive",
            origin=url,  # type: ignore[arg-type]
            compression="deflate",
        ) as drive:
            assert drive.protocol.extensions == [], "a compressed frame can be a bomb"
            assert "hello" in str(drive.recv())
            slow = socket.create_connection(("127.0.0.1", port))
            slow.sendall(
                b"PUT /api/v1/console/command HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                b"Content-Length: 100\r\n\r\n{"
            )
            begun = time.monotonic()
            process.send_signal(signal.SIGTERM)
            assert process.wait(10) == 0
            assert time.monotonic() - begun < 5.0
            slow.close()
        assert process.stdout is not None and process.stdout.read() == "", "one line, and no other"


def test_a_stop_is_still_there_after_the_console_was_killed_and_started_again(
    tmp_path: Path,
) -> None:
    with served(tmp_path) as (process, url):
        assert httpx.post(f"{url}/api/v1/console/stop").json() == {"stopped": True}
        process.kill()
        process.wait(10)
    with served(tmp_path) as (_, url):
        assert httpx.get(f"{url}/api/v1/console").json()["stopped"]
        assert httpx.post(f"{url}/api/v1/console/rearm").status_code == 409


@pytest.mark.skipif(os.name != "posix", reason="only there are descriptors few")
def test_silent_connections_keep_nobody_out_where_descriptors_are_few(tmp_path: Path) -> None:
    few = 'ulimit -n 256 && exec "$0" "$@"'
    with served(tmp_path, before=("sh", "-c", few)) as (_, url), ExitStack() as silent:
        at = ("127.0.0.1", int(url.rsplit(":", 1)[1]))
        for _ in range(300):
            one = silent.enter_context(socket.create_connection(at))
            with suppress(ConnectionError):  # it has made room already
                one.sendall(b"GET /api/v1/health HTTP/1.1\r\nHost:")
        for _ in range(20):
            assert httpx.post(f"{url}/api/v1/console/stop", timeout=30.0).status_code == 200
        assert httpx.get(f"{url}/api/v1/health", timeout=30.0).json()["ok"]


def test_a_head_that_is_too_long_is_refused_and_the_next_is_answered(tmp_path: Path) -> None:
    with served(tmp_path) as (process, url):
        at = ("127.0.0.1", int(url.rsplit(":", 1)[1]))
        for head in (b"x" * 200_000, b"A: b\r\n" * 50_000, b"A: " + b"b" * 200_000):
            with socket.create_connection(at) as long, suppress(ConnectionError):
                long.settimeout(10.0)
                long.sendall(b"GET /api/v1/health HTTP/1.1\r\nHost: 127.0.0.1\r\n" + head)
                answer = long.recv(65536)
                assert answer == b"" or answer.startswith(b"HTTP/1.1 4"), answer[:100]
        assert httpx.get(f"{url}/api/v1/health").json()["ok"]
        process.kill()
        assert process.stderr is not None and len(process.stderr.read()) < 10_000


def asked_for_a_socket(line: socket.socket, url: str) -> bytes:
    """How the answer to a handshake of a WebSocket begins; nothing is read of what follows."""
    line.sendall(
        f"GET /drive HTTP/1.1\r\nHost: {url[7:]}\r\nConnection: Upgrade\r\n"
        f"Upgrade: websocket\r\nOrigin: {url}\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
    )
    line.settimeout(20.0)
    return line.recv(12)


def test_who_opens_sockets_too_fast_is_refused_and_soon_taken_again(tmp_path: Path) -> None:
    with served(tmp_path) as (_, url):
        at = ("127.0.0.1", int(url.rsplit(":", 1)[1]))
        answers = []
        begun = time.monotonic()
        while b"HTTP/1.1 429" not in answers and time.monotonic() < begun + 30.0:
            with socket.create_connection(at) as line:
                answers.append(asked_for_a_socket(line, url))
        assert answers[0] == b"HTTP/1.1 101" and answers[-1] == b"HTTP/1.1 429"
        assert len(answers) > SOCKETS_BURST
        assert httpx.post(f"{url}/api/v1/console/stop").status_code == 200
        time.sleep(2.0 / SOCKETS_PER_SECOND)
        with socket.create_connection(at) as line:
            assert asked_for_a_socket(line, url) == b"HTTP/1.1 101"


def test_a_driver_that_reads_nothing_loses_its_place(tmp_path: Path) -> None:
    with served(tmp_path) as (_, url):
        port = int(url.rsplit(":", 1)[1])
        with socket.create_connection(("127.0.0.1", port)) as stuck:
            assert asked_for_a_socket(stuck, url) == b"HTTP/1.1 101"
            time.sleep(6.0)  # in which it answers no ping
            assert httpx.get(f"{url}/api/v1/health", timeout=30.0).json()["drivers"] == 0


PING = b'{"type": "ping", "sent_ms": 1}'
FRAMES = 10 * (b"\x81" + bytes([0x80 | len(PING)]) + bytes(4) + PING)  # masked by zeros
TOO_FAST = b"\x03\xf0"  # 1008, as a close frame has it


def flood(line: socket.socket) -> float:
    """Send pings and heed nothing until the connection ends: the s since it was told to close."""
    heard, told = b"", 0.0
    with suppress(ConnectionError):
        while True:
            readable, writable, _ = select.select([line], [line], [], 30.0)
            assert readable or writable, "it neither ends nor goes on"
            if readable:
                came = line.recv(65536)
                if not came:
                    break
                heard = heard[-1:] + came
                told = told or (time.monotonic() if TOO_FAST in heard else 0.0)
            if writable:
                line.send(FRAMES)
    assert told, "it was never told"
    return time.monotonic() - told


def test_a_flood_ends_soon_after_its_close_code(tmp_path: Path) -> None:
    """uvicorn itself would let it go on for 10 s."""
    with served(tmp_path) as (_, url):
        with socket.create_connection(("127.0.0.1", int(url.rsplit(":", 1)[1]))) as line:
            assert asked_for_a_socket(line, url) == b"HTTP/1.1 101"
            assert flood(line) < 5.0


def test_it_starts_in_the_world_last_loaded_unless_one_is_asked_for(tmp_path: Path) -> None:
    assert first_world(ServeOptions(data=tmp_path)).scenario.name == FIRST_SCENARIO
    KeptWorld(tmp_path / WORLD)._write('{"name": "river"}')
    assert first_world(ServeOptions(data=tmp_path)).scenario.name == "river"
    assert first_world(ServeOptions(data=tmp_path, scenario="flat")).scenario.name == "flat"


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


def test_the_names_it_answers_for_are_those_it_was_asked_to_listen_on() -> None:
    alone = app_settings(ServeOptions())
    assert alone.hosts == () and not alone.addresses
    named = app_settings(ServeOptions(host="robot.lan", token="k" * 40))
    here = (socket.gethostname(), f"{socket.gethostname().split('.')[0]}.local")
    assert named.hosts == ("robot.lan", *here) and named.addresses
    anywhere = app_settings(ServeOptions(host="0.0.0.0", token="k" * 40))
    assert anywhere.hosts == here and anywhere.token == "k" * 40


def test_what_happens_is_said_on_standard_error_from_the_chosen_level_on(
    capsys: pytest.CaptureFixture[str],
) -> None:
    ours = logging.getLogger("walking_console")
    everybody = logging.getLogger()
    before = ours.handlers[:], ours.level, everybody.handlers[:]
    ours.handlers.clear()
    try:
        log_to_stderr(LogLevel.INFO)
        logging.getLogger("walking_console.server.launch").info("here")
        logging.getLogger("walking_console.server.launch").debug("not here")
        logging.getLogger("asyncio").error("there")
    finally:
        ours.handlers[:] = before[0]
        ours.setLevel(before[1])
        everybody.handlers[:] = before[2]
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 2
    assert "INFO walking_console.server.launch: here" in told.err
    assert "ERROR asyncio: there" in told.err


def test_for_the_network_it_listens_there_and_makes_a_token() -> None:
    for host in ("127.0.0.1", "0.0.0.0"):
        try:
            made = for_the_network(ServeOptions(host=host, lan=True))
        except ServeError:
            pytest.skip("this computer is in no network")
        assert made.viewer_token is not None and made.viewer_token != made.token
        assert made.token is not None and not is_loopback(made.host) and made.host != "0.0.0.0"
        check_token(made.host, made.token)
    given = for_the_network(ServeOptions(host="192.0.2.7", token="k" * 40, lan=True))
    assert given.host == "192.0.2.7" and given.token == "k" * 40


def test_with_lan_it_prints_an_address_with_a_token_and_a_picture_of_it(tmp_path: Path) -> None:
    with served(tmp_path, "--lan") as (process, url):
        if process.poll() is not None:
            pytest.skip("this computer is in no network")
        assert re.fullmatch(r"http://(?!127)[\d.]+:\d+/login\?token=[\w-]{43}", url)
        assert httpx.get(url).status_code == 303
        process.send_signal(signal.SIGTERM)
        said, _ = process.communicate(timeout=10)
    picture, _, watching = said.rstrip("\n").rpartition("\n")
    assert len(picture.splitlines()) > 15 and set(picture) <= set("█▀▄ \n")
    assert re.fullmatch(r"to watch and stop only: http://.*/login\?token=[\w-]{43}", watching)
    assert url not in watching
