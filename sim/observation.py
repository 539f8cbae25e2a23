"""How a ``Snapshot`` is taken of a ``Simulation``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from walking_console.planner import stability
from walking_console.planner.types import TICK

from .snapshot import Snapshot

if TYPE_CHECKING:
    from walking_console.planner.control.supervisor import GaitSupervisor
    from walking_console.planner.types import StepPlan

    from .simulation import Simulation

SLOWER = 0.97  # of the speed a step is planned for; below it the sway is said to slow it down


def take_snapshot(
    simulation: Simulation, *, paused: bool = False, rate: float = 1.0, late: float = 0.0
) -> Snapshot:
    """The world at this instant; ``paused``, ``rate`` and ``late`` are a clock's to say."""
    world = simulation.world
    return Snapshot(
        tick=simulation.tick_count,
        time=simulation.tick_count * TICK,
        machine=world.machine,
        scenario=world.scenario.name,
        planner=world.scenario.planner,
        planner_mode=world.scenario.mode,
        plant=world.scenario.plant,
        body_way=world.scenario.gait.body,
        command=simulation.command,
        distance=simulation.distance,
        mode=simulation.mode,
        reason=simulation.reason,
        given_trace=world.scenario.trace is not None,
        terrain=simulation.perception.view(),
        paused=paused,
        rate=rate,
        late=late,
        **_plant_fields(simulation),
        **_walk_fields(simulation.walk),
        **_planner_fields(simulation),
    )


def _plant_fields(simulation: Simulation) -> dict[str, Any]:
    """Where body and feet are, and how near the machine is to falling."""
    plant = simulation.plant
    carrying = simulation.walk.carrying()
    margins = simulation.margins(carrying)
    body = tuple(plant.body)
    feet = tuple((foot[0], foot[1], foot[2]) for foot in plant.feet)
    standing = [foot for foot, carries in zip(feet, carrying, strict=True) if carries]
    return {
        "body": body,
        "feet": feet,
        "contact": tuple(plant.soles),
        "support": carrying,
        "whiskers": tuple(plant.whiskers),
        "margin": margins.longitudinal,
        "polygon_margin": margins.polygon,
        "contact_margin": _contact_margin(simulation, carrying, margins.polygon),
        "capture_margin": margins.capture,
        "loads": tuple(plant.loads),
        "planned_loads": simulation.walk.loads or (),
        "joints": tuple(plant.joints),
        "energy_margin": stability.energy_margin(standing, body[:3]),
    }


def _contact_margin(
    simulation: Simulation, carrying: tuple[bool, ...], polygon_margin: float
) -> float:
    """Polygon margin of the feet that touch the ground, of those meant to carry, m."""
    touching = tuple(
        carries and sole for carries, sole in zip(carrying, simulation.plant.soles, strict=True)
    )
    return polygon_margin if touching == carrying else simulation.margins(touching).polygon


def _walk_fields(walk: GaitSupervisor) -> dict[str, Any]:
    """The step that runs, and the one after it."""
    stepping = walk.steps
    return {
        "speed": walk.speed,
        "speed_max": walk.plan.speed_max if stepping else 0.0,
        "sway_slows": bool(stepping and walk.plan.mean_speed < SLOWER * walk.plan.speed),
        "step": walk.steps_begun,
        "plan": walk.plan if walk.plays else None,
        "plan_time": walk.run.t,
        "ready": walk.ready,
        "flags": walk.flags,
        "posture": walk.posture,
        "blocked_by": "" if walk.blocked is None else walk.blocked.reason.name.lower(),
        "decision": _decision(walk),
        "departure": _departure(walk.plan) if stepping else "",
    }


def _planner_fields(simulation: Simulation) -> dict[str, Any]:
    """What the planner says of itself, of its path, and of what is to come."""
    walk = simulation.walk
    running = walk.plan if walk.steps else None
    x, y, z, _, _, yaw = simulation.plant.body
    planner = simulation.planner
    course = planner.progress(walk.stance, running, (x, y, z, yaw))
    trace = simulation.world.course
    return {
        "course": course,
        "off_trace": math.nan if trace is None else trace.nearest(course, x, y)[1],
        "ahead": simulation.preview(running),
        "attitude": planner.attitude,
        "capabilities": planner.capabilities,
    }


def _departure(plan: StepPlan) -> str:
    """Why a step is not that of the paper's rules, as it is shown."""
    return "" if plan.departure is None else plan.departure.value


def _decision(walk: GaitSupervisor) -> Mapping[str, Any] | None:
    """Why the running step was chosen, or why there is none."""
    if walk.blocked is not None:
        return walk.blocked.decision
    return None if walk.stands else walk.plan.decision
