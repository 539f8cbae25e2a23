"""Search that knows neither legs nor ground: here a walk on a line of numbers."""

from itertools import islice

from walking_console.planner.search import (
    ENOUGH,
    Branch,
    Work,
    beam,
    firsts,
    ranked,
    rollouts,
    thinned,
)

HOLES = {3, 5, 6}


def options(place, depth):
    """One or two on, never into a hole; two cost nothing more."""
    for way in (1, 2):
        if place + way not in HOLES:
            yield way, place + way, float(way), 0.0


def finish(search, *sent):
    """Run a search to its end, sending what is given at each pause; its answer and the number of
    pauses.
    """
    pauses, answers = 0, list(sent)
    value = None
    while True:
        try:
            search.send(value)
        except StopIteration as done:
            return done.value, pauses
        pauses += 1
        value = answers.pop(0) if answers else None


def test_a_beam_finds_the_way_that_a_greedy_choice_misses():
    found, _ = finish(beam(0, options, depth=3, width=4))
    assert found.finished
    # 2 then 2; then nothing: 5 and 6 are holes
    assert found.ways[0].node == 4 and found.ways[0].gain == 4.0
    best = max(found.ways, key=lambda way: way.gain)
    assert best.first in (1, 2)


def test_where_no_way_goes_on_a_beam_answers_with_the_farthest_it_came_to():
    found, _ = finish(beam(4, options, depth=5, width=4))
    assert found == ([], True)
    found, _ = finish(beam(2, options, depth=5, width=4))
    assert {way.node for way in found.ways} == {4}


def test_a_beam_pauses_after_every_state_it_looks_at_and_no_more():
    free = lambda place, depth: [(1, place + 1, 1.0, 0.0), (2, place + 2, 2.0, 0.0)]  # noqa: E731
    _, pauses = finish(beam(0, free, depth=4, width=3))
    assert pauses == 1 + 2 + 3 + 3


def test_a_beam_that_is_wanted_now_answers_with_what_it_has():
    free = lambda place, depth: [(1, place + 1, 1.0, 0.0), (2, place + 2, 2.0, 0.0)]  # noqa: E731
    found, pauses = finish(beam(0, free, depth=4, width=3), True)
    assert (
        pauses == 1 and not found.finished and found.ways[0].first == 2 and found.ways[0].steps == 1
    )


def test_rollouts_follow_the_policy_and_count_what_came_before():
    policy = lambda place: None if place + 1 in HOLES else (place + 1, 1.0)  # noqa: E731
    found, pauses = finish(rollouts(options(0, 0), policy, 4))
    assert pauses == 2
    by_first = {way.first: (way.node, way.gain, way.steps) for way in found.ways}
    assert by_first == {1: (2, 2.0, 2), 2: (2, 2.0, 1)}
    found, _ = finish(rollouts(options(0, 0), policy, 4, begun=(9, 10.0)))
    assert {(way.first, way.gain, way.steps) for way in found.ways} == {(9, 12.0, 3), (9, 12.0, 2)}


def test_rollouts_that_are_wanted_now_have_looked_at_one_option_at_least():
    found, pauses = finish(rollouts(islice(options(0, 0), 2), lambda place: None, 4), True)
    assert pauses == 1 and not found.finished and len(found.ways) == 1


def test_of_equal_ways_the_one_found_first_is_the_best_and_each_first_choice_is_named_once():
    a, b = "a", "b"
    ways = [Branch(a, 1, 1.0, 1.0, 1), Branch(b, 2, 1.0, 1.0, 1), Branch(a, 3, 0.5, 2.0, 2)]
    assert [way.node for way in ranked(ways)] == [3, 1, 2]
    assert [(way.first, way.node) for way in firsts(ranked(ways))] == [("a", 3), ("b", 2)]


def test_a_way_that_ends_early_is_slow():
    assert Branch("a", 1, 0.75, 0.75, 2).pace(6) == 0.125


def test_many_candidates_are_thinned_evenly():
    few = thinned(list(range(100)), 10)
    assert few == [5 + 10 * k for k in range(10)]
    assert thinned(few, 10) is few


def weights_of(search):
    """What each slice of a search weighed, and its answer."""
    weights = []
    while True:
        try:
            weights.append(next(search))
        except StopIteration as done:
            return weights, done.value


def test_a_beam_pauses_within_a_node_of_many_ways_and_says_what_it_has_looked_at():
    many = lambda place, depth: ((way, place + way, 1.0, 0.0) for way in range(1, 41))  # noqa: E731
    weights, found = weights_of(beam(0, many, depth=2, width=1))
    assert sum(weights) == 80 and max(weights) == ENOUGH
    assert len(found.ways) == 1 + 40 and found.finished


def test_a_beam_weighs_what_its_options_have_asked_too():
    work = Work()

    def dear(place, depth):
        for way in range(1, 5):
            work.asked += 100
            yield way, place + way, 1.0, 0.0

    weights, _ = weights_of(beam(0, dear, depth=1, width=2, work=work))
    assert weights == [101, 101, 101, 101, 0]


def test_a_rollout_pauses_on_a_long_way_and_ends_it_though_it_is_wanted_now():
    policy = lambda place: (place + 1, 1.0)  # noqa: E731
    first = [(1, 1, 1.0, 0.0), (2, 2, 1.0, 0.0)]
    weights, found = weights_of(rollouts(first, policy, 3 * ENOUGH))
    assert max(weights) == ENOUGH and sum(weights) == 2 * 3 * ENOUGH
    found, pauses = finish(rollouts(first, policy, 3 * ENOUGH), True)
    assert [way.steps for way in found.ways] == [3 * ENOUGH + 1] and not found.finished
    assert pauses == 4
