"""Level B1: straight where that can be walked, a trapezoid round what cannot be crossed, back to
the line, else a reason.
"""

import math
from dataclasses import replace
from itertools import combinations, groupby

import numpy as np
import pytest

from walking_console.planner.config import DEFAULT, Navigation
from walking_console.planner.motion.step_builder import holding_plan
from walking_console.planner.navigation.local_planner import (
    ON_LINE,
    STAYS_MAX,
    LocalPlanner,
    RouteState,
    plan_route,
)
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Command, Reason, Stance
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

MACHINE = load_machine("titan3")
CELL, LOW, SIZE = 0.05, -6.0, 400
HIGH = LOW + SIZE * CELL
STRIDE = 0.15  # m a step, about what the standard walk does
FEET = ((0.4, 0.4, 0.0), (-0.4, 0.4, 0.0), (-0.4, -0.4, 0.0), (0.4, -0.4, 0.0))


def at(v):
    return round((v - LOW) / CELL)


def level():
    return np.zeros((SIZE, SIZE))


def with_hole(x1, x2, y1, y2, heights=None):
    heights = level() if heights is None else heights
    heights[at(y1) : at(y2), at(x1) : at(x2)] = np.nan
    return heights


def map_of(heights, forbidden=None, known=None):
    return TerrainMap(
        heights,
        np.isnan(heights) if forbidden is None else forbidden,
        CELL,
        (LOW, LOW),
        known=known,
    )


def stance_at(x=0.0, y=0.0, yaw=0.0):
    return Stance((x, y, 0.85, yaw), FEET)


AHEAD = Command(0.0, 0.08)


def walked(terrain, command=AHEAD, yaw=0.0, length=7.0, x=0.0, y=0.0):
    """The body walked by B1 alone, one stride a call: places, courses against the line, and how it
    ended.
    """
    state, places, courses, why = RouteState(), [(x, y)], [], None
    while math.hypot(x, y) < length and len(places) < 200:
        steered, state, why = plan_route(state, command, stance_at(x, y, yaw), terrain, MACHINE)
        if why is not None:
            break
        x += STRIDE * math.cos(yaw + steered.crab_angle)
        y += STRIDE * math.sin(yaw + steered.crab_angle)
        places.append((x, y))
        courses.append(state.offset)
    return places, courses, why


def turned(places, heading):
    c, s = math.cos(heading), math.sin(heading)
    return [(c * x + s * y, c * y - s * x) for x, y in places]


def changes(courses):
    return sum(abs(b - a) > math.radians(3.0) for a, b in zip(courses, courses[1:], strict=False))


# where nothing is in the way


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, -2.5])
def test_on_open_ground_the_command_is_the_very_same(angle):
    command, state = Command(angle, 0.08), RouteState()
    terrain = map_of(level())
    for step in range(5):
        along = step * STRIDE
        steered, state, why = plan_route(
            state,
            command,
            stance_at(along * math.cos(angle), along * math.sin(angle)),
            terrain,
            MACHINE,
        )
        assert steered is command and why is None and not state.detours


