"""The margins of a whole walk at once."""

import numpy as np
import pytest

from walking_console import load_machine
from walking_console.sim.margin_history import WalkRows, margins_over, true_centres
from walking_console.sim.margins import Margins, margins_of, true_centre
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

TITAN = load_machine("titan3")
FEET = [[x, y, 0.0] for x, y in ((0.5, 0.4), (-0.5, 0.4), (-0.5, -0.4), (0.5, -0.4))]
BODY = [0.1, 0.0, TITAN.height, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("scenario", "settings", "falls"),
    [
        ("flat", (), True),
        ("circle", (), True),  # a body that turns
        ("hillside", ("attitude=ground",), True),  # one that leans
        ("tripod", ("robot=phantomx", "gait={}"), False),  # legs that turn in their joints
    ],
)
def test_they_are_those_of_every_moment_to_the_last_bit_also_as_it_falls(
    scenario: str, settings: tuple[str, ...], falls: bool
) -> None:
    simulation = Simulation(load_scenario(scenario, settings))
    recorder = Recorder(simulation)
    simulation.drive(crab_angle=0.4, speed=0.06)
    every: list[Margins] = []
    for tick in range(300):
        if falls and tick == 250:
            simulation.plant.push(0.0, 9000.0, 30)
        simulation.step()
        recorder.note()
        every.append(simulation.margins(simulation.walk.carrying()))
    log = recorder.columns()
    told = np.stack([log["margin"], log["polygon_margin"], log["capture_margin"]], axis=1)
    assert (told == np.array(every)).all()
    assert (told[:, 0] != told[:, 1]).any() and (told[:, 1] != told[:, 2]).any()
    assert recorder.falls == falls


@pytest.mark.parametrize("standing", [0, 1, 2, 3, 4])
def test_on_fewer_than_three_feet_there_is_no_margin(standing: int) -> None:
    support = np.arange(4) < standing
    rows = WalkRows(
        body=np.array([BODY]),
        feet=np.array([FEET]),
        support=support[None],
        heading=np.array([0.3]),
        velocity=np.array([[0.1, 0.02]]),
    )
    wanted = margins_of(TITAN, BODY, FEET, FEET[:standing], 0.3, (0.1, 0.02))
    assert margins_over(TITAN, rows).tolist() == [list(wanted)]
    assert np.isfinite(wanted.polygon) == (standing > 2)


def test_polygons_of_three_feet_and_of_four_stand_in_one_table() -> None:
    bodies = np.array([BODY] * 3)
    bodies[:, 0] = 0.0, 0.1, 0.2
    support = np.ones((3, 4), bool)
    support[1, 2] = False
    headings = np.array([0.0, np.pi / 2, 1.0])
    speeds = np.array([[0.0, 0.0], [0.1, 0.0], [-0.1, 0.05]])
    rows = WalkRows(bodies, np.array([FEET] * 3), support, headings, speeds)
    for row, margins in enumerate(margins_over(TITAN, rows).tolist()):
        on = [foot for foot, carries in zip(FEET, support[row], strict=True) if carries]
        speed = tuple(speeds[row].tolist())
        wanted = margins_of(TITAN, bodies[row].tolist(), FEET, on, headings[row].item(), speed)
        assert margins == list(wanted)


def test_a_walk_of_no_ticks_has_none() -> None:
    none = np.zeros((0, 6)), np.zeros((0, 4, 3))
    rows = WalkRows(*none, np.zeros((0, 4), bool), np.zeros(0), np.zeros((0, 2)))
    assert margins_over(TITAN, rows).shape == (0, 3)
    assert true_centres(TITAN, *none).shape == (0, 3)


def test_legs_draw_the_centre_of_gravity_with_them_in_every_row() -> None:
    rng = np.random.default_rng(5)
    feet = np.array([FEET] * 20) + rng.uniform(-0.1, 0.1, (20, 4, 3))
    body = np.array([BODY] * 20) + rng.uniform(-0.1, 0.1, (20, 6))
    for machine in (TITAN, load_machine("phantomx")):
        legs = len(machine.legs)
        here = np.concatenate([feet, feet], axis=1)[:, :legs]
        for row, centre in enumerate(true_centres(machine, body, here).tolist()):
            assert centre == list(true_centre(machine, body[row].tolist(), here[row].tolist()))
