"""The pictures on the page's scenario cards: ``python -m tests.web.scenario_cards [NAME…]`` plays
every shipped scenario in a browser and keeps what it looks like on the way in ``web/page/cards``.
"""

import io
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from tests.web.browsing import BROWSER, FLAGS, Visits, load, now, tell
from tests.web.conftest import serving
from walking_console.sim.scenario_files import scenario_names

CARDS = Path(__file__).resolve().parents[2] / "web" / "page" / "cards"
SHOT = (640, 360)  # px, of the window
SIZE = (320, 180)  # px, of the card
QUALITY = 82
ON_THE_WAY = 12.0  # s walked until the picture
RATE = 4
SOONEST = 6.0  # s for the ground to be drawn
LATEST = 25.0  # s
BARE = "document.getElementById('overlay').style.visibility = 'hidden'"


def card_of(name: str) -> Path:
    return CARDS / f"{name}.jpg"


def take(page: Page, address: str, name: str) -> None:
    """Play a scenario for a while and keep its picture."""
    load(address, {"name": name})
    tell(address, "resume")
    tell(address, "play")
    begun = time.monotonic()
    while time.monotonic() - begun < LATEST:
        page.wait_for_timeout(250)
        seen = now(address)
        over = seen["time_s"] > ON_THE_WAY or not seen["playing"]
        if over and time.monotonic() - begun > SOONEST:
            break
    tell(address, "pause")
    page.wait_for_timeout(2500)
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB").resize(SIZE, Image.LANCZOS)
    shot.save(card_of(name), quality=QUALITY, optimize=True)
    print(name, card_of(name).stat().st_size, "bytes", flush=True)


def main(names: list[str]) -> None:
    CARDS.mkdir(exist_ok=True)
    with (
        tempfile.TemporaryDirectory() as data,
        serving(Path(data)) as (address, _),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        page = Visits(address, browser).open(*SHOT, scene=True)
        page.evaluate(BARE)
        page.wait_for_timeout(5000)
        page.request.post(f"{address}/api/v1/console/rate", data={"rate": RATE})
        for name in names:
            take(page, address, name)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:] or scenario_names())
