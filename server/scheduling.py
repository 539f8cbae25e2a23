"""Which thread goes first: the walk before the pages, and both before other programs."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
import threading

# s a busy thread keeps the interpreter; the default 5 ms shows in the lateness with three pages
# open
SWITCH_INTERVAL = 0.001
NICENESS = -10


def raise_priority() -> None:
    """Let this thread run before other programs' where the system allows it (root, or a user with
    an rtprio or nice limit).

    Beside three browser pages that render in software on two cores, 50 ticks a second were kept in
    full so, and one in thirty was skipped without. Every thread that holds the interpreter needs
    it, or the walking thread waits behind the one that was put aside. Round robin, lowest
    priority; child processes start as usual.
    """
    if sys.platform != "linux":  # only there is a thread's number one that these calls take
        return
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))


def shorten_pauses() -> None:
    """Threads give way to each other quickly from here on, and garbage collections are short.

    What has been loaded by now is for good: left out of full garbage collections, which otherwise
    take 20 to 36 ms of a tick.
    """
    sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))
    gc.collect()
    gc.freeze()
