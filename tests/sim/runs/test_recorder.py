"""The log of a run: rows, steps, hash."""

import struct
from hashlib import blake2b

import numpy as np
import pytest

from walking_console.planner.types import TICK, Command, Mode
from walking_console.sim.runs.recorder import MODES, Recorder
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

TICKS = 400


@pytest.fixture(scope="module")
def walked() -> Recorder:
    simulation = Simulation(load_scenario("flat"))
    recorder = Recorder(simulation)
    simulation.drive(speed=0.08)
    for tick in range(TICKS):
        if tick == 350:
            simulation.drive()
        simulation.step()
        recorder.note()
    return recorder


def test_there_is_a_row_a_tick_with_the_state_at_its_end(walked: Recorder) -> None:
    log = walked.columns()
    assert {len(rows) for rows in log.values()} == {TICKS} == {walked.ticks}
    assert log["t"] == pytest.approx((np.arange(TICKS) + 1) * TICK)
    assert log["body"][-1].tolist() == walked.simulation.plant.body
    assert log["feet"][-1].tolist() == walked.simulation.plant.feet
    assert log["command"][0].tolist() == [0.0, 0.08, 0.0]
    assert log["margin"].min() == walked.margin_min


def test_the_hash_is_that_of_the_contract_row_by_row(walked: Recorder) -> None:
    log, digest = walked.columns(), bytes(8)
    for row in range(TICKS):
        state = [*log["body"][row], *log["feet"][row].ravel(), *log["command"][row]]
        flags = [*log["contact"][row], *log["support"][row], log["mode"][row]]
        packed = digest + struct.pack(f"<{len(state)}d", *(v + 0.0 for v in state))
        digest = blake2b(packed + bytes(map(int, flags)), digest_size=8).digest()
        assert int.from_bytes(digest, "little") == log["hash"][row]
    assert walked.state_hash == f"{log['hash'][-1]:016x}"


def test_every_step_is_recorded_in_the_tick_it_was_over(walked: Recorder) -> None:
    ends = [step["tick"] for step in walked.steps]
    assert len(ends) >= 4 and ends == sorted(ends)
    assert walked.steps[0]["tick_begun"] == 0
    for one, two in zip(walked.steps, walked.steps[1:], strict=False):
        assert two["tick_begun"] == one["tick"] and two["index"] == one["index"] + 1
    assert all(1 <= leg <= 4 for step in walked.steps for leg in step["swing"])
    assert walked.forbidden_steps == 0


def test_commands_are_inputs_in_the_tick_they_came(walked: Recorder) -> None:
    assert [(entry["tick"], entry["speed"]) for entry in walked.inputs] == [(0, 0.08), (350, 0.0)]
    assert {entry["input"] for entry in walked.inputs} == {"command"}


def test_numbers_of_modes_are_named(walked: Recorder) -> None:
    assert MODES["stand"] == int(Mode.STAND) and len(MODES) == len(Mode)
    assert set(walked.columns()["mode"].tolist()) <= set(MODES.values())


def test_a_fall_is_counted_once() -> None:
    simulation = Simulation(load_scenario("flat"))
    recorder = Recorder(simulation)
    simulation.plant.push(0.0, 6000.0, 30)
    simulation.order(Command())
    for _ in range(200):
        simulation.step()
        recorder.note()
    assert simulation.mode is Mode.FALLEN and recorder.falls == 1
