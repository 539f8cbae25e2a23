"""The pictures of the README: ``python -m tests.web.readme_pictures`` plays two scenarios in a
browser, takes the stick over on the way and keeps what the page looks like in ``docs``.
"""

import io
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from tests.web.browsing import BROWSER, FLAGS, Visits, drag_until, load, now, tell, until
from tests.web.conftest import serving

DOCS = Path(__file__).resolve().parents[2] / "docs"
WINDOW = (1440, 900)  # px
SIZE = (1200, 750)  # px, of the picture
QUALITY = 88
ON_THE_WAY = 20.0  # s played until the stick is taken
HELD = 6000  # ms until the picture
CAUGHT_UP = 4000  # ms; drawing by software lags behind what moves
PICTURES = {"console": ("dem", 0.3), "hexapod": ("k-curve", 0.0)}  # scenario, stick to the right


def take(page: Page, address: str, picture: str) -> None:
    """Play a scenario for a while, take the stick over and keep the picture."""
    scenario, right = PICTURES[picture]
    load(address, {"name": scenario})
    tell(address, "play")
    page.click("[data-rate='4']")
    until(page, lambda: now(address)["time_s"] > ON_THE_WAY)
    page.click("[data-rate='1']")
    drag_until(page, right, 0.95, lambda: not now(address)["playing"])
    page.wait_for_timeout(HELD)
    tell(address, "pause")
    page.wait_for_timeout(CAUGHT_UP)
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB").resize(SIZE, Image.LANCZOS)
    page.mouse.up()
    tell(address, "resume")
    kept = DOCS / f"{picture}.jpg"
    shot.save(kept, quality=QUALITY, optimize=True)
    print(kept.name, kept.stat().st_size, "bytes", flush=True)


def main() -> None:
    with (
        tempfile.TemporaryDirectory() as data,
        serving(Path(data)) as (address, _),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        page = Visits(address, browser).open(*WINDOW, path="/?stand&sharp", scene=True)
        page.wait_for_timeout(5000)
        for picture in PICTURES:
            take(page, address, picture)
        browser.close()


if __name__ == "__main__":
    main()
