"""Two thumbs on a phone: one holds the stick, the other taps."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext

from playwright.sync_api import Page

from tests.sweeps.faults.console import Console, Hand, Seen, Socket, begin_anew
from tests.sweeps.faults.pages import begin_again, browsing
from tests.sweeps.faults.table import Fault, Outcome, spread
from tests.web.browsing import Fingers, Visits, holder

PHONES = ((390, 844), (844, 390))
MOTION_ENDS = 0.1  # s


def ends(seen: Seen) -> bool:
    """Nothing moves: the command is to rest and the body stands, or time does."""
    frame = seen.frame
    return bool(frame["paused"] or (seen.rests and frame["walked_m_s"] == 0.0))


class Thumbs:
    """A phone's page under two thumbs."""

    def __init__(self, console: Console, watcher: Socket, page: Page) -> None:
        self.console = console
        self.watcher = watcher
        self.page = page
        self.fingers = Fingers(page)

    def walks(self) -> bool:
        return bool(self.watcher.newest["walked_m_s"] > 0.0)

    def tap_after(self, selector: str) -> float | None:
        """Seconds from the second thumb's touch to the end of motion."""
        x, y = self.fingers.middle(selector)
        begun = time.monotonic()
        self.fingers.press(1, x, y)
        taken = self.watcher.seconds_to(ends, begun)
        self.fingers.lift(1)
        return taken

    def let_go(self) -> None:
        if 0 in self.fingers.down:
            self.fingers.lift(0)
        self.page.wait_for_timeout(500)

    def until(self, key: str, value: object) -> None:
        self.watcher.until(lambda: bool(self.watcher.newest[key] == value))


def stop(thumbs: Thumbs) -> float | None:
    thumbs.fingers.drive_until(thumbs.walks)
    taken = thumbs.tap_after("#stop")
    thumbs.let_go()
    thumbs.page.wait_for_timeout(500)
    while thumbs.watcher.newest["stopped"]:
        thumbs.fingers.tap(1, "#stop")
        thumbs.page.wait_for_timeout(1000)
    return taken


def pause(thumbs: Thumbs) -> float | None:
    thumbs.fingers.drive_until(thumbs.walks)
    taken = thumbs.tap_after("#pause")
    thumbs.let_go()
    thumbs.fingers.tap(1, "#pause")
    thumbs.until("paused", False)
    return taken


def sit(thumbs: Thumbs) -> float | None:
    thumbs.fingers.drive_until(thumbs.walks)
    taken = thumbs.tap_after("[data-posture=sit]")
    thumbs.let_go()
    begin_anew(thumbs.console.url)
    thumbs.until("posture", "stand")
    return taken


def take(thumbs: Thumbs, other: Hand) -> float | None:
    """Another drives; its motion ends when this phone takes over, its own stick held already."""
    thumbs.fingers.press(0, *thumbs.fingers.middle("#stick"))
    other.say({"type": "take"})
    other.walk()
    thumbs.page.wait_for_selector("#take", state="visible")
    taken = thumbs.tap_after("#take")
    ours = holder(thumbs.console.url)["x-lease"]
    thumbs.let_go()
    other.hold(0.0)
    return taken if ours else None


Act = Callable[[Thumbs], float | None]


def trials_of(act: Act | None) -> Callable[[int], Outcome]:
    """So many trials on each phone; None: taking over from another driver."""

    def trials(count: int) -> Outcome:
        found = [spread(on_phone(act, size, count), MOTION_ENDS) for size in PHONES]
        sizes = [f"{width}×{height}: " for width, height in PHONES]
        said = "; ".join(size + one.measured for size, one in zip(sizes, found, strict=True))
        return Outcome(said, all(one.held for one in found))

    return trials


def on_phone(act: Act | None, size: tuple[int, int], count: int) -> list[float | None]:
    """The seconds of every trial on a phone of this size."""
    taken: list[float | None] = []
    with browsing() as (console, watcher, browser):
        visits = Visits(console.url, browser)
        thumbs = Thumbs(console, watcher, visits.open(*size, has_touch=True, is_mobile=True))
        with Hand(console.url) if act is None else nullcontext() as other:
            for number in range(count):
                taken.append(act(thumbs) if act else take(thumbs, other))  # type: ignore[arg-type]
                begin_again(console.url, watcher, number)
        visits.close()
    return taken


ENDS = f"motion ends within {1000 * MOTION_ENDS:.0f} ms of the touch"
FAULTS = (
    Fault("thumbs-stop", "two thumbs: stick held, STOP tapped", ENDS, trials_of(stop)),
    Fault("thumbs-pause", "two thumbs: stick held, pause tapped", ENDS, trials_of(pause)),
    Fault("thumbs-sit", "two thumbs: stick held, sit tapped", ENDS, trials_of(sit)),
    Fault("thumbs-take", "two thumbs: stick held, another's machine taken", ENDS, trials_of(None)),
)
