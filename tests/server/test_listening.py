"""Where the console listens, and who must show a token there."""

import socket

import pytest

from walking_console.server import listening
from walking_console.server.listening import (
    ServeError,
    check_names,
    check_token,
    check_viewer_token,
    is_loopback,
    lan_address,
    listen,
    own_names,
    url_of,
)


@pytest.mark.parametrize("token", ["", "short", "k" * 31, "k" * 40 + " ", "k" * 40 + ";", "ü" * 40])
def test_a_token_that_is_too_short_or_odd_is_refused(token: str) -> None:
    with pytest.raises(ServeError, match="at least 32"):
        check_token("127.0.0.1", token)


def test_a_token_for_viewers_is_as_long_another_and_beside_that_of_drivers() -> None:
    check_viewer_token(None, None)
    check_viewer_token("k" * 40, "v" * 40)
    for token, viewer in ((None, "v" * 40), ("k" * 40, "k" * 40), ("k" * 40, "v" * 31)):
        with pytest.raises(ServeError, match="--viewer-token must"):
            check_viewer_token(token, viewer)


def test_a_good_token_lets_it_listen_anywhere_with_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    check_token("0.0.0.0", "k" * 32)
    assert "without TLS" in caplog.text


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
    with listen("127.0.0.1", 0) as heard:
        port = heard.getsockname()[1]
        assert port > 0 and heard.proto == socket.IPPROTO_TCP, "asyncio sets TCP_NODELAY only then"
        assert url_of(heard, "127.0.0.1", None) == f"http://127.0.0.1:{port}"
        assert url_of(heard, "0.0.0.0", "t") == f"http://127.0.0.1:{port}/login?token=t"


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.1", "a" * 300])
def test_an_address_that_cannot_be_had_is_said(host: str) -> None:
    with pytest.raises(ServeError, match="cannot listen"):
        listen(host, 0)


def test_names_and_paths_that_are_none_are_refused() -> None:
    check_names(["labserver.example.edu", "pi:8443", "raspberrypi.local"], "/user/x/proxy/8000")
    check_names([], "")
    for name in ("*", "https://lab.example", "a b", "", "lab/console", "a.b:", "-a", "a" * 254):
        with pytest.raises(ServeError, match="--allow-host"):
            check_names([name], "")
    for path in ("console", "/a/../b", "//evil", "/a?b", "/a b", "/"):
        with pytest.raises(ServeError, match="--root-path"):
            check_names([], path)


def test_this_computer_is_known_by_its_name_and_by_that_name_under_local() -> None:
    assert own_names("raspberrypi") == ("raspberrypi", "raspberrypi.local")
    assert own_names("pi.lan") == ("pi.lan", "pi.local")


def test_the_address_in_the_network_is_not_loopback(monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        assert not is_loopback(lan_address())
    except ServeError as error:
        assert "--host" in str(error)
    monkeypatch.setattr(listening, "SOMEWHERE", ("127.0.0.1", 9))
    with pytest.raises(ServeError, match="in no network"):
        lan_address()
