"""Where the console listens, and who must show a token there."""

import socket

import pytest

from walking_console.server.listening import ServeError, check_token, is_loopback, listen, url_of


@pytest.mark.parametrize("token", ["", "short", "k" * 31, "k" * 40 + " ", "k" * 40 + ";", "ü" * 40])
def test_a_token_that_is_too_short_or_odd_is_refused(token: str) -> None:
    with pytest.raises(ServeError, match="at least 32"):
        check_token("127.0.0.1", token)


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
