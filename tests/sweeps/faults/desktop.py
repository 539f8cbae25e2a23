"""A key held on a desktop while something takes the keyboard from the page: it is let go unseen.

A window manager and true key presses are needed for this: Xvfb, openbox and xdotool.
"""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from playwright.sync_api import Browser, Page, sync_playwright

from tests.sweeps.faults.console import DEAD_MAN, TICK, Console, Socket, served
from tests.sweeps.faults.pages import WITHOUT_SCENE, begin_again
from tests.sweeps.faults.table import Fault, Outcome, spread
from tests.web.browsing import BROWSER, SCENE

PROGRAMS = ("Xvfb", "openbox", "xdotool")
SIZE = (1280, 900)
KEY = "w"
CALM = "#mode"  # a click on it neither drives nor loads anything
IN_TIME = DEAD_MAN + TICK
CORNER = "() => [screenX + (outerWidth - innerWidth) / 2, screenY + outerHeight - innerHeight]"


class Desktop:
    """A screen with a window manager and hands on its keyboard and mouse."""

    def __init__(self, display: str) -> None:
        self.environment = os.environ | {"DISPLAY": display}

    def do(self, *words: str) -> None:
        subprocess.run(["xdotool", *words], env=self.environment, check=True, timeout=20)

    def point(self, page: Page, selector: str) -> None:
        """The mouse over the middle of something."""
        box = page.locator(selector).bounding_box()
        assert box is not None
        left, top = page.evaluate(CORNER)
        x, y = left + box["x"] + box["width"] / 2, top + box["y"] + box["height"] / 2
        self.do("mousemove", str(round(x)), str(round(y)))

    def hold_key(self, page: Page) -> None:
        """Press a key that drives; a click before it, as a hand would, puts the keyboard there."""
        self.point(page, CALM)
        self.do("click", "1")
        page.evaluate("document.activeElement?.blur()")
        self.do("keydown", KEY)


@contextmanager
def screen() -> Iterator[Desktop]:
    """One of its own, ended at the end."""
    missing = [program for program in PROGRAMS if shutil.which(program) is None]
    if missing:
        raise SystemExit(f"this fault needs a desktop: {', '.join(missing)} not found")
    read, write = os.pipe()
    size = f"{SIZE[0]}x{SIZE[1]}x24"
    words = ["Xvfb", "-displayfd", str(write), "-screen", "0", size, "-nolisten", "tcp"]
    with subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL) as server:
        os.close(write)
        with os.fdopen(read) as number:
            desktop = Desktop(f":{number.readline().strip()}")
        try:
            with subprocess.Popen(
                ["openbox"], env=desktop.environment, stderr=subprocess.DEVNULL
            ) as manager:
                yield desktop
                manager.terminate()
        finally:
            server.terminate()


@contextmanager
def window() -> Iterator[tuple[Console, Socket, Desktop, Page]]:
    """A console, somebody who watches it, and its page in a window of a desktop."""
    with (
        screen() as desktop,
        served() as console,
        Socket(console.url) as watcher,
        sync_playwright() as playwright,
    ):
        size = f"--window-size={SIZE[0]},{SIZE[1]}"
        browser: Browser = playwright.chromium.launch(
            executable_path=BROWSER,
            headless=False,
            env=dict(desktop.environment),
            args=[*WITHOUT_SCENE, size, "--window-position=0,0"],
        )
        try:
            context = browser.new_context(no_viewport=True)
            context.route(SCENE, lambda route: route.fulfill(body=""))
            page = context.new_page()
            page.goto(f"{console.url}/?stand")
            page.wait_for_selector("body.live")
            yield console, watcher, desktop, page
        finally:
            browser.close()


def context_menu(desktop: Desktop, page: Page) -> None:
    desktop.point(page, "#view")
    desktop.do("click", "3")


def scenario_list(desktop: Desktop, page: Page) -> None:
    desktop.point(page, "#scenario")
    desktop.do("click", "1")  # lets go of the key, and no more
    desktop.do("sleep", "0.7", "click", "1")


def browser_menu(desktop: Desktop, _: Page) -> None:
    desktop.do("key", "alt+f")


def another_tab(desktop: Desktop, _: Page) -> None:
    desktop.do("key", "--clearmodifiers", "ctrl+t")


def another_window(desktop: Desktop, _: Page) -> None:
    desktop.do("key", "--clearmodifiers", "ctrl+n")


Act = Callable[[Desktop, Page], None]


def key_let_go_under(*menus: Act) -> Callable[[int], Outcome]:
    """A key held, a menu opened, the key let go; the kinds of menu by turns."""

    def trials(count: int) -> Outcome:
        taken: list[float | None] = []
        moved = 0
        with window() as (console, watcher, desktop, page):
            for number, menu in zip(range(count), itertools.cycle(menus)):
                desktop.hold_key(page)
                assert watcher.until(lambda: bool(watcher.newest["walked_m_s"] > 0.0))
                menu(desktop, page)
                time.sleep(0.3)
                begun = time.monotonic()
                desktop.do("keyup", KEY)
                taken.append(watcher.rest_after(begun))
                moved += not watcher.stays_at_rest(0.7)
                desktop.do("key", "Escape")
                moved += not watcher.stays_at_rest(0.3)
                begin_again(console.url, watcher, number)
        return at_rest(taken, moved)

    return trials


def key_held_while(act: Act, undone: str) -> Callable[[int], Outcome]:
    """A key held on while the page loses the screen or the keyboard, and gets it back."""

    def trials(count: int) -> Outcome:
        taken: list[float | None] = []
        moved = 0
        with window() as (console, watcher, desktop, page):
            for number in range(count):
                desktop.hold_key(page)
                assert watcher.until(lambda: bool(watcher.newest["walked_m_s"] > 0.0))
                begun = time.monotonic()
                act(desktop, page)
                taken.append(watcher.rest_after(begun))
                moved += not watcher.stays_at_rest(0.7)
                desktop.do("keyup", KEY)
                desktop.do("key", undone)
                moved += not watcher.stays_at_rest(0.7)
                begin_again(console.url, watcher, number)
        return at_rest(taken, moved)

    return trials


def at_rest(taken: Sequence[float | None], moved: int) -> Outcome:
    """Held where all came to rest in time and none moved again."""
    found = spread(taken, IN_TIME)
    return Outcome(f"{found.measured}; moved again {moved}", found.held and moved == 0)


MUST = f"at rest within {IN_TIME:.2f} s, and nothing moves before a new press"
FAULTS = (
    Fault(
        "menus",
        "key held, context menu, scenario list or browser menu opened, key let go",
        MUST,
        key_let_go_under(context_menu, scenario_list, browser_menu),
    ),
    Fault("hidden", "another tab, key held", MUST, key_held_while(another_tab, "ctrl+w")),
    Fault(
        "blurred", "another window, key held", MUST, key_held_while(another_window, "ctrl+shift+w")
    ),
)
