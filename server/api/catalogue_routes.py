"""What there is: health, robots, terrains, scenarios."""

from __future__ import annotations

import time
from typing import Any

from fastapi import APIRouter

from walking_console.planner.robot.model import load_machine, machine_names
from walking_console.sim.runs.runner import product_version
from walking_console.sim.scenario_files import list_scenarios
from walking_console.sim.terrain.generators import list_terrains

from ..frames import last_line, number
from .state import ConsoleState

router = APIRouter(prefix="/api/v1", tags=["what there is"])


@router.get("/health")
async def health(state: ConsoleState) -> dict[str, Any]:
    """Version, uptime, tick lateness, and what is wrong if anything is."""
    loop = state.loop
    lease = state.lease
    return {
        "version": product_version(),
        "uptime_s": round(time.monotonic() - state.started, 3),
        "ok": not loop.fault and not loop.stalled,
        "tick_late_s": {
            "last_second": number(loop.lateness.last_second),
            "worst": number(loop.lateness.worst),
        },
        "beats": loop.ticks_run,
        "beats_skipped": loop.lateness.skipped,
        "beat_age_s": number(loop.tick_age),
        "stalled": loop.stalled,
        "fault": last_line(loop.fault),
        "paused": loop.pace.paused,
        "rate": loop.pace.rate,
        "drivers": len(state.drivers),
        "canvases": state.bridge.clients if state.bridge else 0,
        "refused_frames": lease.refusals,
        "holder": lease.holder,
        "stopped": lease.stopped,
    }


@router.get("/robots")
async def robots() -> list[dict[str, Any]]:
    """The robots that came with the program."""
    machines = [load_machine(name) for name in machine_names()]
    return [
        {
            "name": machine.name,
            "title": machine.title,
            "legs": len(machine.legs),
            "mass_kg": machine.mass,
            "height_m": machine.height,
        }
        for machine in machines
    ]


@router.get("/terrains")
async def terrains() -> list[dict[str, str]]:
    """The kinds of ground."""
    return [{"name": name, "title": line} for name, line in list_terrains()]


@router.get("/scenarios")
async def scenarios() -> list[dict[str, str]]:
    """The scenarios that came with the program."""
    return [{"name": name, "title": title} for name, title in list_scenarios()]
