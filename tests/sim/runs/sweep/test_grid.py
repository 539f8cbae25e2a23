"""Which walks a sweep has."""

import pytest

from walking_console.sim.runs.sweep.grid import (
    Axis,
    cases,
    parse_axis,
    parse_seeds,
    scenarios,
    sweep_of,
)
from walking_console.sim.scenario import ScenarioError


@pytest.mark.parametrize(
    ("setting", "values"),
    [
        ("mode=paper,predictive", ("paper", "predictive")),
        ("seed=7", ("7",)),
        ("end={time=2.0, distance=1.0},{time=3.0}", ("{time=2.0, distance=1.0}", "{time=3.0}")),
        ("drive=[{t=0.0,speed=0.1},{t=2.0}]", ("[{t=0.0,speed=0.1},{t=2.0}]",)),
        ("title='one, two',\"a,b\"", ("'one, two'", '"a,b"')),
        ("title='[',x", ("'['", "x")),
    ],
)
def test_commas_between_values_separate_and_others_do_not(setting, values):
    assert parse_axis(setting).values == values


@pytest.mark.parametrize("setting", ["mode", "=a,b", "mode=", "mode=a,,b", "mode=a,a", "mode=a,"])
def test_a_setting_that_names_no_values_is_refused(setting):
    with pytest.raises(ScenarioError, match="--set"):
        parse_axis(setting)


@pytest.mark.parametrize(
    ("text", "seeds"), [("1:4", (1, 2, 3, 4)), ("7", (7,)), ("1:2, 9", (1, 2, 9)), ("0:0", (0,))]
)
def test_seeds_are_numbers_and_ranges_with_both_ends(text, seeds):
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize("text", ["", "4:1", "-1", "1:", "a", "1:2:3", "1,1", "3000000000", "1.5"])
def test_seeds_that_are_none_are_refused(text):
    with pytest.raises(ScenarioError, match="--seeds"):
        parse_seeds(text)


def test_more_runs_than_a_table_holds_are_refused_before_they_are_listed():
    with pytest.raises(ScenarioError, match="more than"):
        parse_seeds("0:2000000000")


@pytest.mark.parametrize(
    ("settings", "seeds"), [(["mode=a", "mode=b"], None), (["seed=1,2"], "1:3")]
)
def test_one_thing_is_not_varied_twice(settings, seeds):
    with pytest.raises(ScenarioError):
        sweep_of("flat", settings, seeds)


def test_every_combination_is_walked_with_every_seed_in_the_order_of_the_table():
    sweep = sweep_of("flat", ["end={time=1.0},{time=2.0}", "mode=paper"], "3:4")
    walks = list(cases(sweep, scenarios(sweep)))
    assert len(sweep) == len(walks) == 4
    assert [case.index for case in walks] == [0, 1, 2, 3]
    assert [(case.scenario["end"]["time"], case.seed, case.scenario["seed"]) for case in walks] == [
        (1.0, 3, 3), (1.0, 4, 4), (2.0, 3, 3), (2.0, 4, 4),
    ]  # fmt: skip


def test_without_seeds_the_seed_of_each_scenario_is_the_only_one():
    sweep = sweep_of("flat", ["seed=5,6"], None)
    assert [case.seed for case in cases(sweep, scenarios(sweep))] == [5, 6]
    assert sweep.axes == (Axis("seed", ("5", "6")),)


def test_a_key_there_is_not_is_found_before_the_first_walk():
    with pytest.raises(ScenarioError, match="speeed"):
        scenarios(sweep_of("flat", ["speeed=1,2"], None))
