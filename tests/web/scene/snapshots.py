"""Snapshots to draw: a standing machine, a step, a preview."""

import numpy as np

from walking_console.planner.robot.model import Machine, as_data, load_machine, machine_from
from walking_console.planner.types import Command, GaitPreview, Mode, Phase, Stance, StepPlan
from walking_console.sim.snapshot import Snapshot, TerrainView


def level(revision: int = 1) -> TerrainView:
    """Eight metres square of level ground, cells of 5 cm."""
    heights = np.zeros((160, 160))
    return TerrainView(revision, heights, np.zeros(heights.shape, bool), 0.05, (-4.0, -4.0))


def standing(robot: str = "titan3", terrain: TerrainView | None = None) -> Snapshot:
    """A machine standing on the middle of its reach rectangles."""
    machine = load_machine(robot)
    legs = len(machine.legs)
    return Snapshot(
        tick=0,
        time=0.0,
        machine=machine,
        scenario="flat",
        planner="crab",
        planner_mode="paper",
        plant="kinematic",
        body_way="sway",
        body=(0.0, 0.0, machine.height, 0.0, 0.0, 0.0),
        feet=tuple((*leg.centre, 0.0) for leg in machine.legs),
        contact=(True,) * legs,
        support=(True,) * legs,
        mode=Mode.STAND,
        reason="",
        command=Command(),
        speed=0.0,
        speed_max=0.0,
        margin=0.2,
        polygon_margin=0.2,
        energy_margin=0.05,
        step=0,
        distance=0.0,
        plan=None,
        plan_time=0.0,
        ready=None,
        terrain=terrain or level(),
        flags=(False, False, False),
        whiskers=(0,) * legs,
        paused=False,
        rate=1.0,
        late=0.0,
    )


def stepping() -> StepPlan:
    """Front left goes 0.3 m ahead, aiming below the ground so that touch decides."""
    feet = np.array([[(*leg.centre, 0.0) for leg in load_machine("titan3").legs]] * 4)
    feet[1:3, 0, 2] = 0.1
    feet[2:, 0, 0] = feet[0, 0, 0] + 0.3
    feet[3, 0, 2] = -0.1
    landing = (float(feet[3, 0, 0]), float(feet[3, 0, 1]), 0.0)
    end = Stance((0.1, 0.0, 0.85, 0.0), (landing, *(tuple(foot) for foot in feet[0, 1:])), 0)
    return StepPlan(
        swing=(0,),
        times=np.array([0.0, 0.1, 0.6, 0.9]),
        body=np.array([(0.0, 0.0, 0.85, 0.0)] * 4),
        feet=feet,
        phases=(Phase.UP, Phase.RETURN, Phase.DOWN),
        end=end,
        landing=landing,
        search_start=landing,
    )


def preview(complete: bool) -> GaitPreview:
    """A straight path of 1 m with three footholds; without a way beyond 0.4 m when it is not
    complete.
    """
    line = tuple((0.05 * k, 0.05 * k, 0.0) for k in range(21))
    footholds = (((0.9, 0.6, 0.0), (1.2, 0.6, 0.0)), ((0.3, 0.6, 0.0),), (), (), (), ())
    reached = 1.0 if complete else 0.4
    reason = "" if complete else "no foothold"
    return GaitPreview(line, footholds, ((),) * 6, (), reached, 1.0, complete, reason)


def eight_legged() -> Machine:
    """A spider whose legs are numbered on either side."""
    xs = [(0.9, 1.5), (0.3, 0.8), (-0.8, -0.3), (-1.5, -0.9)]
    left = [
        {"name": f"left {i}", "x": list(x), "y": [0.4, 0.8], "z": [-0.8, -0.4]}
        for i, x in enumerate(xs)
    ]
    right = [
        {"name": f"right {i}", "x": list(x), "y": [-0.8, -0.4], "z": [-0.8, -0.4]}
        for i, x in enumerate(xs[::-1])
    ]
    plain = {"name": "spider", "torso": [2.4, 0.6, 0.2], "height": 0.6, "legs": left + right}
    titan = as_data(load_machine("titan3"))
    shared = {key: value for key, value in titan.items() if key not in ("masses", "chain")}
    return machine_from({**shared, **plain})
