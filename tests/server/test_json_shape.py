"""A text that no reader should have to bear is refused before it is parsed."""

import json
import random

import pytest

from walking_console.server.json_shape import fault_of
from walking_console.server.limits import BODY_MAX, JSON_DEPTH_MAX, NUMBER_MAX


@pytest.mark.parametrize(("opening", "closing"), ["[]", ('{"a":', "}"), ('[{"a":', "}]")])
def test_depth_is_counted_whatever_the_brackets(opening: str, closing: str) -> None:
    each = opening.count("[") + opening.count("{")
    most = JSON_DEPTH_MAX // each
    assert fault_of((opening * most + "1" + closing * most).encode()) == ""
    deeper = most + 1
    assert "deep" in fault_of((opening * deeper + "1" + closing * deeper).encode())
    assert "deep" in fault_of((opening * 100_000).encode()), "also where it never ends"


def test_brackets_and_digits_within_strings_are_letters() -> None:
    text = json.dumps({"title": "[" * 100 + '\\"' + "{" * 100, "note": "1" * 1000})
    assert fault_of(text.encode()) == ""


@pytest.mark.parametrize("number", ["1" * (NUMBER_MAX + 1), "1e" + "9" * 100, "0." + "0" * 5000])
def test_a_number_of_too_many_characters_is_refused(number: str) -> None:
    assert "number" in fault_of(f'{{"speed_m_s": {number}}}'.encode())


def test_what_programs_write_passes() -> None:
    chance = random.Random(1)
    rows = [[chance.uniform(-1e-300, 1e300) for _ in range(40)] for _ in range(500)]
    text = json.dumps({"scenario": {"terrain": {"kind": "heights", "rows": rows}}}).encode()
    assert len(text) < BODY_MAX and fault_of(text) == ""
