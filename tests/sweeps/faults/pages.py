"""Pages that end, hang or lose the hand while it holds the stick: when the machine is at rest."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import psutil
from playwright.sync_api import Browser, Dialog, Page, sync_playwright

from tests.sweeps.faults.console import DEAD_MAN, TICK, Console, Socket, begin_anew, served
from tests.sweeps.faults.table import Fault, Outcome, spread
from tests.web.browsing import BROWSER, Fingers, Visits, drag_until, now

# nobody looks at the scene here, and drawing by software would take both cores
WITHOUT_SCENE = ("--disable-gpu", "--no-sandbox", "--disable-background-networking")
HANG = 3.0  # s
FRESH_EVERY = 4  # trials, after which the machine begins anew: the ground ends somewhere
IN_TIME = DEAD_MAN + TICK


def hasten(ending: threading.Event) -> None:
    """Keep browsers as quick as this program: they put their renderers behind all others."""
    wanted = os.getpriority(os.PRIO_PROCESS, 0)
    while wanted < 0 and not ending.wait(0.3):
        for child in psutil.Process().children(recursive=True):
            with suppress(psutil.Error, OSError):
                if child.nice() > wanted:
                    for thread in child.threads():
                        os.setpriority(os.PRIO_PROCESS, thread.id, wanted)


@contextmanager
def browsing() -> Iterator[tuple[Console, Socket, Browser]]:
    """A console, somebody who watches it, and a browser."""
    with (
        served() as console,
        Socket(console.url) as watcher,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=BROWSER, args=list(WITHOUT_SCENE))
        ending = threading.Event()
        threading.Thread(target=hasten, args=(ending,), daemon=True).start()
        try:
            yield console, watcher, browser
        finally:
            ending.set()
            browser.close()


class Trial:
    """A page whose stick a mouse holds; opened anew where the last fault has ended it."""

    def __init__(self, url: str, watcher: Socket, browser: Browser) -> None:
        self.watcher = watcher
        self.visits = Visits(url, browser)
        self.browser = browser
        self.ended = True
        self.begun = 0.0  # s, monotonic, the fault
        self.dialogs: list[Dialog] = []

    @property
    def page(self) -> Page:
        return self.visits.contexts[-1].pages[0]

    def hold(self) -> None:
        """Press the stick until the machine walks."""
        if self.ended:
            self.visits.close()
            self.visits.contexts.clear()
            page = self.visits.open()
            page.on("dialog", lambda dialog: self.dialogs.append(dialog))
            self.ended = False
        if self.page.locator("#take").is_visible():
            self.page.click("#take")
        drag_until(self.page, 0.0, 1.0, self.walks)

    def begins(self) -> None:
        """The fault is there only now."""
        self.begun = time.monotonic()

    def let_go(self) -> None:
        if not self.ended:
            self.page.mouse.up()

    def walks(self) -> bool:
        return bool(self.watcher.newest["walked_m_s"] > 0.0)

    def stays(self, seconds: float = 0.7) -> bool:
        """Nothing moves, once it rests, though the hand holds on."""
        rests = self.watcher.rest_after(self.begun) is not None
        return rests and self.watcher.stays_at_rest(seconds)


Act = Callable[[Trial], bool]


def close(trial: Trial) -> bool:
    trial.page.close()
    trial.ended = True
    return True


def crash(trial: Trial) -> bool:
    found = renderers(trial.browser)
    trial.begins()
    for renderer in found:
        os.kill(renderer, signal.SIGKILL)
    trial.ended = True
    return True


def renderers(browser: Browser) -> list[int]:
    """The processes that run its pages."""
    found = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    return [each["id"] for each in found if each["type"] == "renderer"]


def leave(trial: Trial) -> bool:
    trial.page.once("framenavigated", lambda _: trial.begins())
    trial.page.goto("about:blank")
    trial.ended = True
    return True


def reload(trial: Trial) -> bool:
    trial.page.once("framenavigated", lambda _: trial.begins())
    trial.page.reload()
    return trial.stays()


def alert(trial: Trial) -> bool:
    trial.page.evaluate("void setTimeout(() => alert('a word'), 0)")
    trial.page.wait_for_timeout(1000)
    dialog = trial.dialogs.pop()
    dialog.dismiss()
    return trial.stays()


def lose_capture(trial: Trial) -> bool:
    trial.page.evaluate("document.querySelector('#stick').releasePointerCapture(1)")
    return trial.stays()


def hang(trial: Trial) -> bool:
    since = trial.page.evaluate(
        "ms => { const begun = Date.now(); while (Date.now() < begun + ms); return begun; }",
        HANG * 1000,
    )
    trial.begun = time.monotonic() - (time.time() - since / 1000.0)
    return trial.stays(1.5)


def suspend(trial: Trial) -> bool:
    found = renderers(trial.browser)
    try:
        trial.begins()
        for renderer in found:
            os.kill(renderer, signal.SIGSTOP)
        time.sleep(HANG)
    finally:
        for renderer in found:
            os.kill(renderer, signal.SIGCONT)
    return trial.stays(1.5)


def at_rest(act: Act) -> Callable[[int], Outcome]:
    """Trials of what may happen to a page while the hand holds its stick."""

    def trials(count: int) -> Outcome:
        taken: list[float | None] = []
        moved = 0
        with browsing() as (console, watcher, browser):
            trial = Trial(console.url, watcher, browser)
            for number in range(count):
                trial.hold()
                trial.begun = time.monotonic()
                moved += not act(trial)
                taken.append(watcher.rest_after(trial.begun))
                trial.let_go()
                begin_again(console.url, watcher, number)
            trial.visits.close()
        found = spread(taken, IN_TIME)
        said = f"{found.measured}; moved again {moved}"
        return Outcome(said, found.held and moved == 0)

    return trials


def begin_again(url: str, watcher: Socket, number: int) -> None:
    """Wait until nobody drives; every few trials back to the start."""
    watcher.until(lambda: watcher.newest["walked_m_s"] == 0.0)
    if number % FRESH_EVERY == FRESH_EVERY - 1:
        begin_anew(url)


def touch_cancelled(count: int) -> Outcome:
    """The system takes the touch away, as for a gesture of its own."""
    taken: list[float | None] = []
    with browsing() as (console, watcher, browser):
        visits = Visits(console.url, browser)
        page = visits.open(844, 390, has_touch=True, is_mobile=True)
        fingers = Fingers(page)
        for number in range(count):
            fingers.drive_until(lambda: bool(watcher.newest["walked_m_s"] > 0.0))
            begun = time.monotonic()
            fingers.cdp.send("Input.dispatchTouchEvent", {"type": "touchCancel", "touchPoints": []})
            fingers.down.clear()
            taken.append(watcher.rest_after(begun))
            page.wait_for_timeout(300)
            begin_again(console.url, watcher, number)
        visits.close()
    return spread(taken, IN_TIME)


LATE_BY = """limit => new Promise(done => { const began = performance.now();
 const late = () => document.body.classList.contains('late') || performance.now() - began > limit;
 const look = () => late() ? done(performance.now() - began) : setTimeout(look, 10); look(); })"""


def server_frozen(count: int) -> Outcome:
    """SIGSTOP of the whole server, while a page shows it."""
    taken: list[float | None] = []
    with browsing() as (console, _, browser):
        page = Visits(console.url, browser).open()
        for _ in range(count):
            os.kill(console.process.pid, signal.SIGSTOP)
            try:
                taken.append(page.evaluate(LATE_BY, 5000) / 1000.0)
            finally:
                os.kill(console.process.pid, signal.SIGCONT)
            page.wait_for_selector("body:not(.late)")
            page.wait_for_timeout(400)
            now(console.url)
    return spread(taken, 1.0)


RESTS = f"at rest within {IN_TIME:.2f} s, and nothing moves before a new press"
FAULTS = (
    Fault("closed", "tab closed, stick held", RESTS, at_rest(close)),
    Fault("crashed", "renderer crashed, stick held", RESTS, at_rest(crash)),
    Fault("left", "another page opened in the tab, stick held", RESTS, at_rest(leave)),
    Fault("reloaded", "page loaded anew, stick held", RESTS, at_rest(reload)),
    Fault("alert", "a dialog opens, stick held", RESTS, at_rest(alert)),
    Fault("capture", "pointer capture lost, button held", RESTS, at_rest(lose_capture)),
    Fault("cancelled", "touch cancelled by the system", RESTS, touch_cancelled),
    Fault("hung", "page hung for 3 s, stick held", RESTS, at_rest(hang)),
    Fault("suspended", "renderer stopped for 3 s, stick held", RESTS, at_rest(suspend)),
    Fault("sigstop", "server stopped (SIGSTOP)", "said on the page within 1 s", server_frozen),
)
