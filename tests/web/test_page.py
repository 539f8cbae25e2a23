"""The page's files: no numbers or colours of its own where the server has them."""

import re
from pathlib import Path

import pytest
from PIL import Image

from tests.web.scenario_cards import SIZE
from walking_console.sim.scenario_files import scenario_names
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


def test_every_shipped_scenario_has_a_small_picture_on_its_card_and_no_other_has_one() -> None:
    cards = {card.stem: card for card in (PAGE / "cards").iterdir()}
    assert sorted(cards) == sorted(scenario_names())
    for card in cards.values():
        with Image.open(card) as picture:
            assert picture.size == SIZE and card.stat().st_size < 32_000


def test_the_cards_that_come_first_are_of_shipped_scenarios() -> None:
    gallery = (PAGE / "gallery.js").read_text("utf-8")
    best = re.findall(r'"([\w-]+)"', re.findall(r"BEST = \[(.*)\]", gallery)[0])
    assert len(best) == 6 and set(best) <= set(scenario_names())


def test_every_script_is_used() -> None:
    pages = (PAGE.parents[1] / "server" / "replay_page.py").read_text("utf-8")
    imported = {"main.js", "drive-worker.js", *re.findall(r'"([\w-]+\.js)"', pages)}
    for script in SCRIPTS:
        imported |= set(re.findall(r'(?:from|import) "\./([\w-]+\.js)"', script.read_text("utf-8")))
    assert {script.name for script in SCRIPTS} == imported
