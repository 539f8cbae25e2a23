"""What a log has of every leg: joints, loads, and the loads that were planned."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.sim.load_history import accelerations, loads_over, shares_over
from walking_console.sim.simulation import Simulation

Columns = dict[str, NDArray[Any]]


class LegLog:
    """Watches the legs of a simulation: ``note`` after every tick.

    Loads are those of sensors and plan where there are any, or else what statics says of feet that
    touch the ground and of feet meant to carry.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self._joints = array("d")
        self._loads = array("d")  # none without sensors of load
        self._planned = array("d")  # none where legs do not give

    def note(self, simulation: Simulation) -> None:
        """The row of the tick just run."""
        for joints in simulation.plant.joints:
            self._joints.extend(joints)
        self._loads.extend(simulation.plant.loads)
        self._planned.extend(simulation.walk.loads or ())

    def columns(self, log: Columns) -> Columns:
        """Arrays, a row a tick, for a log of body, feet, contact and support."""
        body = log["body"]
        feet = log["feet"]
        rows, legs = log["contact"].shape
        columns: Columns = {"joints": np.array(self._joints).reshape(rows, legs, 3)}
        if len(self._planned) == rows * legs > 0:
            columns["planned_loads"] = np.array(self._planned).reshape(rows, legs)
            columns["true_body"] = body  # odometry may drift: the body logged is the true one
        else:
            shares = shares_over(log["support"])
            changes = accelerations(body)
            columns["planned_loads"] = loads_over(self.machine, body, feet, shares, changes)
        if len(self._loads) == rows * legs > 0:
            columns["loads"] = np.array(self._loads).reshape(rows, legs)
        else:
            on = log["contact"].astype(np.float64)
            columns["loads"] = loads_over(self.machine, body, feet, on)
        return columns
