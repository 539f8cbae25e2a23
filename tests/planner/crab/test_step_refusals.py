"""Refusals are data with a text for a screen: plain phrases that fit behind "leg 3:"."""

from walking_console.planner.crab.step_refusals import StepRefusal


def test_every_refusal_is_a_phrase_of_its_own_that_goes_behind_a_leg():
    texts = [refusal.value for refusal in StepRefusal]
    assert len(set(texts)) == len(texts) == len(StepRefusal.__members__)
    for text in texts:
        assert text[0].islower() and not text.endswith(".") and ";" not in text
