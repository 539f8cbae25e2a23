"""The console in a real browser: opened once for all tests, and on a phone."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from tests.web.browsing import (
    BROWSER,
    FLAGS,
    Fingers,
    Visit,
    Visits,
    begin_anew,
    detail,
    now,
    picture,
    take_over,
    until,
)


@pytest.fixture(scope="session")
def served(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """A console of its own: its address and its process."""
    with serving(tmp_path_factory.mktemp("served")) as found:
        yield found


@contextlib.contextmanager
def serving(data: Path, *options: str) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """A console with these options and a folder of its own: its address and its process."""
    asked = "-m walking_console serve --port 0 --no-open --scenario flat"
    words = [sys.executable, *asked.split(), *options]
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
        yield server.stdout.readline().strip(), server
    finally:
        server.terminate()
        server.communicate(timeout=15)


@pytest.fixture(scope="session")
def address(served: tuple[str, "subprocess.Popen[str]"]) -> str:
    return served[0]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def opened(address: str, browser: Browser) -> Iterator[Page]:
    """The console in one page; opened once, since the first drawing takes software a while."""
    visits = Visits(address, browser)
    page = visits.open(scene=True)
    until(
        page, lambda: page.frames[1].locator("canvas").count() > 0 and detail(picture(page)) > 8.0
    )
    yield page
    visits.close()


@pytest.fixture
def page(address: str, opened: Page) -> Iterator[Page]:
    """The open page, in the world it was opened on."""
    begin_anew(address)
    opened.evaluate("window.aside = false")
    yield opened
    opened.mouse.up()
    opened.evaluate("window.aside = true")


@pytest.fixture
def visit(address: str, browser: Browser) -> Iterator[Visit]:
    """Opens further pages, which are closed at the end of the test, however it ends."""
    begin_anew(address)
    visits = Visits(address, browser)
    yield visits.open
    visits.close()


@pytest.fixture
def phone(address: str, visit: Visit) -> Page:
    """The console on a phone held sideways."""
    page = visit(844, 390, has_touch=True, is_mobile=True)
    take_over(page)
    return page


@pytest.fixture
def fingers(address: str, phone: Page) -> Iterator[Fingers]:
    """Fingers on that phone, the first of them driving ahead."""
    found = Fingers(phone)
    found.drive_until(lambda: now(address)["walked_m_s"] > 0.0)
    yield found
    if 0 in found.down:
        found.lift(0)
