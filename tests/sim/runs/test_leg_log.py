"""What a log has of every leg."""

from importlib.util import find_spec

import numpy as np
import pytest

from walking_console.planner.stability import GRAVITY
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation

TICKS = 150


def walked(tmp_path, *settings: str):
    simulation = Simulation(load_scenario("flat", settings))
    recorder = Recorder(simulation)
    simulation.drive(speed=0.08)
    for _ in range(TICKS):
        simulation.step()
        recorder.note()
    recorder.write(tmp_path, {})
    with np.load(tmp_path / "ticks.npz") as log:
        return simulation, dict(log)


def test_loads_hold_the_weight_and_joints_are_those_of_the_feet(tmp_path) -> None:
    simulation, log = walked(tmp_path)
    weight = simulation.world.machine.mass * GRAVITY
    assert log["planned_loads"].sum(axis=1) == pytest.approx(np.full(TICKS, weight))
    assert log["loads"].sum(axis=1) == pytest.approx(np.full(TICKS, weight))
    assert (log["loads"][~log["contact"]] == 0.0).all() and not log["contact"].all()
    assert log["joints"][-1].tolist() == [list(joints) for joints in simulation.plant.joints]
    assert np.isfinite(log["capture_margin"]).all() and "true_body" not in log


@pytest.mark.skipif(find_spec("mujoco") is None, reason="an extra")
def test_what_sensors_and_plan_say_of_loads_is_kept_where_there_are_any(tmp_path) -> None:
    simulation, log = walked(tmp_path, "plant=physics")
    assert log["loads"][-1].tolist() == simulation.plant.loads
    assert tuple(log["planned_loads"][-1]) == simulation.walk.loads
    assert log["true_body"][-1].tolist() == simulation.plant.body
    assert np.isfinite(log["joints"]).all()
