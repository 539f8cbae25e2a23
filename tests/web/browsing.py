"""A real browser on a real server: how to start both, press and look."""

import contextlib
import io
import json
import os
import re
import shutil
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any, Protocol

import pytest
from PIL import Image, ImageChops
from playwright.sync_api import Browser, BrowserContext, Page, TimeoutError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SOFTWARE_DRAWING = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
# the scene is drawn by what stands in for a graphics card; the page need not be put together by it
# too, which takes three times as long
SOFTWARE_PAGE = "--disable-gpu-compositing"
QUIET = ("--no-sandbox", "--disable-background-networking", "--no-first-run")
FLAGS = (*SOFTWARE_DRAWING, SOFTWARE_PAGE, *QUIET)
PATIENCE = 60.0  # s; software drawing on a busy machine is slow
POLL = 60  # ms

REST = {"crab_angle_rad": 0.0, "speed_m_s": 0.0, "turn_rate_rad_s": 0.0, "ttl_s": 1.0}
ERRORS: list[str] = []  # of the page, as they came
# Drawing by software takes most of two cores, and what is tested is seldom the picture: it draws
# seldom, and hardly ever while another page is tested.
DRAW_SELDOM = """if (window.parent !== window) {
  const draw = window.requestAnimationFrame.bind(window);
  const rest = () => (window.parent.aside ? 2000 : 100);
  window.requestAnimationFrame = (act) => setTimeout(() => draw(act), rest());
  window.cancelAnimationFrame = clearTimeout;
}"""
SCENE = re.compile(r"/view/(\?|$)")

BROWSER = os.environ.get("WALKING_CONSOLE_BROWSER") or next(
    filter(None, map(shutil.which, BROWSERS)), None
)
IN_A_BROWSER = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(
        BROWSER is None, reason="no Chromium or Chrome is installed: the browser tests were not run"
    ),
]


def now(address: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}/api/v1/console", timeout=10) as answer:
        found: dict[str, Any] = json.load(answer)
        return found


def holder(address: str) -> dict[str, str]:
    """The header by which whoever drives may change the world."""
    with urllib.request.urlopen(f"{address}/api/v1/health", timeout=10) as answer:
        return {"x-lease": json.load(answer)["holder"] or ""}


def tell(address: str, action: str) -> None:
    urllib.request.urlopen(
        urllib.request.Request(
            f"{address}/api/v1/console/{action}", headers=holder(address), method="POST"
        ),
        timeout=10,
    ).close()


def put(address: str, what: str, body: dict[str, Any]) -> None:
    words = json.dumps(body).encode()
    headers = {"content-type": "application/json", **holder(address)}
    urllib.request.urlopen(
        urllib.request.Request(f"{address}/api/v1/console/{what}", words, headers, method="PUT"),
        timeout=30,
    ).close()


def load(address: str, body: dict[str, Any]) -> None:
    put(address, "scenario", body)


def begin_anew(address: str) -> None:
    """The world every test finds, whatever the one before it left."""
    load(address, {"name": "flat"})
    left = now(address)
    if left["paused"]:
        tell(address, "resume")
    if left["stopped"]:
        with contextlib.suppress(urllib.error.HTTPError):  # a page still holds the lease
            put(address, "command", REST)
            tell(address, "rearm")


