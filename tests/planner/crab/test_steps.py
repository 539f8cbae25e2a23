"""The words of Level B2."""

from walking_console.planner.crab.steps import BodyShift, Landing, Shift, SwingStep

LANDING = Landing(0.5, 0.4, 1.5, -0.6)


def test_a_shift_and_the_step_made_of_it_begin_alike_so_that_either_can_be_held_against_heights():
    shift = Shift(2, 0.05, 0.15, -0.02, 0.3)
    step = SwingStep(shift.leg, shift.g0, shift.g, (0.5, 0.4), LANDING, 0.03, True)
    assert shift[:3] == step[:3] == (2, 0.05, 0.15)
    assert shift.inset == 0.0


def test_every_candidate_has_a_margin():
    step = SwingStep(2, 0.05, 0.15, (0.5, 0.4), LANDING, 0.03, True)
    assert [candidate.margin for candidate in (step, BodyShift(0.1, 0.0, 0.02))] == [0.03, 0.02]
