"""axe-core finds nothing serious on the page, at any size."""

from pathlib import Path

import pytest

from tests.web.browsing import IN_A_BROWSER, Visit

AXE = Path(__file__).resolve().parents[2] / "node_modules" / "axe-core" / "axe.min.js"
SIZES = [(1440, 900), (1024, 768), (844, 390), (390, 844), (720, 450)]  # the last: 200 % zoom

pytestmark = [
    *IN_A_BROWSER,
    pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: npm ci"),
]


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_axe_finds_nothing_serious(visit: Visit, size: tuple[int, int], theme: str) -> None:
    page = visit(*size, bypass_csp=True)
    if theme == "light":
        page.locator("#light-theme").evaluate("box => box.click()")
    assert page.evaluate("document.documentElement.dataset.theme") == theme
    for key in ("", "v", "o", "?"):  # the page itself, its menu, its dialogs
        if key == "?":
            page.keyboard.press("Escape")  # closes the dialog before
        if key:
            page.keyboard.press(key)
        page.evaluate(AXE.read_text("utf-8"))
        found = page.evaluate("axe.run(document, {iframes: false})")
        bad = [
            (violation["id"], [node["target"] for node in violation["nodes"]])
            for violation in found["violations"]
            if violation["impact"] in ("serious", "critical")
        ]
        assert bad == []
