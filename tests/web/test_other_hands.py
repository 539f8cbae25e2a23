"""The other hands: a second stick for fingers, a gamepad, a course in figures."""

import json
import math

import pytest
from playwright.sync_api import Page

from tests.web.browsing import IN_A_BROWSER, Fingers, Visit, now, press_until, until

pytestmark = IN_A_BROWSER

PAD = """
const pad = { id: "pad", index: 0, connected: true, mapping: "standard", timestamp: 0,
  axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, value: 0 })) };
window.pads = [null, null];
navigator.getGamepads = () => window.pads;
window.plug = (more) => { window.pads = [{ ...pad, ...more }]; };
window.unplug = () => { window.pads = [null]; };
"""


def plug(page: Page, *axes: float, button: int | None = None, **more: object) -> None:
    """A pad with its sticks so, and a button down."""
    buttons = [{"pressed": number == button, "value": 0} for number in range(17)]
    pad = {"axes": [*axes, 0, 0, 0, 0][:4], "buttons": buttons, **more}
    page.evaluate(f"plug({json.dumps(pad)})")


@pytest.fixture
def padded(visit: Visit) -> Page:
    """A page of a browser with a gamepad, at rest."""
    page = visit()
    page.evaluate(PAD)
    plug(page)
    until(page, lambda: "gamepad" in page.inner_text("#toast"))
    page.wait_for_timeout(300)
    return page


def push_until(page: Page, address: str, *axes: float) -> None:
    """Push the sticks of a pad until it walks; anew where the page had to let go."""

    def walks_or_is_pushed_anew() -> bool:
        plug(page)
        page.wait_for_timeout(150)
        plug(page, *axes)
        page.wait_for_timeout(1200)
        return bool(now(address)["walked_m_s"] > 0.0)

    until(page, walks_or_is_pushed_anew)


def stands(address: str) -> bool:
    seen = now(address)
    return bool(seen["speed_m_s"] == 0.0 and seen["turn_rate_rad_s"] == 0.0)


def test_a_gamepad_drives_the_way_its_stick_points_and_stops_as_it_is_let_go(
    address: str, padded: Page
) -> None:
    push_until(padded, address, -1.0, 0.0)
    assert now(address)["crab_angle_rad"] == pytest.approx(math.pi / 2, abs=0.05)
    plug(padded)
    until(padded, lambda: stands(address))


def test_the_right_stick_of_a_gamepad_turns_to_its_side(address: str, padded: Page) -> None:
    plug(padded, 0.0, 0.0, -1.0)
    until(padded, lambda: now(address)["turn_rate_rad_s"] > 0.1 or _anew(padded, 0.0, 0.0, -1.0))
    plug(padded)
    until(padded, lambda: stands(address))


def _anew(page: Page, *axes: float) -> bool:
    plug(page)
    page.wait_for_timeout(150)
    plug(page, *axes)
    page.wait_for_timeout(600)
    return False


def test_a_worn_stick_within_its_dead_zone_moves_nothing(address: str, padded: Page) -> None:
    plug(padded, 0.1, -0.1, 0.14)
    padded.wait_for_timeout(800)
    assert stands(address) and now(address)["distance_m"] == 0.0


def test_a_pad_that_vanishes_stops_the_machine_and_moves_nothing_when_it_comes_back_held(
    address: str, padded: Page
) -> None:
    push_until(padded, address, 0.0, -1.0)
    padded.evaluate("unplug()")
    until(padded, lambda: stands(address))
    assert "has gone" in padded.inner_text("#toast")
    plug(padded, 0.0, -1.0)
    padded.wait_for_timeout(1000)
    assert stands(address)
    push_until(padded, address, 0.0, -1.0)
    plug(padded)


def test_a_button_of_the_pad_stops(address: str, padded: Page) -> None:
    push_until(padded, address, 0.0, -1.0)
    plug(padded, 0.0, -1.0, button=1)
    until(padded, lambda: now(address)["stopped"])


def test_a_pad_of_another_mapping_is_left_alone(address: str, visit: Visit) -> None:
    page = visit()
    page.evaluate(PAD)
    plug(page, 0.0, -1.0, mapping="")
    page.wait_for_timeout(800)
    assert stands(address) and not page.locator("#toast").is_visible()


