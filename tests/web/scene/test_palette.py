"""One palette: legs told apart by everybody, one margin that is green, a short name for every
leg.
"""

import itertools

import numpy as np
import pytest

from tests.web.scene.snapshots import eight_legged
from walking_console.planner.robot.model import Leg, load_machine
from walking_console.web.scene.palette import (
    LEGS,
    MARGIN_GOOD,
    for_scene,
    leg_names,
    margin_share,
    rgb,
    style_of,
)

# Machado, Oliveira & Fernandes 2009, severity 1.0, in linear light
PROTANOPE = np.array(
    [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ]
)
DEUTERANOPE = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)
LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
OKLAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip


def seen(colour: str, sight: np.ndarray) -> np.ndarray:
    """OKLab of a colour as somebody sees it."""
    channels = np.array(rgb(colour)) / 255
    light = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return OKLAB @ np.cbrt(LMS @ np.clip(sight @ light, 0.0, 1.0))


def legs_at(*places: tuple[float, float]) -> list[Leg]:
    """Legs of one name around places."""
    return [Leg("leg", (x - 0.1, x + 0.1), (y - 0.1, y + 0.1), (-0.6, -0.4)) for x, y in places]


@pytest.mark.parametrize("sight", [np.eye(3), PROTANOPE, DEUTERANOPE])
def test_no_two_legs_have_colours_that_anybody_confuses(sight: np.ndarray) -> None:
    pairs = itertools.combinations([seen(colour, sight) for colour in LEGS], 2)
    assert min(np.linalg.norm(a - b) for a, b in pairs) > 0.06


def test_there_is_a_colour_for_each_of_eight_legs() -> None:
    assert len(set(LEGS)) == 8


def test_colours_are_made_stronger_for_the_scene_and_stay_colours() -> None:
    assert for_scene("#ffffff") == (255, 255, 255)
    assert for_scene("#ff8040") == (255, 79, 0)
    assert for_scene("#000000") == (0, 0, 0)


def test_a_margin_is_good_from_the_threshold_on() -> None:
    assert margin_share(MARGIN_GOOD) == margin_share(1.0) == 1.0
    assert margin_share(MARGIN_GOOD / 2) == pytest.approx(0.5)
    assert margin_share(0.0) == margin_share(-0.1) == margin_share(-float("inf")) == 0.0


def test_names_are_the_initials_of_what_the_machine_calls_its_legs() -> None:
    assert leg_names(load_machine("titan3").legs) == ("FL", "RL", "RR", "FR")
    assert leg_names(load_machine("hexapod").legs) == ("FL", "ML", "RL", "RR", "MR", "FR")
    assert leg_names(eight_legged().legs)[:2] == ("L0", "L1")


def test_legs_of_one_name_are_told_apart_by_their_places() -> None:
    five = legs_at((1, 1), (-1, 1), (-1, -1), (1, -1), (1.5, 0))
    assert leg_names(five) == ("FL", "RL", "RR", "FR", "F")
    seven = legs_at((1, 1), (0, 1), (-1, 1), (-1.5, 0), (-1, -1), (0, -1), (1, -1))
    assert leg_names(seven) == ("FL", "ML", "RL", "R", "RR", "MR", "FR")
    eight = legs_at(*((x, 1) for x in (3, 2, 1, 0)), *((x, -1) for x in (0, 1, 2, 3)))
    assert leg_names(eight) == ("FL", "2L", "3L", "RL", "RR", "3R", "2R", "FR")


def test_the_style_has_all_the_page_draws_with() -> None:
    style = style_of(load_machine("hexapod"))
    assert style["palette"]["legs"] == LEGS
    assert style["margin_good_m"] == MARGIN_GOOD
    assert style["leg_names"] == ("FL", "ML", "RL", "RR", "MR", "FR")
