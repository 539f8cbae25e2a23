"""The hash of a walk."""

from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.state_hash import StateHash
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


def hashes(speed: float, ticks: int) -> list[bytes]:
    simulation = Simulation(load_scenario("flat"))
    state = StateHash(simulation)
    simulation.drive(speed=speed)
    found = []
    for _ in range(ticks):
        simulation.step()
        state.note()
        found.append(state.digest)
    return found


def test_it_is_that_of_the_log() -> None:
    simulation = Simulation(load_scenario("flat"))
    recorder = Recorder(simulation)
    simulation.drive(speed=0.08)
    recorded = []
    for _ in range(80):
        simulation.step()
        recorder.note()
        recorded.append(recorder.hash)
    assert hashes(0.08, 80) == recorded and len(set(recorded)) == 80


def test_it_tells_walks_apart_from_the_first_tick_that_differs() -> None:
    same, other = hashes(0.08, 10), hashes(0.07, 10)
    assert all(a != b for a, b in zip(same, other, strict=True))


def test_state_and_flags_are_answered_in_the_order_of_the_contract() -> None:
    simulation = Simulation(load_scenario("flat"))
    state, flags = StateHash(simulation).note()
    assert len(state) == 6 + 12 + 3 and state[:6] == list(simulation.plant.body)
    assert state[6:9] == list(simulation.plant.feet[0]) and flags[-1] == simulation.mode
