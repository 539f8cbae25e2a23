"""Who asks gets in, however many are silent."""

from typing import Any, cast

import pytest

from walking_console.server import connections
from walking_console.server.connections import Connections, SocketRate, most_connections
from walking_console.server.limits import (
    ADDRESSES_KEPT,
    CONNECTIONS_MAX,
    DESCRIPTORS_KEPT,
    SOCKETS_BURST,
    SOCKETS_PER_SECOND,
)


class Line:
    """As much of a transport as is asked for."""

    def __init__(self, address: str = "127.0.0.1") -> None:
        self.address = address
        self.aborted = False

    def get_extra_info(self, name: str) -> Any:
        return (self.address, 4711) if name == "peername" else None

    def abort(self) -> None:
        self.aborted = True


def opened(registry: Connections, line: Line) -> bool:
    return registry.open(cast(Any, line))


def test_the_one_that_waits_longest_makes_room() -> None:
    registry = Connections(most=3)
    lines = [Line() for _ in range(5)]
    assert all(opened(registry, line) for line in lines)
    assert [line.aborted for line in lines] == [True, True, False, False, False]
    assert len(registry) == 3 and registry.cut == 2


def test_who_has_asked_stays_and_who_was_answered_waits_again() -> None:
    registry = Connections(most=2)
    busy, idle = Line(), Line()
    for line in (busy, idle):
        opened(registry, line)
        registry.busy(cast(Any, line))
    assert not opened(registry, Line()), "there is no room, and nobody who waits"
    registry.idle(cast(Any, idle))
    assert opened(registry, Line())
    assert idle.aborted and not busy.aborted


def test_one_address_of_the_network_cannot_take_every_place() -> None:
    registry = Connections(most=10, most_per_address=3)
    here = Line("192.0.2.1")
    assert opened(registry, here)
    greedy = [Line("192.0.2.7") for _ in range(9)]
    assert all(opened(registry, line) for line in greedy)
    assert sum(not line.aborted for line in greedy) == 3 and not here.aborted
    for line in greedy[-3:]:
        registry.busy(cast(Any, line))
    assert not opened(registry, Line("192.0.2.7"))
    assert opened(registry, Line("192.0.2.8"))


def test_this_computer_where_proxies_are_is_counted_in_all_only() -> None:
    registry = Connections(most=10, most_per_address=3)
    assert all(opened(registry, Line()) for _ in range(10)) and registry.cut == 0


def test_one_that_ended_leaves_its_place() -> None:
    registry = Connections(most=1)
    line = Line()
    opened(registry, line)
    registry.close(cast(Any, line))
    registry.idle(cast(Any, line))  # an answer that came too late
    assert len(registry) == 0 and opened(registry, Line()) and registry.cut == 0


def test_there_are_no_more_than_there_are_descriptors_for(monkeypatch: pytest.MonkeyPatch) -> None:
    resource = pytest.importorskip("resource")
    for descriptors, most in ((10_000, CONNECTIONS_MAX), (256, 256 - DESCRIPTORS_KEPT), (100, 16)):
        monkeypatch.setattr(resource, "getrlimit", lambda _, n=descriptors: (n, n))
        assert most_connections() == most
    assert connections.resource is resource


def test_an_address_opens_sockets_as_fast_as_is_allowed_and_no_faster() -> None:
    rate = SocketRate()
    burst = [rate.open("10.0.0.1", 0.0) for _ in range(200)]
    assert burst == [True] * int(SOCKETS_BURST) + [False] * (200 - int(SOCKETS_BURST))
    assert rate.open("10.0.0.2", 0.0), "another address has its own"
    a_second = [rate.open("10.0.0.1", 1.0) for _ in range(200)]
    assert sum(a_second) == SOCKETS_PER_SECOND
    assert sum(rate.open("10.0.0.1", 1000.0) for _ in range(200)) == SOCKETS_BURST


def test_addresses_that_opened_a_socket_long_ago_are_forgotten() -> None:
    rate = SocketRate()
    for number in range(3 * ADDRESSES_KEPT):
        rate.open(f"10.0.{number}", 0.0)
    assert len(rate) == ADDRESSES_KEPT
