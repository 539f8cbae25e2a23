"""A real browser on a real server: the stick walks the machine, the picture changes, letting go
stops it.
"""

import io
import json
import os
import shutil
import subprocess
import sys
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image, ImageChops
from playwright.sync_api import Browser, Page, sync_playwright

from walking_console.planner.robot.model import load_machine
from walking_console.web.scene.palette import style_of

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SOFTWARE_DRAWING = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
FLAGS = (*SOFTWARE_DRAWING, "--no-sandbox", "--disable-background-networking", "--no-first-run")
PATIENCE = 60.0  # s; software drawing on a busy machine is slow
POLL = 60  # ms

ERRORS: list[str] = []  # of the page, as they came
VISER_EVAL = "Evaluating a string as JavaScript"  # viser tries to, and is refused

BROWSER = os.environ.get("WALKING_CONSOLE_BROWSER") or next(
    filter(None, map(shutil.which, BROWSERS)), None
)
pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(
        BROWSER is None, reason="no Chromium or Chrome is installed: the browser tests were not run"
    ),
]


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    words = [
        sys.executable,
        "-m",
        "walking_console",
        "serve",
        "--port",
        "0",
        "--no-open",
        "--scenario",
        "flat",
    ]
    data = tmp_path_factory.mktemp("served")
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    server = subprocess.Popen(
        words,
        cwd=data,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert server.stdout is not None
    try:
        yield server.stdout.readline().strip()
    finally:
        server.terminate()
        server.communicate(timeout=15)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def opened(address: str, browser: Browser) -> Iterator[Page]:
    """The console in one page; opened once, since the first drawing takes software a while."""
    page = browser.new_page(viewport={"width": 900, "height": 620})
    page.on("pageerror", lambda error: ERRORS.append(str(error)))
    page.goto(address)
    page.wait_for_selector("body.live")
    until(
        page, lambda: page.frames[1].locator("canvas").count() > 0 and detail(picture(page)) > 8.0
    )
    yield page
    page.close()


@pytest.fixture
def page(address: str, opened: Page) -> Iterator[Page]:
    """The open page, the machine at its start."""
    tell(address, "reset")
    yield opened
    opened.mouse.up()


def now(address: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}/api/v1/console", timeout=10) as answer:
        found: dict[str, Any] = json.load(answer)
        return found


def tell(address: str, action: str) -> None:
    urllib.request.urlopen(
        urllib.request.Request(f"{address}/api/v1/console/{action}", method="POST"), timeout=10
    ).close()


def load(address: str, body: dict[str, Any]) -> None:
    words = json.dumps(body).encode()
    headers = {"content-type": "application/json"}
    urllib.request.urlopen(
        urllib.request.Request(f"{address}/api/v1/console/scenario", words, headers, method="PUT"),
        timeout=30,
    ).close()


def until(page: Page, holds: Callable[[], bool]) -> None:
    """Let the page run until something holds; fails when it never does."""
    for _ in range(int(PATIENCE * 1000 / POLL)):
        if holds():
            return
        page.wait_for_timeout(POLL)
    raise AssertionError(f"still not so after {PATIENCE:g} s: {now(page.url.rstrip('/'))}")


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


def test_dragging_the_stick_walks_the_machine_and_letting_go_stops_it(
    address: str, page: Page
) -> None:
    before = picture(page)
    grab(page, 0.0, 1.0)
    until(page, lambda: now(address)["distance_m"] > 0.10 and now(address)["speed_m_s"] > 0.05)
    assert now(address)["crab_angle_rad"] == pytest.approx(0.0, abs=0.05)
    assert now(address)["body"][0] > 0.05
    until(page, lambda: changed(before, picture(page)) > 0.02)
    assert "you drive" in page.inner_text("#lease")
    page.mouse.up()
    until(page, lambda: now(address)["speed_m_s"] == 0.0 and now(address)["walked_m_s"] == 0.0)
    held = now(address)
    until(page, lambda: now(address)["tick"] > held["tick"] + 25)
    assert now(address)["body"][:2] == held["body"][:2]


def test_left_on_the_stick_is_left_of_the_torso(address: str, page: Page) -> None:
    grab(page, -1.0, 0.0)
    until(
        page,
        lambda: (
            now(address)["body"][1] > 0.03
            and now(address)["crab_angle_rad"] == pytest.approx(1.5708, abs=0.05)
        ),
    )
    page.mouse.up()
    until(page, lambda: now(address)["speed_m_s"] == 0.0)


def test_held_keys_walk_whichever_part_has_the_focus(address: str, page: Page) -> None:
    page.mouse.click(440, 300)  # into the canvas: its frame takes the focus
    assert page.evaluate("document.activeElement.id") == "view"
    page.keyboard.down("w")
    until(page, lambda: now(address)["walked_m_s"] > 0.0)
    page.keyboard.up("w")
    until(page, lambda: now(address)["speed_m_s"] == 0.0)
    page.locator("#stick").focus()
    page.keyboard.down("ArrowDown")
    until(
        page,
        lambda: (
            now(address)["speed_m_s"] > 0.0
            and abs(now(address)["crab_angle_rad"]) == pytest.approx(3.1416, abs=0.01)
        ),
    )
    page.keyboard.up("ArrowDown")
    until(page, lambda: now(address)["speed_m_s"] == 0.0)


def test_a_hexapod_walks_and_turns_on_the_spot_by_keys_and_shows_its_footholds(
    address: str, page: Page
) -> None:
    terrain = {"kind": "footholds", "fraction": 0.1}
    load(
        address,
        {"scenario": {"name": "six", "robot": "hexapod", "planner": "trace", "terrain": terrain}},
    )
    until(
        page,
        lambda: (
            page.locator("#footholds").is_visible() and page.locator("#turn-slider").is_visible()
        ),
    )
    page.keyboard.down("w")
    until(page, lambda: now(address)["distance_m"] > 0.05)
    page.keyboard.up("w")
    until(page, lambda: now(address)["mode"] == "stand")
    place = now(address)["body"]
    page.keyboard.down("q")
    until(page, lambda: now(address)["body"][5] > place[5] + 0.05)
    page.keyboard.up("q")
    assert now(address)["body"][:2] == pytest.approx(place[:2], abs=0.05)
    until(page, lambda: now(address)["mode"] == "stand")
    load(address, {"name": "flat"})
    until(page, lambda: not page.locator("#footholds").is_visible())


def test_buttons_and_keys_sit_the_machine_down_stand_it_up_and_set_its_feet_in_order(
    address: str, page: Page
) -> None:
    pressed = page.locator("#postures [aria-pressed=true]")
    page.click("[data-posture=sit]")
    until(page, lambda: now(address)["mode"] == "sit")
    assert now(address)["body"][2] < 0.6
    until(
        page,
        lambda: (
            page.inner_text("#mode") == "Sitting"
            and pressed.count() == 1
            and pressed.inner_text() == "Sit"
        ),
    )
    page.keyboard.press("x")
    until(page, lambda: now(address)["mode"] == "stand" and now(address)["body"][2] > 0.8)
    page.keyboard.down("w")
    until(page, lambda: now(address)["distance_m"] > 0.1)
    page.keyboard.up("w")
    page.keyboard.press("n")
    until(page, lambda: now(address)["mode"] == "regroup")
    until(page, lambda: now(address)["mode"] == "stand" and now(address)["posture"] == "standard")
    until(page, lambda: pressed.count() == 1 and pressed.inner_text() == "Standard")
    page.locator("[data-posture=sit]").focus()
    page.keyboard.press("Enter")
    until(page, lambda: now(address)["mode"] == "sit")
    before = now(address)["distance_m"]
    page.keyboard.down("w")
    until(page, lambda: now(address)["distance_m"] > before + 0.02)
    page.keyboard.up("w")
    until(page, lambda: now(address)["mode"] == "stand")


def test_a_switch_and_a_key_let_the_body_follow_the_ground(address: str, page: Page) -> None:
    chosen = page.locator("#attitudes [aria-checked=true]")
    assert chosen.get_attribute("data-attitude") == "level"
    page.click("[data-attitude=ground]")
    until(
        page,
        lambda: (
            now(address)["attitude"] == "ground"
            and chosen.get_attribute("data-attitude") == "ground"
        ),
    )
    page.keyboard.press("g")
    until(
        page,
        lambda: (
            now(address)["attitude"] == "level" and chosen.get_attribute("data-attitude") == "level"
        ),
    )
    load(address, {"name": "flat", "mode": "paper"})
    until(page, lambda: page.locator("#attitudes").is_hidden())


def test_space_stops_for_everybody_until_it_is_released(address: str, page: Page) -> None:
    page.mouse.click(440, 300)
    page.keyboard.press("Space")
    until(page, lambda: now(address)["stopped"])
    page.keyboard.down("w")
    until(page, lambda: page.locator("#toast").is_visible())
    assert now(address)["speed_m_s"] == 0.0
    page.keyboard.up("w")
    page.wait_for_timeout(1000)  # a second tap in fright would not have released it
    page.click("#stop")
    until(page, lambda: not now(address)["stopped"])


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


@pytest.fixture
def phone(address: str, browser: Browser) -> Iterator[Page]:
    """The console on a phone held sideways."""
    tell(address, "reset")
    context = browser.new_context(
        viewport={"width": 844, "height": 390}, has_touch=True, is_mobile=True
    )
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("body.live")
    if page.locator("#take").is_visible():
        page.tap("#take")
    yield page
    context.close()


@pytest.fixture
def fingers(address: str, phone: Page) -> Iterator[Fingers]:
    """Fingers on that phone, the first of them driving ahead."""
    found = Fingers(phone)
    x, y = found.middle("#stick")
    found.press(0, x, y)
    found.move(0, x, y - 60)
    until(phone, lambda: now(address)["walked_m_s"] > 0.0)
    yield found
    if 0 in found.down:
        found.lift(0)


def test_a_second_finger_stops_while_the_first_drives(
    address: str, phone: Page, fingers: Fingers
) -> None:
    fingers.press(1, *fingers.middle("#stop"))
    until(phone, lambda: now(address)["stopped"])  # on the press, before it is lifted
    fingers.lift(1)
    phone.wait_for_timeout(300)
    assert now(address)["stopped"] and now(address)["speed_m_s"] == 0.0
    fingers.lift(0)
    fingers.tap(1, "#stop")
    until(phone, lambda: not now(address)["stopped"])


@pytest.mark.parametrize("focused", ["#scenario", "#pause", "#wide-brush", "#help .close"])
def test_space_stops_wherever_the_focus_is(address: str, page: Page, focused: str) -> None:
    if focused.startswith("#help"):
        page.keyboard.press("?")
    elif focused == "#wide-brush":
        page.keyboard.press("b")
    page.locator(focused).focus()
    page.keyboard.press("Space")
    until(page, lambda: now(address)["stopped"])
    assert not now(address)["paused"] and not page.locator("#wide-brush").is_checked()
    assert page.locator("#help").is_visible() == focused.startswith("#help")
    page.keyboard.press("Escape")  # closes what is open
    page.wait_for_timeout(1000)
    page.click("#stop")
    until(page, lambda: not now(address)["stopped"])


def test_two_quick_taps_on_stop_stop_and_do_not_release(address: str, page: Page) -> None:
    page.dblclick("#stop")
    until(page, lambda: now(address)["stopped"])
    page.wait_for_timeout(1000)
    assert now(address)["stopped"]
    page.click("#stop")
    until(page, lambda: not now(address)["stopped"])


def test_every_control_acts_under_a_second_finger(
    address: str, phone: Page, fingers: Fingers
) -> None:
    fingers.tap(1, "#pause")
    until(phone, lambda: phone.locator("#pause[aria-pressed=true]").count() == 1)
    assert now(address)["paused"]
    fingers.tap(1, "#pause")
    until(phone, lambda: not now(address)["paused"])
    fingers.tap(1, "[data-rate='2']")
    until(phone, lambda: now(address)["rate"] == 2.0)
    fingers.tap(1, "[data-rate='1']")
    until(phone, lambda: now(address)["rate"] == 1.0)
    fingers.tap(1, "#view-button")
    until(phone, lambda: phone.locator("#view-menu").is_visible())
    reach = phone.locator("[data-layer=Reach]")
    fingers.tap(1, "[data-layer=Reach]")
    until(phone, reach.is_checked)
    fingers.tap(1, "#view-button")
    fingers.tap(1, "[data-posture=sit]")
    until(phone, lambda: now(address)["mode"] in ("sit_down", "sit"))


def test_a_second_finger_turns_while_the_first_drives(
    address: str, phone: Page, fingers: Fingers
) -> None:
    x, y = fingers.middle("#turn-slider")
    fingers.press(1, x, y)
    fingers.move(1, x - 40, y)
    until(phone, lambda: now(address)["turn_rate_rad_s"] > 0.0)
    assert now(address)["speed_m_s"] > 0.0
    fingers.lift(1)
    until(phone, lambda: now(address)["turn_rate_rad_s"] == 0.0)


def test_one_press_acts_once(address: str, page: Page) -> None:
    page.click("#pause")
    until(page, lambda: page.locator("#pause[aria-pressed=true]").count() == 1)
    page.wait_for_timeout(500)
    assert now(address)["paused"]
    page.locator("#pause").focus()
    page.keyboard.press("Enter")
    until(page, lambda: not now(address)["paused"])


def test_closing_the_page_stops_the_machine(address: str, page: Page, browser: Browser) -> None:
    other = browser.new_page(viewport={"width": 900, "height": 620})
    other.goto(address)
    other.wait_for_selector("body.live")
    other.click("#take") if other.locator("#take").is_visible() else None
    grab(other, 0.0, 1.0)
    until(other, lambda: now(address)["walked_m_s"] > 0.0)
    other.close()
    until(page, lambda: now(address)["speed_m_s"] == 0.0)


def test_legs_are_named_and_coloured_as_the_server_says(address: str, page: Page) -> None:
    machine = load_machine("titan3")
    style = style_of(machine)
    until(page, lambda: page.inner_text("#distance") == "0.00")
    good = "getComputedStyle(document.documentElement).getPropertyValue('--good')"
    assert page.evaluate(good) == style["palette"]["good"]
    page.keyboard.down("w")
    until(page, lambda: page.inner_text("#swing") != "–")
    named = {f"{number} {name}" for number, name in enumerate(style["leg_names"], 1)}
    assert page.inner_text("#swing") in named | {"–"}
    page.keyboard.up("w")


def test_the_script_of_the_page_has_run_without_an_error(page: Page) -> None:
    assert [error for error in ERRORS if VISER_EVAL not in error] == []