@pytest.mark.parametrize("fraction", [0.1, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("seed", range(2))
def test_scattered_holes_are_no_reason_to_leave_the_line(fraction, seed):
    heights = np.where(np.random.default_rng(seed).random((SIZE, SIZE)) < fraction, np.nan, 0.0)
    places, courses, why = walked(map_of(heights), length=4.0)
    assert why is None and set(courses) == {0.0}


def test_a_river_as_wide_as_the_mechanical_reach_is_crossed_and_a_wider_one_is_not():
    stroke = MACHINE.reach.x_span
    for width in (stroke, stroke + 2 * MACHINE.overreach[0]):
        _, courses, why = walked(map_of(with_hole(2.0, 2.0 + width, LOW, HIGH)))
        assert why is None and set(courses) == {0.0}
    places, courses, why = walked(map_of(with_hole(2.0, 2.2 + stroke, LOW, HIGH)))
    assert why is not None and "no way round" in why.text and "would find no foothold" in why.text
    assert places[-1][0] < 2.0


def test_a_hole_wider_than_the_stroke_is_gone_round_rather_than_stretched_over():
    width = MACHINE.reach.x_span + 2 * MACHINE.overreach[0]
    _, courses, why = walked(map_of(with_hole(2.0, 2.0 + width, -0.8, 0.8)))
    assert why is None and set(courses) != {0.0}


def test_what_fits_between_the_legs_is_stepped_over():
    _, courses, why = walked(map_of(with_hole(1.5, 4.0, -0.25, 0.25)))
    assert why is None and set(courses) == {0.0}


def test_a_low_block_is_walked_over_and_no_leg_needs_telling():
    heights = level()
    heights[at(-1) : at(1), at(2) : at(3)] = 0.2
    _, courses, why = walked(map_of(heights))
    assert why is None and set(courses) == {0.0}


def test_a_turning_command_and_a_hold_are_passed_on():
    terrain = map_of(with_hole(1.0, 3.0, -1.0, 1.0))
    for command in (Command(0.0, 0.08, 0.1), Command()):
        steered, state, why = plan_route(RouteState(), command, stance_at(), terrain, MACHINE)
        assert steered is command and state == RouteState() and why is None


# round what cannot be crossed


@pytest.mark.parametrize("yaw", [0.0, 0.7])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.0, 0.28])
def test_a_large_hole_is_gone_round_in_a_trapezoid_and_the_line_found_again(angle, yaw, side):
    heading = yaw + angle
    y, x = np.indices((SIZE, SIZE)) * CELL + LOW + CELL / 2
    along, across = (
        math.cos(heading) * x + math.sin(heading) * y,
        side * (math.cos(heading) * y - math.sin(heading) * x),
    )
    hole = (along > 2.5) & (along < 3.5) & (across > -0.7) & (across < 1.0)
    places, courses, why = walked(
        map_of(np.where(hole, np.nan, 0.0)), Command(angle, 0.08), yaw, length=8.0
    )
    assert why is None
    offsets = [d for _, d in turned(places, heading)]
    assert abs(offsets[-1]) < 0.1
    # round the nearer end
    assert max(-side * d for d in offsets) > 0.9 and max(side * d for d in offsets) < 0.1
    assert changes(courses) <= 5  # out, along, back, on, and one to spare


def test_every_leg_finds_a_foothold_all_the_way_round():
    heights = with_hole(2.5, 3.5, -0.8, 0.9)
    terrain = map_of(heights)
    places, _, _ = walked(terrain)
    for (x1, y1), (x2, y2) in zip(places, places[1:], strict=False):
        for part in np.linspace(0.0, 1.0, 8):
            x, y = x1 + part * (x2 - x1), y1 + part * (y2 - y1)
            for box in MACHINE.boxes:
                patch = terrain.forbidden[
                    at(y + box[2]) : at(y + box[3]) + 1, at(x + box[0]) : at(x + box[1]) + 1
                ]
                assert not patch.all()


def test_a_wall_too_tall_to_step_over_is_gone_round():
    heights = level()
    heights[at(-1.2) : at(1.2), at(2.0) : at(2.1)] = 1.5
    places, _, why = walked(map_of(heights, heights > 1.0), length=9.0)
    assert why is None and abs(places[-1][1]) < 0.1
    assert max(abs(y) for _, y in places) > 1.4


def test_a_pole_that_the_torso_would_hit_is_gone_round():
    heights = level()
    heights[at(-0.05) : at(0.05), at(3.0) : at(3.1)] = 1.5
    places, _, why = walked(map_of(heights, heights > 1.0))
    assert why is None and abs(places[-1][1]) < 0.1
    assert all(abs(y) > 0.29 for x, y in places if abs(x - 3.05) < 0.5)


def test_seen_late_a_hole_is_gone_round_sideways():
    places, courses, why = walked(map_of(with_hole(0.8, 2.0, -1.0, 1.2)), length=6.0)
    assert why is None and abs(places[-1][1]) < 0.1
    assert courses[0] == pytest.approx(-math.pi / 2)


def test_a_way_that_comes_up_on_the_way_round_is_taken_account_of():
    """The eye sees a second hole only when the first one's corner is being made for."""
    first, both = (
        map_of(with_hole(2.5, 3.5, -0.8, 0.9)),
        map_of(with_hole(1.2, 3.0, -2.5, -0.5, with_hole(2.5, 3.5, -0.8, 0.9))),
    )
    command = Command(0.0, 0.08)
    steered, state, _ = plan_route(RouteState(), command, stance_at(), first, MACHINE)
    assert steered.crab_angle < -0.3
    steered, state, why = plan_route(state, command, stance_at(0.1, -0.05), both, MACHINE)
    assert why is None and steered.crab_angle > 0.3


# no way, unknown ground, refusals


def test_where_nothing_works_it_says_what_fails():
    heights = level()
    heights[:, at(1.0) :] = 0.9
    _, _, why = walked(map_of(heights))
    assert isinstance(why, Blocked) and "no way round within 2 m to either side" in why.text
    assert "too steep" in why.text or "lifted over" in why.text


