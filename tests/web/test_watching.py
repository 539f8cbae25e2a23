"""The page of a link that may watch and stop, not drive."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.web.browsing import IN_A_BROWSER, Visits, until
from tests.web.conftest import serving

pytestmark = IN_A_BROWSER

DRIVER, WATCHER = "d" * 32, "w" * 32
DRIVES = "#stick #top-speed #play #reset #pause #brush-button #postures".split()


@pytest.fixture
def visits(tmp_path: Path, browser: Browser) -> Iterator[Visits]:
    """Pages on a console with a link for drivers and one for watchers."""
    with serving(tmp_path, "--token", DRIVER, "--viewer-token", WATCHER) as (address, _):
        found = Visits(address.split("/login")[0], browser)
        yield found
        found.close()


def test_who_may_only_watch_is_offered_nothing_that_drives_and_stops_all_the_same(
    visits: Visits,
) -> None:
    watcher = visits.open(path=f"/login?token={WATCHER}")
    until(watcher, lambda: watcher.inner_text("#lease") == "you watch · nobody drives")
    watcher.wait_for_timeout(1000)
    assert watcher.inner_text("#distance") == "0.00", "nothing is played"
    assert not watcher.locator("#toast").is_visible()
    assert not any(watcher.locator(one).is_visible() for one in [*DRIVES, "#take"])
    assert watcher.locator("#scenario").is_disabled()
    driver = visits.open(path=f"/login?token={DRIVER}")
    until(watcher, lambda: watcher.inner_text("#distance") != "0.00")
    watcher.click("#stop")
    until(driver, lambda: driver.inner_text("#lease") == "stopped")
    until(watcher, lambda: watcher.inner_text("#lease") == "you watch · stopped")
    assert all(driver.locator(one).is_visible() for one in DRIVES)
