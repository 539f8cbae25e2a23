"""Every recorded walk, walked again: the same to the last bit."""

import pytest

from tests.corpus.walks import RECIPES, RECORDED, difference


@pytest.mark.parametrize("name", RECIPES)
def test_the_walk_is_the_recorded_one_bit_for_bit(name):
    assert difference(name) == ""


def test_every_recording_has_its_recipe():
    assert {path.stem for path in RECORDED.glob("*.jsonl")} == set(RECIPES)
