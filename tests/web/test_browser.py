"""A real browser on a real server: the stick walks the machine, the picture changes, letting go
stops it.
"""

import pytest
from playwright.sync_api import Page

from tests.web.browsing import (
    ERRORS,
    IN_A_BROWSER,
    Fingers,
    Visit,
    changed,
    drag_until,
    key_until,
    load,
    now,
    picture,
    take_over,
    until,
)
from walking_console.planner.robot.model import load_machine
from walking_console.web.scene.palette import style_of

pytestmark = IN_A_BROWSER


def test_dragging_the_stick_walks_the_machine_and_letting_go_stops_it(
    address: str, page: Page
) -> None:
    before = picture(page)
    drag_until(
        page,
        0.0,
        1.0,
        lambda: now(address)["distance_m"] > 0.10 and now(address)["speed_m_s"] > 0.05,
    )
    assert now(address)["crab_angle_rad"] == pytest.approx(0.0, abs=0.05)
    assert now(address)["body"][0] > 0.05
    until(page, lambda: changed(before, picture(page)) > 0.02)
    assert "you drive" in page.inner_text("#lease")
    page.mouse.up()
    until(page, lambda: now(address)["speed_m_s"] == 0.0 and now(address)["walked_m_s"] == 0.0)
    held = now(address)
    until(page, lambda: now(address)["tick"] > held["tick"] + 25)
    assert now(address)["body"][:2] == held["body"][:2]


def test_no_canvas_of_the_page_waits_for_the_process_that_draws_the_scene(visit: Visit) -> None:
    page = visit(1440, 900)
    until(page, lambda: page.locator("#chart canvas").count() == 1)
    painted = page.evaluate("""[...document.querySelectorAll("canvas")].map(
      (canvas) => canvas.getContext("2d").getContextAttributes().willReadFrequently)""")
    assert len(painted) >= 2 and all(painted)


def test_a_word_says_what_it_means_under_the_pointer_and_in_the_help(visit: Visit) -> None:
    page = visit(1440, 900)
    meaning = page.locator("#readings .label", has_text="Energy margin").get_attribute("title")
    assert meaning and meaning.startswith("How high the centre of gravity")
    page.click("#help-button")
    assert meaning in page.inner_text("#words")


def test_left_on_the_stick_is_left_of_the_torso(address: str, page: Page) -> None:
    drag_until(
        page,
        -1.0,
        0.0,
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
    key_until(page, "w", lambda: now(address)["walked_m_s"] > 0.0)
    page.keyboard.up("w")
    until(page, lambda: now(address)["speed_m_s"] == 0.0)
    page.locator("#stick").focus()
    key_until(
        page,
        "ArrowDown",
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
    key_until(page, "w", lambda: now(address)["distance_m"] > 0.05)
    page.keyboard.up("w")
    until(page, lambda: now(address)["mode"] == "stand")
    place = now(address)["body"]
    key_until(page, "q", lambda: now(address)["body"][5] > place[5] + 0.05)
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
    key_until(page, "w", lambda: now(address)["distance_m"] > 0.1)
    page.keyboard.up("w")
    page.keyboard.press("n")
    until(page, lambda: now(address)["mode"] == "regroup")
    until(page, lambda: now(address)["mode"] == "stand" and now(address)["posture"] == "standard")
    until(page, lambda: pressed.count() == 1 and pressed.inner_text() == "Standard")
    page.locator("[data-posture=sit]").focus()
    page.keyboard.press("Enter")
    until(page, lambda: now(address)["mode"] == "sit")
    before = now(address)["distance_m"]
    key_until(page, "w", lambda: now(address)["distance_m"] > before + 0.02)
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
    until(page, lambda: now(address)["stopped"] and page.inner_text("#stop-text") == "RELEASE")
    key_until(page, "w", lambda: page.locator("#toast").is_visible())
    assert now(address)["speed_m_s"] == 0.0
    page.keyboard.up("w")
    page.wait_for_timeout(1000)  # a second tap in fright would not have released it
    page.click("#stop")
    until(page, lambda: not now(address)["stopped"])


def test_a_second_finger_stops_while_the_first_drives(
    address: str, phone: Page, fingers: Fingers
) -> None:
    fingers.press(1, *fingers.middle("#stop"))
    until(phone, lambda: now(address)["stopped"])  # on the press, before it is lifted
    fingers.lift(1)
    phone.wait_for_timeout(300)
    assert now(address)["stopped"] and now(address)["speed_m_s"] == 0.0
    fingers.lift(0)
    phone.wait_for_timeout(500)  # a stop is released only once the stick is known to be at rest
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


def test_one_press_acts_once(address: str, page: Page) -> None:
    page.click("#pause")
    until(page, lambda: page.locator("#pause[aria-pressed=true]").count() == 1)
    page.wait_for_timeout(500)
    assert now(address)["paused"]
    page.locator("#pause").focus()
    page.keyboard.press("Enter")
    until(page, lambda: not now(address)["paused"])


def test_closing_the_page_stops_the_machine(address: str, page: Page, visit: Visit) -> None:
    other = visit()
    take_over(other)
    drag_until(other, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)
    other.close()
    until(page, lambda: now(address)["speed_m_s"] == 0.0)


def test_legs_are_named_and_coloured_as_the_server_says(address: str, page: Page) -> None:
    machine = load_machine("titan3")
    style = style_of(machine)
    until(page, lambda: page.inner_text("#distance") == "0.00")
    good = "getComputedStyle(document.documentElement).getPropertyValue('--good')"
    assert page.evaluate(good) == style["palette"]["good"]
    key_until(page, "w", lambda: page.inner_text("#swing") != "–")
    named = {f"{number} {name}" for number, name in enumerate(style["leg_names"], 1)}
    assert page.inner_text("#swing") in named | {"–"}
    page.keyboard.up("w")


def test_the_script_of_the_page_has_run_without_an_error(page: Page) -> None:
    assert ERRORS == []