def test_the_edge_of_the_map_is_no_ground():
    _, _, why = plan_route(
        RouteState(), Command(0.0, 0.08), stance_at(HIGH - 0.4, 0.0), map_of(level()), MACHINE
    )
    assert why is not None and "no foothold" in why.text


def test_unknown_ground_ahead_slows_and_does_not_stop():
    known = np.zeros((SIZE, SIZE), dtype=bool)
    known[:, : at(1.6)] = True
    terrain = map_of(level(), forbidden=~known, known=known)
    far, _, _ = plan_route(RouteState(), Command(0.0, 0.08), stance_at(-1.0), terrain, MACHINE)
    near, state, why = plan_route(
        RouteState(), Command(0.0, 0.08), stance_at(0.6), terrain, MACHINE
    )
    at_it, _, _ = plan_route(RouteState(), Command(0.0, 0.08), stance_at(1.5), terrain, MACHINE)
    heedless, _, _ = plan_route(
        RouteState(), Command(0.0, 0.08), stance_at(0.6), terrain, MACHINE, cautious=False
    )
    assert why is None and near.crab_angle == 0.0
    assert far.speed == heedless.speed == 0.08 and at_it.speed == 0.25 * 0.08 < near.speed < 0.08
    assert state.speed_limit == near.speed


def test_a_refused_course_is_not_offered_again():
    terrain, command = map_of(with_hole(2.5, 3.5, -0.8, 0.9)), Command(0.0, 0.08)
    offered = []
    for _ in range(3):
        steered, state, why = plan_route(
            RouteState(), command, stance_at(), terrain, MACHINE, refused=tuple(offered)
        )
        assert why is None
        assert all(abs(state.offset - other) >= math.radians(8.0) for other in offered)
        offered.append(state.offset)


# the line


def test_the_line_goes_through_where_the_course_was_last_commanded():
    terrain, state = map_of(level()), RouteState()
    _, state, _ = plan_route(state, Command(0.0, 0.08), stance_at(1.0, 0.5), terrain, MACHINE)
    _, state, _ = plan_route(state, Command(0.0, 0.05), stance_at(1.3, 0.5), terrain, MACHINE)
    assert state.line[:2] == (1.0, 0.5)  # a change of speed is no new course
    _, state, _ = plan_route(state, Command(0.4, 0.05), stance_at(1.6, 0.5), terrain, MACHINE)
    assert state.line == (1.6, 0.5, 0.4)


@pytest.mark.parametrize("off", [0.05, 0.4, -1.3])
def test_pushed_off_the_line_it_comes_back_and_then_leaves_the_command_alone(off):
    terrain, command = map_of(level()), Command(0.0, 0.08)
    _, state, _ = plan_route(RouteState(), command, stance_at(), terrain, MACHINE)
    x, y = 0.2, off
    for _ in range(60):
        steered, state, _ = plan_route(state, command, stance_at(x, y), terrain, MACHINE)
        assert abs(state.offset) < math.radians(23.0)
        x, y = x + STRIDE * math.cos(steered.crab_angle), y + STRIDE * math.sin(steered.crab_angle)
    assert abs(y) <= ON_LINE and steered is command


@pytest.mark.parametrize("off", [0.08, -0.2])
def test_among_scattered_holes_a_small_offset_is_not_kept_for_ever(off):
    terrain = map_of(np.where(np.random.default_rng(1).random((SIZE, SIZE)) < 0.2, np.nan, 0.0))
    _, state, _ = plan_route(RouteState(), AHEAD, stance_at(), terrain, MACHINE)
    x, y = 0.2, off
    for _ in range(35):
        steered, state, _ = plan_route(state, AHEAD, stance_at(x, y), terrain, MACHINE)
        x, y = x + STRIDE * math.cos(steered.crab_angle), y + STRIDE * math.sin(steered.crab_angle)
    assert abs(y) <= ON_LINE and steered is AHEAD


def test_a_torso_that_has_turned_keeps_the_line():
    terrain, command = map_of(level()), Command(0.2, 0.08)
    _, state, _ = plan_route(RouteState(), command, stance_at(), terrain, MACHINE)
    steered, _, _ = plan_route(state, command, stance_at(yaw=0.05), terrain, MACHINE)
    assert steered.crab_angle == pytest.approx(0.15)


def test_asked_twice_it_answers_the_same():
    terrain, command = map_of(with_hole(2.5, 3.5, -0.8, 0.9)), Command(0.0, 0.08)
    first = plan_route(RouteState(), command, stance_at(), terrain, MACHINE)
    assert plan_route(RouteState(), command, stance_at(), terrain, MACHINE) == first
    again = plan_route(first[1], command, stance_at(), terrain, MACHINE)
    assert again[0] == first[0] and replace(again[1], way=()) == replace(first[1], way=())


