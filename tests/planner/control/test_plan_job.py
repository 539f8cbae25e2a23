"""What is asked for, planned, kept and forgotten between Levels B and C."""

import math

import pytest

from tests.planner.control.plans import AHEAD, STANCE, TITAN, Scripted, flat, swing_plan
from walking_console.planner.config import Planning
from walking_console.planner.control.handshake import ASKED, IDLE, READY
from walking_console.planner.control.plan_job import SLICE, PlanJob
from walking_console.planner.protocols import Announced
from walking_console.planner.types import Blocked, Command, Reason

GROUND = flat()
PLAN = swing_plan()
ASIDE = Command(1.0, 0.1)
ALIKE = Command(math.radians(5.0), 0.1)


FOUR = 4 * SLICE  # the work of a tick, in slices that say nothing of their weight


def job_of(*answers, slices=0, weight=None):
    planner = Scripted(*(answers or (PLAN,)), slices=slices, weight=weight)
    return PlanJob(planner, TITAN.yaw_length, Planning()), planner


def test_the_same_question_is_asked_once():
    job, planner = job_of()
    for _ in range(3):
        job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert planner.asked == [AHEAD] and job.ready is PLAN and job.answer(AHEAD) is PLAN


def test_planning_goes_on_by_so_many_slices_a_tick_and_the_flags_say_how_far_it_is():
    job, _ = job_of(slices=10)
    assert job.flags == IDLE
    for _ in range(2):
        job.begin_tick()
        job.consider(STANCE, AHEAD, GROUND, FOUR)
        assert job.flags == ASKED and job.ready is None
    job.begin_tick()
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert job.ready is PLAN and job.flags == READY


@pytest.mark.parametrize(("weight", "ticks"), [(0, 1), (1, 3), (7, 17), (100, 101)])
def test_slices_are_weighed_a_heavy_one_is_a_tick_s_work(weight, ticks):
    job, _ = job_of(slices=100, weight=weight)
    taken = 0
    while job.ready is None:
        job.begin_tick()
        job.consider(STANCE, AHEAD, GROUND, 40)
        taken += 1
    assert taken == ticks


@pytest.mark.parametrize(("weight", "ticks"), [(1, 1), (3, 4), (30, 5), (100, 5)])
def test_what_finishes_a_step_is_left_to_the_next_tick_where_this_one_has_no_room(weight, ticks):
    job, _ = job_of(slices=4, weight=Announced(weight))
    job.consider(STANCE, AHEAD, GROUND, 5)
    taken = 1
    while job.ready is None:
        job.begin_tick()
        job.consider(STANCE, AHEAD, GROUND, 5)
        taken += 1
    assert taken == ticks


def test_what_finishes_a_step_that_is_waited_for_is_done_at_once():
    job, planner = job_of(slices=4, weight=Announced(100))
    job.consider(STANCE, AHEAD, GROUND, 5, is_waited_for=True)
    assert job.ready is PLAN and planner.hurried == 0
    job.forget()
    job.consider(STANCE, AHEAD, GROUND, 5)
    assert job.ready is None
    job.begin_tick()
    assert job.answer_standing(STANCE, AHEAD, GROUND) is PLAN


def test_what_was_left_to_the_next_tick_does_not_count_for_another_step():
    job, planner = job_of(slices=1, weight=Announced(100))
    job.consider(STANCE, AHEAD, GROUND, 5)
    planner.weight = 4
    job.begin_tick()
    job.consider(STANCE, ASIDE, GROUND, 5)
    assert job.ready is PLAN


def test_what_was_done_in_a_tick_counts_for_all_that_is_asked_in_it():
    job, _ = job_of(slices=5)
    for _ in range(4):
        job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert job.ready is None
    job.begin_tick()
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert job.ready is PLAN


def test_a_job_that_has_not_begun_cannot_be_told_that_its_answer_is_wanted():
    job, planner = job_of(slices=10**6)
    for _ in range(Planning().wait_max):
        job.begin_tick()
        job.answer_standing(STANCE, AHEAD, GROUND)
    assert planner.hurried == 1
    job.forget()
    job.begin_tick()
    assert job.answer_standing(STANCE, ASIDE, GROUND) is PLAN
    assert planner.hurried == 2 and planner.asked == [AHEAD, ASIDE]


@pytest.mark.parametrize("other", [flat(), None])
def test_another_map_or_stance_begins_anew(other):
    job, planner = job_of()
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    stance = STANCE if other is not None else swing_plan().end
    job.consider(stance, AHEAD, other or GROUND, FOUR)
    assert len(planner.asked) == 2


def test_a_stick_that_trembles_does_not_begin_anew_before_there_is_an_answer():
    job, planner = job_of(slices=10)
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    job.begin_tick()
    job.consider(STANCE, ALIKE, GROUND, FOUR)
    assert planner.asked == [AHEAD]
    job.begin_tick()
    job.consider(STANCE, ASIDE, GROUND, FOUR)
    assert planner.asked == [AHEAD, ASIDE]


def test_a_step_that_is_ready_is_kept_for_commands_like_its_own_while_the_next_is_planned():
    job, planner = job_of()
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    planner.slices = 100
    job.consider(STANCE, ALIKE, GROUND, FOUR)
    assert planner.asked == [AHEAD, ALIKE]
    assert job.ready is None and job.answer(ALIKE) is PLAN and job.answer(ASIDE) is None


def test_commands_are_alike_by_direction_and_not_by_speed():
    job, _ = job_of()
    assert job.alike(AHEAD, Command(0.0, 0.5)) and job.alike(AHEAD, ALIKE)
    assert not job.alike(AHEAD, ASIDE) and not job.alike(AHEAD, Command())
    assert not job.alike(AHEAD, Command(0.0, 0.1, 0.2)) and job.alike(Command(), Command())


def test_from_a_standstill_the_best_so_far_is_asked_for_after_a_few_ticks():
    job, planner = job_of(slices=10**6)
    answers = []
    for _ in range(Planning().wait_max):
        job.begin_tick()
        answers.append(job.answer_standing(STANCE, AHEAD, GROUND))
    assert answers[:-1] == [None] * (len(answers) - 1) and answers[-1] is PLAN
    assert planner.hurried == 1


def test_the_stance_asked_from_stays_while_map_and_course_do():
    job, _ = job_of()
    assert job.stance_asked(AHEAD, GROUND) is None
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert job.stance_asked(ALIKE, GROUND) is STANCE
    assert job.stance_asked(ASIDE, GROUND) is None and job.stance_asked(AHEAD, flat()) is None


def test_resting_forgets_all_but_a_job_that_is_to_go_on():
    job, _ = job_of(slices=100)
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    job.refused = (AHEAD, GROUND)
    job.rest(keep_job=True)
    assert job.asked is not None and job.refused is None and job.flags == ASKED
    job.rest()
    assert job.asked is None and job.flags == IDLE and job.answer(AHEAD) is None


def test_a_refusal_is_an_answer_too_and_no_ready_step():
    refusal = Blocked(Reason.NO_DIRECTION)
    job, _ = job_of(refusal)
    job.consider(STANCE, AHEAD, GROUND, FOUR)
    assert job.answer(AHEAD) is refusal and job.ready is None
