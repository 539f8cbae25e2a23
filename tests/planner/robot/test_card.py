"""Leg chains and masses on a robot card: optional, read exactly, refused with every reason."""

import copy

import pytest

from walking_console.planner.robot.model import MachineError, as_data, load_machine, machine_from


def data_of(name: str = "titan3") -> dict:
    return copy.deepcopy(as_data(load_machine(name)))


def without_chains() -> dict:
    data = data_of()
    del data["masses"]
    for leg in data["legs"]:
        del leg["hip"], leg["chain"]
    return data


def test_a_card_without_chains_and_masses_gets_slides_fitted_to_its_mechanical_box():
    machine = machine_from(without_chains())
    for leg, chain in zip(machine.legs, machine.chains, strict=True):
        assert chain.kind == "slides"
        for axis, span, over in zip(
            range(3), (leg.x, leg.y, leg.z), machine.overreach, strict=True
        ):
            low, high = chain.limits[axis]
            assert chain.hip[axis] + low == pytest.approx(span[0] - over)
            assert chain.hip[axis] + high == pytest.approx(span[1] + over)


def test_a_card_without_masses_has_an_eighth_of_its_mass_in_its_legs_which_go_with_the_feet():
    masses = machine_from(without_chains()).masses
    assert masses.torso + 4 * masses.leg == pytest.approx(80.0)
    assert masses.leg == pytest.approx(0.12 * 80.0 / 4)
    assert masses.links[:2] == (0.0, 0.0)


@pytest.mark.parametrize("name", ["titan3", "hexapod", "phantomx"])
def test_torso_and_legs_weigh_together_what_the_machine_weighs(name):
    machine = load_machine(name)
    whole = machine.masses.torso + len(machine.legs) * machine.masses.leg
    assert whole == pytest.approx(machine.mass)


def test_a_leg_without_a_box_gets_the_one_its_chain_reaches():
    data = data_of()
    for leg in data["legs"]:
        del leg["x"], leg["y"], leg["z"]
    fitted, card = machine_from(data), load_machine("titan3")
    for ours, theirs in zip(fitted.legs, card.legs, strict=True):
        assert ours.x[0] <= theirs.x[0] and theirs.x[1] <= ours.x[1]
    assert fitted.reach.x_span == pytest.approx(0.6, abs=0.011)


def test_a_serial_chain_is_the_same_chain_after_a_round_trip():
    data = data_of()
    spans = [[-0.30, 0.30], [-0.40, 0.40], [-1.25, -0.45]]
    joints = [{"axis": axis, "slides": True} for axis in ([2, 0, 0], [0, 3, 0], [0, 0, 1])]
    for leg in data["legs"]:
        leg["chain"] |= {"kind": "serial", "joints": joints, "limits": spans}
    machine = machine_from(data)
    assert machine_from(as_data(machine)) == machine


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"kind": "wheel"}, "kind must be one of slides, insect, mammal, serial, got 'wheel'"),
        ({"wings": 2}, "unknown key 'wings' in leg 2 chain; there are: kind, links"),
        ({"limits": [[0, 1]]}, "limits must be 3 pairs"),
        ({"limits": [[1, 0], [0, 1], [0, 1]]}, r"limits\[0\] must be \[low, high\]"),
        ({"speed": [1.0, 0.0, 1.0]}, "speed must be positive"),
        ({"kind": "insect"}, "links must be a list of 3 numbers, got None"),
        ({"kind": "insect", "links": [0.1, 0.0, 0.1]}, r"links must be \[l1, l2, l3\]"),
        ({"kind": "serial"}, "joints must be 3 tables with axis, offset, slides"),
        ({"limits": [[-0.1, 0.1], [-0.05, 0.4], [-1.25, -0.45]]}, "leg 2 cannot reach"),
    ],
)
def test_an_impossible_chain_is_refused_with_its_reason(change, reason):
    data = data_of()
    data["legs"][1]["chain"] |= change
    with pytest.raises(MachineError, match=reason):
        machine_from(data)


def test_a_chain_needs_its_hip():
    data = data_of()
    del data["legs"][2]["hip"]
    with pytest.raises(MachineError, match="leg 3 hip must be a list of 3 numbers, got None"):
        machine_from(data)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"torso": 60.0}, "masses must add up to the mass 80 kg, got 69.6 kg"),
        ({"links": [0.0, 0.0, -2.4]}, "masses links must be not negative"),
        ({"feet": 1.0}, "unknown key 'feet' in masses; there are: torso, links, centre"),
        ({"centre": [50.0, 0.0, 0.0]}, "masses centre must be within 10 m"),
    ],
)
def test_impossible_masses_are_refused_with_their_reason(change, reason):
    data = data_of()
    data["masses"] |= change
    with pytest.raises(MachineError, match=reason):
        machine_from(data)
