"""``World``: a scenario made ready to walk in: its ground, its machine, the posture it begins in.

Everything slow happens here, once, and outside the walking thread; a ``Simulation`` may then be
begun in the same world as often as wanted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from walking_console.planner import registry
from walking_console.planner.geometry.paths import SampledPath
from walking_console.planner.initial_stance import HeightAt, Placement, stance_on
from walking_console.planner.protocols import PlannerError, PlannerSetup
from walking_console.planner.robot.model import Machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.terrain.traversability import classify
from walking_console.planner.types import Gait, Stance

from .plants import PlantMissing, plant_entry
from .scenario import Scenario, ScenarioError
from .surroundings import Surroundings, belief_of, first_window, reach_of, window_on
from .terrain.ground import Ground, make_ground
from .terrain.tile_layers import TileFacts


@dataclass(frozen=True)
class World:
    """A scenario with its machine on its ground, before the first tick. Frozen."""

    scenario: Scenario
    machine: Machine
    gait: Gait
    ground: Ground
    belief: TerrainMap  # the true ground as a map: what a machine knows with sensing = "known"
    forbidden: NDArray[np.bool_]  # (ny, nx) true ground, for this machine
    stance: Stance
    course: SampledPath | None = None  # the path a trace walker is given
    # of a wide map, whose window ``ground`` is: what follows from its heights for this machine
    tiles: TileFacts | None = None

    def surroundings(self) -> Surroundings | None:
        """What lies beyond the ``ground`` at the start, for one walk; None where that is all."""
        if self.tiles is None:
            return None
        reach = reach_of(self.scenario, self.machine)
        return Surroundings(self.tiles, self.ground, self.scenario.start_pose[:2], reach)


def prepare(
    scenario: Scenario, machine: Machine | None = None, ground: Ground | None = None
) -> World:
    """Make a scenario's world.

    ``machine`` and ``ground`` replace those the scenario names: what a recorded run brings along.
    Raises ``MachineError``, ``GroundError`` or ``ScenarioError`` with one clear line.
    """
    check_plant(scenario)
    import_module("numpy.ma")  # what np.unique and np.median load when they are first called
    machine = machine or scenario.machine()
    gait = scenario.gait_for(machine)
    check_rigid_gait(scenario, machine, gait)
    course = given_trace(scenario, machine)
    if ground is None:
        ground = ground_for(scenario, machine, gait)
    elif ground.edge != scenario.terrain.edge:
        ground = replace(ground, edge=scenario.terrain.edge)
    tiles = crests = None
    if ground.whole is None:
        forbidden = true_forbidden(ground, machine)
    else:
        tiles = TileFacts(ground.whole, machine, ground.final)
        x, y, _ = scenario.start_pose
        window = first_window(ground.whole, x, y, reach_of(scenario, machine))
        ground, forbidden, crests = window_on(tiles, ground, window)
    belief = belief_of(ground, forbidden, machine, crests)
    if scenario.sensing == "known":
        belief.work_out()
    stance = stance_at_start(scenario, machine, gait, ground.height_at)
    return World(scenario, machine, gait, ground, belief, forbidden, stance, course, tiles)


def check_plant(scenario: Scenario) -> None:
    """Raises ``ScenarioError`` when the scenario's plant cannot be had on this computer."""
    try:
        plant_entry(scenario.plant).check()
    except PlantMissing as error:
        raise ScenarioError(f"plant: {error}") from None


def check_rigid_gait(scenario: Scenario, machine: Machine, gait: Gait) -> None:
    """Raises ``ScenarioError`` for a rigid gait that this machine cannot walk."""
    if scenario.gait.rigid is None:
        return
    setup = PlannerSetup(machine, gait, scenario.mode, rigid_gait=scenario.gait.rigid)
    try:
        registry.make_planner(scenario.planner, setup)
    except PlannerError as error:
        raise ScenarioError(f"gait.rigid: {error}") from None


def ground_for(scenario: Scenario, machine: Machine, gait: Gait) -> Ground:
    """The ground a scenario names, large enough for its course. Raises ``GroundError``."""
    posture = stance_at_start(scenario, machine, gait, lambda x, y: 0.0)
    return make_ground(
        scenario.terrain,
        machine,
        scenario.start_pose,
        scenario.seed,
        scenario.span(machine),
        scenario.base,
        stand=[foot[:2] for foot in posture.feet],
    )


def given_trace(scenario: Scenario, machine: Machine) -> SampledPath | None:
    """The scenario's trace, sampled; None without one. Raises ``ScenarioError``."""
    if scenario.trace is None:
        return None
    try:
        return registry.sampled_path(scenario.trace.path_data, machine, scenario.start_pose)
    except PlannerError as error:
        raise ScenarioError(f"trace: {error}") from None


def stance_at_start(
    scenario: Scenario, machine: Machine, gait: Gait, height_at: HeightAt
) -> Stance:
    """The posture a scenario begins in: that of its planner, or its own feet.

    ``height_at`` is the ground under (x, y) in metres. Raises ``ScenarioError``.
    """
    pose = scenario.start_pose
    if scenario.start.feet is None:
        place = Placement(pose, height_at, first_crab_angle(scenario))
        return registry.initial_stance(scenario.planner, scenario.mode, machine, gait, place)
    try:
        return stance_on(machine, gait, scenario.start.feet, *pose, height_at)
    except ValueError as error:
        raise ScenarioError(f"start.feet: {error}") from None


def first_crab_angle(scenario: Scenario) -> float:
    """Crab angle α of the first command, rad: the standard posture at the start is that of the
    first course. 0 where no command is given.
    """
    return math.radians(scenario.drive[0].crab_angle_deg) if scenario.drive else 0.0


def true_forbidden(ground: Ground, machine: Machine) -> NDArray[np.bool_]:
    """Where this machine must not step on the true ground (ny, nx); on ``final`` ground exactly the
    holes.
    """
    if ground.final:
        return np.isnan(ground.heights)
    return classify(ground.heights, ground.cell, machine)