def test_a_second_stick_turns_while_the_first_goes(
    address: str, phone: Page, fingers: Fingers
) -> None:
    x, y = fingers.middle("#turn-stick")

    def turns_as_it_goes() -> bool:
        seen = now(address)
        return bool(seen["turn_rate_rad_s"] > 0.0 and seen["speed_m_s"] > 0.0)

    def press() -> None:
        if 0 not in fingers.down:
            fingers.drive()
        fingers.press(1, x, y)
        fingers.move(1, x - 40, y)

    def lift() -> None:
        fingers.lift(1)
        fingers.lift(0)

    press_until(phone, press, lift, turns_as_it_goes)
    fingers.lift(1)
    until(phone, lambda: now(address)["turn_rate_rad_s"] == 0.0)
    assert phone.locator("#turn-stick.held").count() == 0


def test_a_course_in_figures_is_walked_while_its_button_is_held(address: str, visit: Visit) -> None:
    page = visit(1440, 900)
    page.click("#exact summary")
    page.fill("#course-angle", "-37")
    page.fill("#course-speed", "0.07")
    box = page.locator("#course-go").bounding_box()
    assert box is not None

    def holds() -> bool:
        page.mouse.up()
        page.mouse.move(box["x"] + 20, box["y"] + 10)
        page.mouse.down()
        page.wait_for_timeout(800)
        return bool(now(address)["speed_m_s"] == pytest.approx(0.07))

    until(page, holds)
    assert now(address)["crab_angle_rad"] == pytest.approx(math.radians(-37), abs=1e-4)
    page.mouse.up()
    until(page, lambda: stands(address))
    page.fill("#course-speed", "9")
    page.mouse.down()
    page.wait_for_timeout(500)
    assert stands(address)
    page.mouse.up()


def test_a_course_is_planned_before_anything_goes_and_ends_at_its_distance(
    address: str, visit: Visit
) -> None:
    page = visit()
    page.click("#exact summary")
    page.fill("#course-distance", "0.3")
    page.click("#course-ahead")
    until(page, lambda: page.inner_text("#course-answer").startswith("Reached in about "))
    assert now(address)["distance_m"] == 0.0
    page.fill("#course-angle", "90")
    page.locator("#course-go").focus()
    began = 0.0

    def there_or_pressed_anew() -> bool:
        """The page may have to let go, as it does where a busy machine holds it up."""
        nonlocal began
        page.wait_for_timeout(700)  # a press takes a moment to be taken
        let_go = page.locator("#course-go[aria-pressed=false]").count() > 0
        if page.inner_text("#course-answer") == "There.":  # which lets go as well
            return True
        if let_go:
            page.keyboard.up("Enter")
            until(page, lambda: stands(address) and now(address)["mode"] == "stand")
            began = now(address)["body"][1]
            page.keyboard.down("Enter")
        return False

    until(page, there_or_pressed_anew)
    page.keyboard.up("Enter")
    until(page, lambda: stands(address) and now(address)["mode"] == "stand")
    assert 0.25 < now(address)["body"][1] - began < 0.7


def test_a_click_on_the_ground_says_where_to_and_what_comes_of_it(address: str, page: Page) -> None:
    page.click("#exact summary")
    page.click("#course-point")
    box = page.locator("#view").bounding_box()
    assert box is not None
    bare = (box["x"] + 0.36 * box["width"], box["y"] + 0.4 * box["height"])

    def is_answered() -> bool:
        page.mouse.click(*bare)
        page.wait_for_timeout(1500)
        return page.inner_text("#course-answer").startswith("Reached in about ")

    until(page, is_answered)
    assert page.input_value("#course-distance") != "2.0"
    assert 0.0 < float(page.input_value("#course-angle")) < 120.0, "to the left of the picture"
    assert now(address)["distance_m"] == 0.0
    page.click("#brush-button")
    until(page, lambda: page.locator("#course-point[aria-pressed=false]").count() == 1)
    page.click("#brush-button")
    page.click("#exact summary")
