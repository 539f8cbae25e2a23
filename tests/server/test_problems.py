"""A refusal carries field, value and limit, whatever the value was."""

import json
import math
from typing import Any

import pytest

from walking_console.server.problems import ERRORS_SHOWN, VALUE_SHOWN, problem, sayable

NESTED: list[Any] = []
for _ in range(100_000):
    NESTED = [NESTED]


def test_the_first_fault_also_stands_at_the_top() -> None:
    fault = {"field": "speed_m_s", "value": 9.0, "limit": {"le": 2.0}, "message": "too fast"}
    answer = problem(422, "speed_m_s: too fast", [fault] * 50, {"connection": "close"})
    body = json.loads(bytes(answer.body))
    assert (body["field"], body["value"], body["limit"]) == ("speed_m_s", 9.0, {"le": 2.0})
    assert body["title"] == "Unprocessable Entity" or body["title"] == "Unprocessable Content"
    assert len(body["errors"]) == ERRORS_SHOWN and answer.headers["connection"] == "close"
    assert answer.media_type == "application/problem+json"


def test_an_odd_status_still_has_a_title() -> None:
    assert json.loads(bytes(problem(499, "gone").body))["title"] == "Error"


@pytest.mark.parametrize(
    "value",
    [None, True, 7, 2**63, -(10**400), 0.5, math.nan, -math.inf, "x" * 9999, "\ud800", NESTED,
     {"a": 1}, {"a": {"b": 1}}, {str(n): n for n in range(99)}, {"k" * 999: 1}, b"\xff", object()],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_whatever_the_value_was_it_can_be_said_in_little(value: Any) -> None:
    text = json.dumps(sayable(value), allow_nan=False)
    assert len(text) <= 10 * VALUE_SHOWN
    text.encode()
