"""Worlds as people choose and watch them: lists and sliders by keyboard, machines with six legs,
traces that are walked to their end.
"""

import math
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.web.browsing import IN_A_BROWSER, Visit, drag_until, holder, load, now, until

pytestmark = IN_A_BROWSER


def test_a_hexapod_chosen_in_the_list_walks_by_stick(address: str, page: Page) -> None:
    page.locator("#robot").select_option("hexapod")
    until(page, lambda: now(address)["robot"] == "hexapod")
    assert now(address)["planner"] == "trace" and not now(address)["given_trace"]
    drag_until(page, -1.0, 0.0, lambda: now(address)["body"][1] > 0.05)
    page.mouse.up()


def test_rigid_bodies_and_the_printed_way_are_chosen_in_the_panel_and_kept_for_another_scenario(
    address: str, page: Page
) -> None:
    pytest.importorskip("mujoco")
    page.locator("#plant").select_option("physics")
    until(page, lambda: now(address)["plant"] == "physics")
    assert now(address)["body_way"] == "sway"
    drag_until(page, 0.0, 1.0, lambda: now(address)["body"][0] > 0.05)
    page.mouse.up()
    page.locator("#body-way").select_option("straight")
    until(page, lambda: now(address)["body_way"] == "straight")
    assert now(address)["plant"] == "physics"
    page.locator("#scenario").select_option("stairs-up")
    until(page, lambda: now(address)["scenario"] == "stairs-up")
    assert (now(address)["plant"], now(address)["body_way"]) == ("physics", "sway")


def test_a_given_trace_is_walked_by_itself_and_given_up_for_a_free_stick(
    address: str, page: Page
) -> None:
    load(address, {"name": "k-sideways"})
    until(page, lambda: "stick = speed" in page.inner_text("#course-text"))
    page.click("#play")
    until(page, lambda: now(address)["playing"] and now(address)["distance_m"] > 0.05)
    assert "by itself" in page.inner_text("#course-text")
    page.click("#free-stick")
    until(page, lambda: not now(address)["given_trace"])
    drag_until(page, 0.0, 1.0, lambda: now(address)["distance_m"] > 0.02)
    page.mouse.up()


def test_the_end_of_a_trace_is_an_arrival(address: str, page: Page) -> None:
    short = {"kind": "waypoints", "waypoints": [[0.0, 0.0], [0.4, 0.0]]}
    scenario = {"name": "short", "planner": "trace", "trace": short}
    load(address, {"scenario": scenario})
    page.click("#play")
    until(page, lambda: now(address)["blocked_by"] == "arrived")
    until(page, lambda: page.inner_text("#mode") == "Arrived")
    assert page.inner_text("#banner strong") == "Arrived"
    assert page.locator("#banner[data-tone=good]").count() == 1
    assert page.locator("#again").is_visible() and page.locator("#free-stick").is_visible()


def test_a_page_opens_on_a_machine_that_walks_and_the_first_touch_takes_over(
    address: str, page: Page, visit: Visit
) -> None:
    until(page, lambda: holder(address)["x-lease"] == "")
    other = visit(path="/")
    until(page, lambda: now(address)["playing"] and now(address)["walked_m_s"] > 0.0)
    until(page, lambda: "by itself" in other.inner_text("#course-text"))
    left = pytest.approx(math.pi / 2, abs=0.05)
    drag_until(other, -1.0, 0.0, lambda: now(address)["crab_angle_rad"] == left)
    assert not now(address)["playing"]


def test_a_card_plays_its_scenario_and_another_is_driven_by_hand(
    address: str, visit: Visit
) -> None:
    page = visit()
    page.keyboard.press("o")
    pictures = "[...document.querySelectorAll('#cards img')].slice(0, 6)"
    until(page, lambda: bool(page.evaluate(f"{pictures}.every(one => one.naturalWidth === 320)")))
    page.get_by_role("button", name="Play: circle", exact=True).click()
    until(page, lambda: now(address)["playing"] and now(address)["walked_m_s"] > 0.0)
    assert now(address)["scenario"] == "circle" and not page.locator("#gallery").is_visible()
    page.click("#gallery-button")
    page.get_by_role("button", name="Drive it yourself: k-sideways", exact=True).click()
    until(page, lambda: now(address)["scenario"] == "k-sideways")
    assert not now(address)["playing"] and not now(address)["given_trace"]
    drag_until(page, 0.0, 1.0, lambda: now(address)["distance_m"] > 0.01)
    page.mouse.up()


