"""Nothing moves that no hand moves: a picture that grows old, a page that hangs, and keys let go of
where the page cannot see it.
"""

import os
import re
import signal
import subprocess
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from tests.web.browsing import IN_A_BROWSER, Visit, drag_until, key_until, now, until

pytestmark = IN_A_BROWSER

LATE_BY = "new Promise(done => { const began = performance.now(); const look = () =>\
 document.body.classList.contains('late') ? done(performance.now() - began)\
 : setTimeout(look, 20); look(); })"

# A page that stands still for too long lets its keys go: here W is pressed again, if need be, in
# the moment in which the mouse is.
HELD_AT_THE_PRESS = """addEventListener("pointerdown",
 () => document.dispatchEvent(new KeyboardEvent("keydown", {code: "KeyW"})),
 {capture: true, once: true})"""
W_AND_R = """for (const code of ["KeyW", "KeyR"])
 document.dispatchEvent(new KeyboardEvent("keydown", {code}))"""

STAND = """
const now = () => performance.now();
const stand = (ms) => { const end = now() + ms; while (now() < end); };
"""
# ms from what the last draw but one of so many answers to the last
DRAWS = (
    STAND
    + """
const draws = (count, work) => new Promise(done => {
  let runs = 0;
  let since = 0;
  const draw = () => {
    if (++runs === count) return done(now() - since);
    requestAnimationFrame(draw);
    since = work();
  };
  requestAnimationFrame(draw);
});
"""
)


@pytest.fixture
def frozen(served: tuple[str, "subprocess.Popen[str]"]) -> Iterator[list[int]]:
    """Freezes the server when it is asked; thawed at the end in any case."""
    process = served[1]
    yield [process.pid]
    os.kill(process.pid, signal.SIGCONT)


def stands(address: str) -> bool:
    seen = now(address)
    return bool(seen["speed_m_s"] == 0.0 and seen["walked_m_s"] == 0.0)


def stays(page: Page, address: str, seconds: float = 1.5) -> None:
    """It stands, and nothing moves it meanwhile."""
    until(page, lambda: stands(address))
    place = now(address)["body"]
    page.wait_for_timeout(seconds * 1000)
    assert stands(address) and now(address)["body"] == place


def test_the_way_there_and_back_is_shown(page: Page) -> None:
    until(page, lambda: re.fullmatch(r"\d+ ms", page.inner_text("#link-text")) is not None)


def test_a_frozen_server_is_said_within_a_second_and_lets_the_stick_go(
    address: str, page: Page, frozen: list[int]
) -> None:
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)
    os.kill(frozen[0], signal.SIGSTOP)
    assert page.evaluate(LATE_BY) < 1000.0
    until(page, lambda: page.inner_text("#link-text").startswith("no picture for"))
    until(page, lambda: page.locator("#stick.ignored").count() == 1)
    os.kill(frozen[0], signal.SIGCONT)
    until(page, lambda: page.locator("body.late").count() == 0)
    stays(page, address)  # the stick is still held
    page.mouse.up()
    assert page.locator("#stick.ignored").count() == 0
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)


def test_a_server_frozen_for_longer_is_lost_and_found_again(
    address: str, page: Page, frozen: list[int]
) -> None:
    os.kill(frozen[0], signal.SIGSTOP)
    until(page, lambda: page.locator("#lost").is_visible())
    os.kill(frozen[0], signal.SIGCONT)
    until(page, lambda: not page.locator("#lost").is_visible())
    key_until(page, "w", lambda: now(address)["walked_m_s"] > 0.0)
    page.keyboard.up("w")


def test_a_page_that_hung_moves_nothing_again_before_a_new_press(address: str, page: Page) -> None:
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)
    page.evaluate("{ const end = performance.now() + 3000; while (performance.now() < end); }")
    stays(page, address)
    page.mouse.up()
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)


def test_a_fresh_press_on_a_page_that_just_stood_still_waits_for_it_to_be_calm(
    address: str, visit: Visit
) -> None:
    page = visit()
    page.evaluate(
        STAND
        + """
        stand(700);
        document.dispatchEvent(new KeyboardEvent("keydown", {code: "KeyW"}));
        setTimeout(stand, 50, 900);"""
    )
    until(page, lambda: now(address)["distance_m"] > 0.0)
    page.evaluate("document.dispatchEvent(new KeyboardEvent('keyup', {code: 'KeyW'}))")


def test_the_scene_leaves_the_page_as_much_time_as_its_drawing_takes(page: Page) -> None:
    waited = page.frames[1].evaluate(DRAWS + "draws(3, () => { stand(150); return now(); })")
    assert waited > 140.0


