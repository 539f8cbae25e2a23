"""A thread with a loop in it that ends when it is told to."""

from __future__ import annotations

import threading
from collections.abc import Callable

JOIN_TIME = 1.0  # s the end of a thread is waited for


class LoopThread:
    """Runs ``run(stopping)`` in a daemon thread; ``run`` returns soon after ``stopping`` is set."""

    def __init__(self, name: str, run: Callable[[threading.Event], None]) -> None:
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=run, args=(self._stopping,), name=name, daemon=True)

    def start(self) -> None:
        """Begin; at most once."""
        self._thread.start()

    def stop(self) -> None:
        """Ask it to end and wait a moment for it; harmless when it never began."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(timeout=JOIN_TIME)

    @property
    def running(self) -> bool:
        """Whether it has begun and not ended."""
        return self._thread.is_alive()
