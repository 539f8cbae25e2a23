"""Every scenario played from its card on the page to its ticked results, in a real browser.

Run: python -m tests.sweeps.cards [NAME ...]. Prints the table in docs/cards.md: how each ended and
what of the expected the page ticked off. The scene is left out, which only looks.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

from tests.web.browsing import BROWSER, FLAGS, Visits, now
from tests.web.conftest import serving

RATE = 8
LONGEST = 300.0  # s of wall time a scenario may take

HEAD = "| card | ended | simulated s | ticked off | crossed |\n|---|---|---|---|---|"


def names_on(page: Page) -> list[str]:
    """The scenarios that have a card, in the order of the page."""
    page.click("#gallery-button")
    found = page.locator("#cards .card small").all_inner_texts()
    page.keyboard.press("Escape")
    return found


def play_to_its_end(page: Page, address: str, name: str) -> str:
    """One row of the table."""
    page.click("#gallery-button")
    page.get_by_label(f"Play: {name}", exact=True).click()
    _wait(page, lambda: now(address)["scenario"] == name and bool(now(address)["playing"]))
    page.click(f"#rate [data-rate='{RATE}']")
    _wait(page, lambda: not now(address)["playing"])
    seconds = float(now(address)["time_s"])
    _wait(page, lambda: page.locator("#expected li").count() > 0, 5.0)
    ticked = page.locator("#expected li.good").count()
    crossed = page.locator("#expected li.bad").all_inner_texts()
    said = page.inner_text("#course-text")
    return f"| {name} | {said} | {seconds:.0f} | {ticked} | {'; '.join(crossed) or '–'} |"


def _wait(page: Page, holds: object, longest: float = LONGEST) -> None:
    assert callable(holds)
    end = time.monotonic() + longest
    while time.monotonic() < end and not holds():
        page.wait_for_timeout(100)


def sweep(browser: Browser, wanted: list[str]) -> None:
    """Print the table, row by row."""
    with tempfile.TemporaryDirectory() as data, serving(Path(data)) as (address, _):
        visits = Visits(address, browser)
        page = visits.open(1440, 900)
        print(HEAD)
        for name in wanted or names_on(page):
            print(play_to_its_end(page, address, name), flush=True)
        visits.close()


if __name__ == "__main__":
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        sweep(opened, sys.argv[1:])
        opened.close()
