"""A stick that is tapped: the hand ends every step, and the machine is ready for the next."""

from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


def test_a_stick_tapped_forty_times_walks_when_it_is_held() -> None:
    simulation = Simulation(load_scenario("flat", ("expect={}",)))
    for _ in range(40):
        simulation.drive(0.0, 0.1)
        simulation.step()
        simulation.drive(0.0, 0.0)
        for _ in range(15):
            simulation.step()
        assert simulation.snapshot().reason == ""
    tapped = simulation.distance
    simulation.drive(0.0, 0.1)
    for _ in range(250):
        simulation.step()
    assert simulation.distance > tapped + 0.25