# places


def test_a_body_standing_where_it_should_not_may_leave():
    heights = with_hole(0.1, 0.8, 0.2, 0.75)
    places, _, why = walked(map_of(heights), length=2.0)
    assert why is None and math.hypot(*places[-1]) >= 2.0


def test_a_planner_of_steps_is_asked_for_another_course_where_it_finds_none():
    asked = []

    def steps(stance, command, terrain):
        asked.append(command.crab_angle)
        return Blocked(Reason.NO_DIRECTION)
        yield

    terrain = map_of(with_hole(1.0, 1.4, -0.6, 0.6))
    for most in (1, 2, DEFAULT.navigation.courses_max):
        asked.clear()
        local = LocalPlanner(settings=Navigation(courses_max=most))
        answer = run_to_completion(local.plan(steps, MACHINE, stance_at(), AHEAD, terrain))
        assert isinstance(answer, Blocked) and len(set(asked)) == len(asked) == most


def marking_time(steps):
    """A machine whose feet have moved and whose body has not."""
    stance = stance_at()
    (x, y, z), *others = stance.feet
    return replace(stance, feet=((x + 0.001 * steps, y, z), *others))


def test_a_course_on_which_the_body_does_not_get_on_is_left_for_another_until_it_does():
    asked = []

    def steps(stance, command, terrain):
        asked.append(command.crab_angle)
        yield None
        return holding_plan(stance)

    terrain = map_of(with_hole(0.8, 2.0, -0.8, 0.4))
    local = LocalPlanner()
    for k in range(3 * STAYS_MAX):
        for _ in range(3):  # planned anew from one stance it is no other step
            run_to_completion(local.plan(steps, MACHINE, marking_time(k), AHEAD, terrain))
    runs = [(course, len(list(same))) for course, same in groupby(asked[::3])]
    courses = [course for course, _ in runs]
    assert len(set(courses)) == len(courses) >= 3 and runs[1][1] == STAYS_MAX
    assert min(abs(a - b) for a, b in combinations(courses, 2)) > math.radians(8.0)
    run_to_completion(local.plan(steps, MACHINE, stance_at(0.06), AHEAD, terrain))
    assert local.route.stays.courses == ()


def test_on_the_line_itself_a_body_that_gets_on_slowly_is_sent_on_no_other_course():
    asked = []

    def steps(stance, command, terrain):
        asked.append(command.crab_angle)
        yield None
        return holding_plan(stance)

    local = LocalPlanner()
    for k in range(3 * STAYS_MAX):
        run_to_completion(local.plan(steps, MACHINE, marking_time(k), AHEAD, map_of(level())))
    assert asked == [0.0] * len(asked)


def test_where_no_leg_can_step_the_reason_names_what_bars_the_line_as_the_map_has_it():
    def steps(stance, command, terrain):
        yield None
        return Blocked(Reason.NO_LEG, 2, facts={"because": "no gain"})

    heights = level()
    heights[at(-1.0) : at(1.0), at(1.2) : at(1.3)] = 1.0
    for terrain, text in (
        (map_of(heights), "no leg can take a step: no gain; 0.5 m ahead a leg cannot be lifted"),
        (map_of(level()), "no leg can take a step: no gain"),
    ):
        planning = LocalPlanner().plan(steps, MACHINE, stance_at(), AHEAD, terrain)
        answer = run_to_completion(planning)
        assert answer.leg == 2 and answer.text.startswith(text)
        assert ("ahead" in answer.text) == ("ahead" in text)


def test_a_narrower_search_does_not_go_round_what_a_wider_one_does():
    terrain = map_of(with_hole(0.3, 2.3, -1.0, 1.0))
    for width, detour in ((2.0, True), (0.5, False)):
        settings = Navigation(width=width)
        *_, state, why = plan_route(
            RouteState(), AHEAD, stance_at(), terrain, MACHINE, settings=settings
        )
        assert (why is None and state.detours) == detour
    assert why is not None and why.facts["width"] == 0.5


def test_a_scenario_says_how_it_goes_round():
    simulation = Simulation(prepare(load_scenario("river", ["config.navigation.width=0.5"])))
    assert simulation.planner._local.settings == Navigation(width=0.5)


def test_the_planner_walks_by_the_command_until_ground_is_unknown_and_forgets_when_it_holds():
    local = LocalPlanner(cautious=True)
    assert local.heed(AHEAD) is AHEAD
    local.route = replace(local.route, speed_limit=0.02)
    assert local.heed(AHEAD) == replace(AHEAD, speed=0.02)
    assert local.heed(Command()) == Command() and local.route == RouteState()
