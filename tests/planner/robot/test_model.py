"""Robots are data, and impossible ones are refused with every reason."""

import math

import pytest

from walking_console.planner.robot.model import (
    MachineError,
    as_data,
    load_machine,
    machine_from,
    machine_names,
)


@pytest.mark.parametrize("name", machine_names())
def test_every_shipped_robot_loads_and_says_where_its_numbers_come_from(name):
    machine = load_machine(name)
    assert machine.name == name
    assert len(machine.source) > 20


@pytest.mark.parametrize("name", machine_names())
def test_a_robot_written_as_data_is_the_same_robot(name):
    machine = load_machine(name)
    assert machine_from(as_data(machine)) == machine


def test_a_shipped_robot_is_loaded_once_and_an_equal_one_hashes_alike():
    machine = load_machine("titan3")
    assert load_machine("titan3") is machine
    again = machine_from(as_data(machine))
    assert again is not machine
    assert hash(again) == hash(machine)
    assert len({hash(load_machine(name)) for name in machine_names()}) == len(machine_names())


def test_titan3_has_the_reach_of_the_specification():
    reach = load_machine("titan3").reach
    assert (reach.x0, reach.x_span, reach.y0, reach.y_span, reach.z0, reach.z_span) == (
        0.20,
        0.50,
        0.30,
        0.35,
        0.60,
        0.50,
    )


def test_an_unknown_robot_is_answered_with_the_known_ones():
    with pytest.raises(MachineError, match="unknown robot 'titan4'; there are: .*titan3"):
        load_machine("titan4")


def test_the_crab_planner_says_it_needs_four_legs():
    with pytest.raises(MachineError, match="four-legged.*6 legs"):
        _ = load_machine("hexapod").reach


def moved(name, leg, **axes):
    """A shipped robot with one leg's box moved along some axes, its joints left out."""
    data = as_data(load_machine(name))
    for each in data["legs"]:
        del each["hip"], each["chain"]
    for axis, way in axes.items():
        data["legs"][leg][axis] = [value + way for value in data["legs"][leg][axis]]
    return machine_from(data)


def test_legs_that_are_not_mirrored_reach_what_they_have_in_common():
    reach = moved("titan3", 1, x=0.05, y=0.02).reach
    assert (reach.x0, reach.x_span) == (pytest.approx(0.20), pytest.approx(0.45))
    assert (reach.y0, reach.y_span) == (pytest.approx(0.32), pytest.approx(0.33))


def test_legs_with_nothing_in_common_cannot_walk_in_the_crab_planner():
    with pytest.raises(MachineError, match="in common.*at least 0.02 m.*'titan3' have none"):
        _ = moved("titan3", 0, y=0.40).reach


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"mass": -1.0}, "mass must be positive"),
        ({"mass": math.nan}, "mass must be a finite number"),
        ({"mass": True}, "mass must be a finite number"),
        ({"wings": 2}, "unknown key 'wings'; there are: name"),
        ({"height": 3.0}, "outside the legs' common z range"),
        ({"duty_factor": 1.0}, "duty_factor must be at least 0.5, less than 1, got"),
        ({"legs": []}, "legs must be 4 to 8 tables, got 0"),
        ({"torso": [1.0]}, "torso must be a list of 3 numbers"),
        ({"speed": [1.0, 0.0, 1.0]}, "speed must be positive"),
        ({"lift_down": 0.01}, "lift_down must be at least lift_up"),
    ],
)
def test_an_impossible_robot_is_refused_with_its_reason(change, reason):
    with pytest.raises(MachineError, match=reason):
        machine_from({**as_data(load_machine("titan3")), **change})


def test_a_refusal_lists_every_reason():
    with pytest.raises(MachineError, match="mass.*friction"):
        machine_from({**as_data(load_machine("titan3")), "mass": 0.0, "friction": -1.0})


def test_faults_of_every_part_of_a_card_are_said_at_once():
    data = as_data(load_machine("hexapod"))
    data |= {"mass": -1.0, "torso": [1.0, 2.0], "colour": "red", "duty_factor": 2.0}
    data["masses"] = {"torso": -1.0, "links": [0.1, 0.1, 0.1], "feet": 1}
    data["legs"][0]["x"] = [0.3, 0.1]
    data["legs"][1]["hip"] = [99.0, 0.0, 0.0]
    data["legs"][2]["chain"] |= {"kind": "insect", "links": [0.0, 0.0, 0.0]}
    del data["legs"][3]["name"]
    with pytest.raises(MachineError) as refused:
        machine_from(data)
    said = [
        "unknown key 'colour'", "mass must be positive", "duty_factor must be at least 0.5",
        "torso must be a list of 3", "leg 2 hip must be within 10 m", "leg 3 chain links must be",
        "leg 1 x must be [low, high]", "leg 4 name must be a text", "unknown key 'feet' in masses",
        "masses torso must be positive",
    ]  # fmt: skip
    assert len(refused.value.faults) == len(said)
    assert all(any(fault.startswith(words) for fault in refused.value.faults) for words in said)


def test_one_faulty_chain_does_not_ask_every_leg_for_a_box():
    data = as_data(load_machine("hexapod"))
    for leg in data["legs"]:
        del leg["x"], leg["y"], leg["z"]
    data["legs"][2]["chain"]["speed"] = [1.0, 0.0, 1.0]
    with pytest.raises(MachineError, match="leg 3 chain speed must be positive") as refused:
        machine_from(data)
    assert len(refused.value.faults) == 1


def test_legs_on_one_side_only_are_no_stance():
    data = as_data(load_machine("titan3"))
    for leg in data["legs"]:
        leg["y"] = [0.3, 0.65]
    with pytest.raises(MachineError, match="counter-clockwise|no statically stable stance"):
        machine_from(data)
