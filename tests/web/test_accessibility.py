"""axe-core finds nothing serious on the page, at any size."""

from pathlib import Path

import pytest
from playwright.sync_api import Page

from tests.web.browsing import IN_A_BROWSER, Visit

AXE = Path(__file__).resolve().parents[2] / "node_modules" / "axe-core" / "axe.min.js"
SIZES = [(1440, 900), (1024, 768), (844, 390), (390, 844), (720, 450)]  # the last: 200 % zoom

pytestmark = [
    *IN_A_BROWSER,
    pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: npm ci"),
]


def found_by_axe(page: Page, *rules: str) -> list[tuple[str, list[str]]]:
    """What is serious or critical: by these rules, or by all."""
    how = {"iframes": False, **({"runOnly": list(rules)} if rules else {})}
    found = page.evaluate("how => axe.run(document, how)", how)
    return [
        (violation["id"], [node["target"] for node in violation["nodes"]])
        for violation in found["violations"]
        if violation["impact"] in ("serious", "critical")
    ]


@pytest.mark.parametrize("size", SIZES)
def test_axe_finds_nothing_serious_in_either_theme(visit: Visit, size: tuple[int, int]) -> None:
    page = visit(*size, bypass_csp=True)
    page.evaluate(AXE.read_text("utf-8"))
    for key in ("", "v", "o", "?"):  # the page itself, its menu, its dialogs
        if key == "?":
            page.keyboard.press("Escape")  # closes the dialog before
        if key:
            page.keyboard.press(key)
        assert found_by_axe(page) == []
        page.evaluate("document.getElementById('light-theme').click()")
        assert page.evaluate("document.documentElement.dataset.theme") == "light"
        assert found_by_axe(page, "color-contrast", "link-in-text-block") == []
        page.evaluate("document.getElementById('light-theme').click()")
