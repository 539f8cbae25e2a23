"""The page's files: no numbers or colours of its own where the server has them."""

import re
from pathlib import Path

import pytest

from walking_console.web.scene import palette

PAGE = Path(__file__).resolve().parents[2] / "web" / "page"
SCRIPTS = sorted(PAGE.glob("*.js"))
INDEX = (PAGE / "index.html").read_text("utf-8")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_a_script_holds_no_leg_or_margin_colour(script: Path) -> None:
    ours = {*palette.LEGS, palette.GOOD, palette.BAD}
    found = {colour.lower() for colour in re.findall(r"#[0-9a-fA-F]{6}", script.read_text("utf-8"))}
    assert found.isdisjoint(ours)


def test_the_style_sheet_leaves_the_margins_colours_to_the_server() -> None:
    sheet = (PAGE / "style.css").read_text("utf-8")
    assert palette.GOOD not in sheet and palette.BAD not in sheet


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_every_element_a_script_asks_for_is_on_the_page(script: Path) -> None:
    asked = r"\b(?:element|div|button|input|write|restyle)\(\s*\"([\w-]+)\""
    for name in re.findall(asked, script.read_text("utf-8")):
        assert f'id="{name}"' in INDEX, name


def test_every_script_is_used() -> None:
    imported = {"main.js", "drive-worker.js"}
    for script in SCRIPTS:
        imported |= set(re.findall(r'from "\./([\w-]+\.js)"', script.read_text("utf-8")))
    assert {script.name for script in SCRIPTS} == imported
