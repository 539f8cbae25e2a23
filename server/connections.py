"""Every connection of the web side, so that silent ones never keep others out.

Where there are too many, the one that has waited longest without a whole request makes room: who
asks for something, and a stop above all, gets in.
"""

from __future__ import annotations

import logging
import time
from asyncio.transports import Transport
from collections import OrderedDict

from .allowance import Allowance
from .limits import (
    ADDRESSES_KEPT,
    CONNECTIONS_MAX,
    CONNECTIONS_PER_ADDRESS,
    DESCRIPTORS_KEPT,
    SOCKETS_BURST,
    SOCKETS_PER_SECOND,
)
from .listening import is_loopback

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]

SAY_EVERY = 1000  # cut connections

log = logging.getLogger(__name__)


def most_connections() -> int:
    """As many as are allowed, or as the descriptors of this process suffice for."""
    if resource is None:
        return CONNECTIONS_MAX
    descriptors = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if descriptors == resource.RLIM_INFINITY:
        return CONNECTIONS_MAX
    return max(16, min(CONNECTIONS_MAX, descriptors - DESCRIPTORS_KEPT))


class SocketRate:
    """How fast each address opens WebSockets; of the newest ``ADDRESSES_KEPT`` that did."""

    def __init__(self) -> None:
        self._allowances: OrderedDict[str, Allowance] = OrderedDict()

    def __len__(self) -> int:
        return len(self._allowances)

    def open(self, address: str, now: float) -> bool:
        """One more at ``now``, s; False when that is too many."""
        allowance = self._allowances.pop(address, None)
        if allowance is None:
            allowance = Allowance(SOCKETS_BURST, SOCKETS_PER_SECOND, now)
        self._allowances[address] = allowance
        if len(self._allowances) > ADDRESSES_KEPT:
            self._allowances.popitem(last=False)
        return allowance.take(now)


class Connections:
    """Who is connected, and who of them has nothing asked; used from the web loop only."""

    def __init__(self, most: int, most_per_address: int = CONNECTIONS_PER_ADDRESS) -> None:
        self._most = most
        self._most_per_address = most_per_address
        self._address: dict[Transport, str] = {}
        self._waiting: dict[Transport, None] = {}  # the one that waits longest first
        self._sockets = SocketRate()
        self.cut = 0

    def __len__(self) -> int:
        return len(self._address)

    def open(self, transport: Transport) -> bool:
        """One more; False when there is no room for it."""
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if isinstance(peer, tuple) else ""
        if not self._make_room(address):
            self._count_cut()
            return False
        self._address[transport] = address
        self._waiting[transport] = None
        return True

    def busy(self, transport: Transport) -> None:
        """It has asked for something."""
        self._waiting.pop(transport, None)

    def may_open_socket(self, transport: Transport) -> bool:
        """Whether its address may have one more WebSocket just now."""
        return self._sockets.open(self._address.get(transport, ""), time.monotonic())

    def idle(self, transport: Transport) -> None:
        """It has been answered."""
        if transport in self._address:
            self._waiting[transport] = None

    def close(self, transport: Transport) -> None:
        """It has ended."""
        self._address.pop(transport, None)
        self._waiting.pop(transport, None)

    def _make_room(self, address: str) -> bool:
        if not is_loopback(address):
            its = sum(other == address for other in self._address.values())
            if its >= self._most_per_address and not self._cut_oldest(address):
                return False
        return len(self._address) < self._most or self._cut_oldest(None)

    def _cut_oldest(self, address: str | None) -> bool:
        """End the connection that waits longest, of this address or of any; whether there was
        one.
        """
        for transport in self._waiting:
            if address in (None, self._address[transport]):
                self.close(transport)
                transport.abort()
                self._count_cut()
                return True
        return False

    def _count_cut(self) -> None:
        self.cut += 1
        if self.cut % SAY_EVERY == 1:
            log.warning(
                "%d connections: the silent ones make room (%d so far)", len(self), self.cut
            )
