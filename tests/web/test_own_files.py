"""Grounds and robots dropped on the page, good and bad; the last half minute saved, and opened
without a server.
"""

import base64
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from tests.web.browsing import IN_A_BROWSER, detail, drag_until, now, picture, until

pytestmark = IN_A_BROWSER

FIXTURES = Path(__file__).parents[1] / "fixtures"
DOG = (FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml").read_bytes()
PICTURE = (FIXTURES / "colour-mode-pictures" / "L.png").read_bytes()
BAD_DOG = DOG.replace(b"mass = 32.7", b"mass = -1").replace(
    b"duty_factor = 0.8", b"duty_factor = 2"
)
DROP = """([name, data]) => {
  const dropped = new DataTransfer();
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  dropped.items.add(new File([bytes], name));
  return dropped;
}"""
PLAYBACK = """() => {
  const slider = document.querySelector("[role=slider][aria-valuemax]");
  const value = (name) => Number(slider?.getAttribute(`aria-value${name}`) ?? 0);
  const line = Number(document.querySelector("#walk line").getAttribute("x1"));
  return { line, share: value("now") / Math.max(value("max"), 1e-9) };
}"""
ROW = "#own-list li:first-child"


def drop(page: Page, name: str, content: bytes) -> None:
    """A file dropped on the page, until the server has said something of it."""
    held = page.evaluate_handle(DROP, [name, base64.b64encode(content).decode("ascii")])
    page.dispatch_event("body", "drop", {"dataTransfer": held})
    until(page, lambda: name in page.inner_text(ROW) and "reading" not in page.inner_text(ROW))


def playback(page: Page) -> dict[str, float]:
    """Where the line over the curves stands, and the part of the walk the player has shown."""
    found: dict[str, float] = page.evaluate(PLAYBACK)
    return found


@pytest.fixture(autouse=True)
def closed(page: Page) -> None:
    page.evaluate("document.getElementById('own-files').close()")


def test_a_dropped_picture_is_shown_understood_and_walked_on(address: str, page: Page) -> None:
    drop(page, "stairs.png", PICTURE)
    assert "8-bit grey picture" in page.inner_text(ROW)
    assert page.locator(f"{ROW} img").evaluate("each => each.naturalWidth") > 0
    page.click(f"{ROW} button")
    until(
        page, lambda: now(address)["scenario"] == "stairs.png" or not page.locator(ROW).is_visible()
    )
    until(page, lambda: not page.locator("#own-files").is_visible())


def test_a_dropped_robot_is_walked_with(address: str, page: Page) -> None:
    drop(page, "dog.toml", DOG)
    assert "dog: 33 kg quadruped (4 legs)" in page.inner_text(ROW)
    page.click(f"{ROW} button")
    until(page, lambda: now(address)["robot"] == "dog")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        (
            "bad.toml",
            BAD_DOG,
            ["mass must be positive", "duty_factor must be at least 0.5"],
        ),
        ("bad.png", b"no picture", ["bad.png cannot be read"]),
        ("bad.exe", b"x", ["must have a plain name that ends in one of"]),
    ],
)
def test_every_fault_of_a_bad_file_is_listed_and_the_walk_goes_on(
    address: str, page: Page, name: str, content: bytes, says: list[str]
) -> None:
    before = now(address)["robot"]
    drop(page, name, content)
    text = page.inner_text(ROW)
    assert all(said in text for said in says), text
    assert page.locator(f"{ROW} button").count() == 0
    assert now(address)["robot"] == before


def test_the_last_half_minute_is_saved_and_opens_without_a_server(
    address: str, page: Page, browser: Browser, tmp_path: Path
) -> None:
    drag_until(page, 0.0, 1.0, lambda: now(address)["distance_m"] > 0.05)
    page.mouse.up()
    with page.expect_download(timeout=120_000) as waiting:
        page.click("#save-walk")
    saved = tmp_path / "walk.html"
    waiting.value.save_as(saved)
    assert saved.stat().st_size < 3_000_000
    context = browser.new_context(offline=True, viewport={"width": 900, "height": 700})
    alone = context.new_page()
    alone.goto(saved.as_uri())
    try:
        until(alone, lambda: alone.locator("canvas").count() > 0 and detail(picture(alone)) > 8.0)
        assert "titan3" in alone.title()
        assert "Least margin" in alone.inner_text("#walk")
        assert alone.locator("#walk svg").count() == 3
        until(alone, lambda: playback(alone)["line"] > 3.0)
        before = playback(alone)
        until(alone, lambda: playback(alone)["line"] > before["line"])
        alone.keyboard.press("Space")
        alone.wait_for_function("() => document.querySelector('#walk output').textContent !== ''")
        for _ in range(20):
            shown = playback(alone)
            assert shown["line"] == pytest.approx(shown["share"] * 300.0, abs=1.0)
            alone.wait_for_timeout(20)
        alone.screenshot(path=tmp_path / "walk.png")
    finally:
        context.close()