def test_in_slow_motion_it_walks_as_far_in_four_times_the_time(address: str, page: Page) -> None:
    page.click("[data-rate='0.25']")
    until(page, lambda: page.locator("[data-rate='0.25'][aria-checked=true]").count() == 1)
    began = now(address)["time_s"]
    page.wait_for_timeout(2000)
    assert 0.2 < now(address)["time_s"] - began < 1.5
    page.click("[data-rate='1']")
    until(page, lambda: now(address)["rate"] == 1.0)


def test_arrow_keys_move_a_focused_slider_and_nothing_else(address: str, page: Page) -> None:
    slider = page.locator("#top-speed-slider")
    before = float(slider.input_value())
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert float(slider.input_value()) == pytest.approx(before + 0.01)
    page.wait_for_timeout(300)
    assert now(address)["speed_m_s"] == 0.0
    page.keyboard.press("ArrowLeft")


def test_arrow_keys_look_through_a_list_and_enter_loads(address: str, page: Page) -> None:
    chosen = page.locator("#scenario")
    until(page, lambda: chosen.input_value() == "flat")
    chosen.dispatch_event("pointerdown")  # opened, and closed again on the same choice
    chosen.focus()
    page.keyboard.press("ArrowDown")
    page.wait_for_timeout(700)
    looked_at = chosen.input_value()
    assert looked_at != "flat" and now(address)["scenario"] == "flat"
    page.keyboard.press("Enter")
    until(page, lambda: now(address)["scenario"] == looked_at)
    assert page.evaluate("document.activeElement.id") == "scenario"
    page.keyboard.press("Escape")
    chosen.blur()


def test_the_margin_of_the_feet_that_carry_is_shown_when_one_has_lost_the_ground(
    address: str, page: Page
) -> None:
    seen: dict[str, Any] = now(address)
    foot = seen["feet"][0]
    page.evaluate(
        """async ([x, y]) => {
          const body = {action: "dig", circle: {x_m: x, y_m: y, radius_m: 0.15}};
          const headers = {"content-type": "application/json"};
          const how = {method: "PATCH", headers, body: JSON.stringify(body)};
          await fetch("/api/v1/console/terrain", how);
        }""",
        foot[:2],
    )
    until(page, lambda: not now(address)["contact"][0])
    assert now(address)["contact_margin_m"] < now(address)["polygon_margin_m"] - 0.1
    until(page, lambda: page.locator("#carried").is_visible())
    assert "FL has lost the ground" in page.inner_text("#carried")


def test_a_watcher_changes_nothing_while_another_drives(
    address: str, page: Page, visit: Visit
) -> None:
    other = visit()
    drag_until(page, 0.0, 1.0, lambda: now(address)["walked_m_s"] > 0.0)
    until(other, lambda: other.inner_text("#lease") == "another page drives")
    other.click("#reset")
    until(other, lambda: other.inner_text("#toast") == "another page is driving")
    assert now(address)["distance_m"] > 0.0
    page.mouse.up()


def test_what_a_scenario_expects_is_ticked_off_at_its_end(address: str, page: Page) -> None:
    scenario = {
        "name": "short",
        "drive": [{"speed": 0.1}],
        "end": {"distance": 0.2},
        "expect": {"distance_min": 0.19, "falls_max": 0, "margin_min": 9.0},
    }
    load(address, {"scenario": scenario})
    page.click("#play")
    until(page, lambda: page.locator("#expected li").count() == 3)
    assert page.locator("#expected .good").count() == 2
    assert page.inner_text("#expected .bad").startswith("margin at least 9")
    page.click("#again")
    until(page, lambda: now(address)["playing"] and not page.locator("#expected").is_visible())


def test_a_walk_is_lost_by_backspace_only_when_it_is_pressed_twice(
    address: str, visit: Visit
) -> None:
    page = visit()
    assert page.inner_text("#time") == "0:00.0"  # it has not moved yet, however long it stands
    drag_until(page, 0.0, 1.0, lambda: now(address)["distance_m"] > 0.01)
    page.mouse.up()
    until(page, lambda: now(address)["mode"] == "stand" and page.inner_text("#time") != "0:00.0")
    page.locator("body").press("Backspace")
    until(page, lambda: "Backspace again" in page.inner_text("#toast"))
    assert now(address)["distance_m"] > 0.0
    page.locator("body").press("Backspace")
    page.locator("body").press("Backspace")
    until(page, lambda: now(address)["distance_m"] == 0.0)