def test_what_draws_is_paced_by_all_that_its_picture_takes(page: Page) -> None:
    waited = page.frames[1].evaluate(
        DRAWS
        + """
        draws(4, () => {
          requestAnimationFrame(() => stand(150)); // of the same picture
          return now();
        })"""
    )
    assert waited > 290.0  # as long as that, and once more


def held(page: Page, address: str) -> None:
    """W held down until the machine walks."""
    key_until(page, "w", lambda: bool(now(address)["walked_m_s"] > 0.0))


def test_a_key_that_no_longer_says_it_is_held_is_let_go(address: str, page: Page) -> None:
    held(page, address)
    stays(page, address)
    page.keyboard.down("w")  # it is still held, after all: that is no new press
    stays(page, address, 0.5)
    page.keyboard.up("w")


@pytest.mark.parametrize("menu", ["menu", "menu in the scene", "list", "Alt"])
def test_a_menu_that_opens_lets_the_keys_go(address: str, page: Page, menu: str) -> None:
    held(page, address)
    if menu == "menu":
        page.mouse.click(*middle(page, "#state"), button="right")
    elif menu == "menu in the scene":
        page.frames[1].evaluate("window.dispatchEvent(new Event('contextmenu'))")
    elif menu == "list":
        page.locator("#scenario").dispatch_event("pointerdown")
    else:
        page.keyboard.press("Alt")
    page.keyboard.down("w")
    stays(page, address, 0.5)
    page.keyboard.up("w")


def test_the_press_that_lets_a_key_go_opens_no_list(address: str, page: Page) -> None:
    held(page, address)
    page.evaluate(HELD_AT_THE_PRESS)
    page.mouse.click(*middle(page, "#scenario"))
    page.keyboard.down("w")  # its repeats would be letters to choose by
    stays(page, address, 0.5)
    assert page.evaluate("document.activeElement.id") != "scenario"
    assert now(address)["scenario"] == "flat"
    page.keyboard.up("w")
    page.mouse.click(*middle(page, "#scenario"))
    assert page.evaluate("document.activeElement.id") == "scenario"
    page.keyboard.press("Escape")
    page.evaluate("document.activeElement.blur()")


def middle(page: Page, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_mouse_button_let_go_of_outside_is_seen_when_the_mouse_moves_again(
    address: str, page: Page
) -> None:
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)
    page.evaluate(
        "stick => stick.dispatchEvent(new PointerEvent('pointermove', {pointerId: 1, buttons: 0}))",
        page.locator("#stick").element_handle(),
    )
    stays(page, address, 0.5)


def test_a_stop_is_not_released_while_the_stick_is_held(address: str, page: Page) -> None:
    page.keyboard.press("Space")
    until(page, lambda: now(address)["stopped"])
    page.wait_for_timeout(1000)
    page.evaluate(W_AND_R)  # in one moment: W is let go where the page stands still between them
    page.wait_for_timeout(1000)
    assert now(address)["stopped"]
    page.keyboard.up("w")
    page.wait_for_timeout(500)
    page.keyboard.press("r")
    until(page, lambda: not now(address)["stopped"])


SIZES = [(320, 568), (360, 225), (390, 844), (844, 390), (900, 620), (1024, 768)]


@pytest.mark.parametrize("size", [*SIZES, (1440, 900)])
def test_stick_and_stop_stay_where_they_are_whatever_the_panels_say(
    visit: Visit, size: tuple[int, int]
) -> None:
    page = visit(*size)
    before = [page.locator(control).bounding_box() for control in ("#stop", "#stick")]
    for panel in ("#why", "#mode", "#planner", "#crab"):
        assert page.locator(panel).count() == 1
        page.evaluate(
            "(panel) => { const long = document.createElement('div');"
            " long.textContent = 'so many words that it takes several lines '.repeat(9);"
            " document.querySelector(panel).parentElement.append(long); }",
            panel,
        )
    assert [page.locator(control).bounding_box() for control in ("#stop", "#stick")] == before


@pytest.mark.parametrize("size", SIZES)
def test_stop_and_stick_are_on_the_screen_at_every_size(
    visit: Visit, size: tuple[int, int]
) -> None:
    """360 × 225 is a window of 1440 × 900 at 400 %."""
    page = visit(*size)
    for control in ("#stop", "#stick"):
        box = page.locator(control).bounding_box()
        assert box is not None and box["x"] >= 0 and box["y"] >= 0
        assert box["x"] + box["width"] <= size[0] and box["y"] + box["height"] <= size[1]
    hit = "([x, y]) => document.elementFromPoint(x, y).closest('button')?.id"
    assert page.evaluate(hit, middle(page, "#stop")) == "stop"
    page.locator("#attitudes").scroll_into_view_if_needed()
    page.locator("[data-posture=sit]").scroll_into_view_if_needed()
    assert page.evaluate(hit, middle(page, "#stop")) == "stop"