def until(page: Page, holds: Callable[[], bool]) -> None:
    """Let the page run until something holds; fails when it never does."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if holds():
            return
        page.wait_for_timeout(POLL)
    said = page.inner_text("#toast")
    seen = now(page.url.split("?")[0].rstrip("/"))
    raise AssertionError(f"still not so after {PATIENCE:g} s, last said: {said!r}: {seen}")


def take_over(page: Page) -> None:
    """Take the machine over from the page of a test before, unless that lets go just now."""
    take = page.locator("#take")

    def is_ours_or_free() -> bool:
        if take.is_visible():
            with contextlib.suppress(TimeoutError):
                take.click(timeout=1000)
        return not take.is_visible()

    until(page, is_ours_or_free)


class Visit(Protocol):
    """Opens a page on the console, at a size in px."""

    def __call__(
        self,
        width: int = 900,
        height: int = 620,
        path: str = "/?stand",
        *,
        scene: bool = False,
        **options: Any,
    ) -> Page: ...


class Visits:
    """Pages on one console; without the scene they cost next to nothing."""

    def __init__(self, address: str, browser: Browser) -> None:
        self.address = address
        self.browser = browser
        self.contexts: list[BrowserContext] = []

    def open(
        self,
        width: int = 900,
        height: int = 620,
        path: str = "/?stand",
        *,
        scene: bool = False,
        **options: Any,
    ) -> Page:
        """A page that has had its first picture of the machine."""
        context = self.browser.new_context(viewport={"width": width, "height": height}, **options)
        self.contexts.append(context)
        context.set_default_timeout(PATIENCE * 1000)
        context.add_init_script(DRAW_SELDOM)
        if not scene:
            context.route(SCENE, lambda route: route.fulfill(body=""))
        page = context.new_page()
        page.on("pageerror", lambda error: ERRORS.append(str(error)))
        page.goto(self.address + path)
        page.wait_for_selector("body.live")
        return page

    def close(self) -> None:
        for context in self.contexts:
            context.close()


def picture(page: Page) -> Image.Image:
    """The middle of the canvas, where the machine stands and no panel lies."""
    clip = {"x": 250, "y": 190, "width": 380, "height": 200}
    return Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")


def detail(image: Image.Image) -> float:
    """How much there is to see: the spread of brightness."""
    shades = image.convert("L").histogram()
    count = sum(shades)
    mean = sum(shade * n for shade, n in enumerate(shades)) / count
    return (sum(n * (shade - mean) ** 2 for shade, n in enumerate(shades)) / count) ** 0.5


def changed(before: Image.Image, after: Image.Image) -> float:
    """Share of pixels that clearly differ."""
    levels = ImageChops.difference(before, after).convert("L").histogram()
    return sum(levels[24:]) / sum(levels)


def grab(page: Page, right: float, up: float) -> None:
    """Press the stick in its middle and drag it, in shares of its radius."""
    box = page.locator("#stick").bounding_box()
    assert box is not None
    x, y, radius = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right * radius, y - up * radius, steps=4)


def press_until(
    page: Page, press: Callable[[], None], lift: Callable[[], None], holds: Callable[[], bool]
) -> None:
    """Press until something holds; anew where the page let go, having stood still for too long
    itself: drawing by software does that.
    """

    def holds_or_presses_anew() -> bool:
        if holds():
            return True
        if page.locator("#stick.ignored").count():
            lift()
            press()
        return False

    press()
    until(page, holds_or_presses_anew)


def drag_until(page: Page, right: float, up: float, holds: Callable[[], bool]) -> None:
    press_until(page, lambda: grab(page, right, up), page.mouse.up, holds)


def key_until(page: Page, key: str, holds: Callable[[], bool]) -> None:
    """Hold a key, which repeats as keyboards do, until something holds."""
    keys = page.keyboard

    def repeats_and_holds() -> bool:
        keys.down(key)
        return holds()

    press_until(page, lambda: keys.down(key), lambda: keys.up(key), repeats_and_holds)


class Fingers:
    """Fingers on a screen, each by its number."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.cdp = page.context.new_cdp_session(page)
        self.down: dict[int, tuple[float, float]] = {}

    def middle(self, selector: str) -> tuple[float, float]:
        box = self.page.locator(selector).bounding_box()
        assert box is not None
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drive_until(self, holds: Callable[[], bool]) -> None:
        """The first finger drives ahead until something holds."""
        press_until(self.page, self.drive, lambda: self.lift(0), holds)

    def drive(self) -> None:
        """Press the stick and push it ahead."""
        x, y = self.middle("#stick")
        self.press(0, x, y)
        self.move(0, x, y - 60)

    def press(self, finger: int, x: float, y: float) -> None:
        self.down[finger] = (x, y)
        self._tell("touchStart", self.down)

    def move(self, finger: int, x: float, y: float) -> None:
        self.down[finger] = (x, y)
        self._tell("touchMove", self.down)

    def lift(self, finger: int) -> None:
        self._tell("touchEnd", {finger: self.down.pop(finger)})  # only those that end

    def tap(self, finger: int, selector: str) -> None:
        self.press(finger, *self.middle(selector))
        self.lift(finger)

    def _tell(self, kind: str, fingers: dict[int, tuple[float, float]]) -> None:
        points = [{"id": finger, "x": x, "y": y} for finger, (x, y) in fingers.items()]
        self.cdp.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
