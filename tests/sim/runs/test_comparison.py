"""Two measurements against each other."""

from typing import Any

import pytest

from walking_console.sim.runs.comparison import ComparisonError, compared


def figures(**values: float) -> dict[str, Any]:
    return {"figures": {name: {"value": v, "unit": "µs"} for name, v in values.items()}}


def walk(scenario: str, median: float, **others: Any) -> dict[str, Any]:
    entry = {
        "scenario": scenario,
        "planner": "crab",
        "plant": "kinematic",
        "sensing": "known",
        "seconds": 2.0,
        "median": median,
        "p99": 1.0,
        "p999": 2.0,
        "largest": 4.0,
        "per_metre": 10.0,
        "factor": 100.0,
    }
    return entry | others


def test_a_figure_is_set_against_that_of_the_same_name() -> None:
    ratios = compared(figures(plan=150.0, tick=20.0), figures(plan=100.0, start=3.0))
    assert [(each.what, each.figure, each.ratio) for each in ratios] == [("plan", "µs", 1.5)]


def test_a_walk_is_set_against_the_same_walk_figure_by_figure() -> None:
    now = {"walks": [walk("dem", 0.02), walk("flat", 0.01)]}
    before = {"walks": [walk("flat", 0.02, factor=80.0), walk("gap", 1.0)]}
    ratios = compared(now, before)
    assert {each.what for each in ratios} == {"flat crab kinematic known"}
    found = {each.figure: each.ratio for each in ratios}
    assert found["median"] == 0.5 and found["factor"] == 1.25
    assert set(found) == {"median", "p99", "p999", "largest", "per_metre", "factor"}


@pytest.mark.parametrize("other", [{"sensing": "eye"}, {"plant": "physics"}, {"seconds": None}])
def test_what_was_walked_otherwise_is_not_the_same_walk(other: dict[str, Any]) -> None:
    with pytest.raises(ComparisonError, match="no figure is in both"):
        compared({"walks": [walk("flat", 0.01)]}, {"walks": [walk("flat", 0.01, **other)]})


def test_a_walk_that_went_nowhere_has_no_time_a_metre_to_compare() -> None:
    stood = {"walks": [walk("flat", 0.01, per_metre=None)]}
    assert "per_metre" not in {each.figure for each in compared(stood, stood)}


@pytest.mark.parametrize("before", [[], "words", {"walks": 3}, {"walks": [{}]}, {"figures": []}])
def test_another_file_is_refused_in_one_line(before: Any) -> None:
    with pytest.raises(ComparisonError, match="no file of bench|no figure"):
        compared({"walks": [walk("flat", 0.01)], **figures(plan=1.0)}, before)
