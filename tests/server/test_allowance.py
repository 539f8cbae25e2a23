"""A burst, refilled as time goes by."""

from walking_console.server.allowance import Allowance


def test_a_burst_is_taken_and_then_so_many_a_second() -> None:
    allowance = Allowance(burst=5.0, per_second=2.0, now=0.0)
    assert [allowance.take(0.0) for _ in range(7)] == [True] * 5 + [False] * 2
    assert [allowance.take(1.0) for _ in range(3)] == [True, True, False]


def test_what_is_refused_costs_nothing() -> None:
    allowance = Allowance(burst=1.0, per_second=1.0, now=0.0)
    assert allowance.take(0.0)
    assert not any(allowance.take(0.9) for _ in range(1000))
    assert allowance.take(1.0)


def test_no_more_than_the_burst_is_saved_up() -> None:
    allowance = Allowance(burst=3.0, per_second=100.0, now=0.0)
    assert sum(allowance.take(60.0) for _ in range(10)) == 3
