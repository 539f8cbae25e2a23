"""The decision log: filled only when there is one, and what is read out of it."""

from walking_console.planner.crab.step_refusals import StepRefusal
from walking_console.planner.decision_log import (
    note_cell,
    note_leg,
    note_reason,
    note_search,
    reasons_of,
    refused_cells,
)


def test_without_a_log_nothing_is_noted():
    trial = note_leg(None, 2, g=0.1)
    assert trial is None
    note_reason(trial, StepRefusal.MISSES)
    note_cell(trial, 0.0, 1.0, StepRefusal.PROHIBITED)
    note_search(None, "near", 6, [{"score": 1.0}])


def test_a_leg_is_noted_by_its_number_with_its_facts_its_cells_and_its_reason():
    log = {}
    trial = note_leg(log, 2, g=0.1)
    note_cell(trial, 0.5, -1.0, StepRefusal.PROHIBITED)
    note_reason(trial, StepRefusal.NO_FOOTHOLD)
    cell = {"x": 0.5, "y": -1.0, "reason": "prohibited cell"}
    reason = "no foothold in the search domain"
    assert log == {"legs": [{"leg": 3, "g": 0.1, "refused": [cell], "reason": reason}]}
    assert reasons_of(log) == f"leg 3: {reason}"
    assert refused_cells(log, 5) == [cell] and refused_cells(log, 0) == []


def test_a_leg_without_a_reason_is_told_of_with_the_words_given():
    log = {}
    note_leg(log, 0)
    note_leg(log, 1)
    assert reasons_of(log, "no gain") == "leg 1: no gain; leg 2: no gain"
    assert reasons_of({}) == "" and refused_cells({}, 3) == []


def test_a_search_is_noted_with_its_horizon_and_all_it_weighed():
    log = {}
    note_search(log, "turn", 9, ({"score": float(k)} for k in range(2)))
    candidates = [{"score": 0.0}, {"score": 1.0}]
    assert log == {"lookahead": {"search": "turn", "horizon": 9, "candidates": candidates}}


def test_no_two_refusals_are_told_alike():
    texts = [refusal.value for refusal in StepRefusal]
    assert len(texts) == len(set(texts)) and all(texts)
