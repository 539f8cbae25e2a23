"""The console: the newest snapshot, driving by script, pause and single ticks, another world,
other ground.
"""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header
from fastapi.responses import JSONResponse, Response

from walking_console.planner import registry
from walking_console.planner.types import TICK, Mode
from walking_console.sim.requests import Follow, Push
from walking_console.sim.route_preview import preview_route

from ..explanation_frames import AheadFrame, DecisionFrame, ahead_frame, decision_frame
from ..frames import PlayedFrame, SnapshotFrame, StyleFrame, style_frame
from ..lease_reasons import LeaseRefusal
from ..schemas import (
    AdvanceBody,
    AttitudeBody,
    CommandBody,
    PostureBody,
    PushBody,
    RateBody,
    RouteAnswer,
    RouteBody,
    ScenarioBody,
    TerrainBody,
)
from .errors import HTTPProblem
from .scenario_choice import world_of
from .state import SETTLE_TIME, AppState, ConsoleState
from .terrain_edits import EDITS_A_TICK, edit_under, packed_terrain

ADVANCE_TIME = 20.0  # s
KEPT_TIME = 0.05  # s an answer waits for the disk to know of a stop, which has begun already
SWITCH_TIME = 1.0  # s for a pause to show
PLANNING_AHEAD = asyncio.Lock()  # one at a time: each keeps a core busy

router = APIRouter(prefix="/api/v1/console", tags=["console"])


def _or_refuse(why: LeaseRefusal | None) -> None:
    if why is not None:
        raise HTTPProblem(409, why.text)


OwnName = Annotated[str, Header(max_length=64, description="a page's own `lease_id`")]


def _refuse_others(state: ConsoleState, x_lease: OwnName = "") -> None:
    """While a page drives, nobody else changes its world."""
    _or_refuse(state.lease.keeps_from_changing(x_lease))


CHANGING = [Depends(_refuse_others)]


def _snapshot(state: AppState) -> JSONResponse:
    return JSONResponse(state.frame())


@router.get("", response_model=SnapshotFrame)
async def newest(state: ConsoleState) -> JSONResponse:
    """The newest snapshot."""
    return _snapshot(state)


@router.get("/ahead")
async def ahead(state: ConsoleState) -> AheadFrame | None:
    """What a trace walker foresees; null for any other."""
    return ahead_frame(state.loop.newest)


@router.get("/decision")
async def decision(state: ConsoleState) -> DecisionFrame | None:
    """Why the running step, or why there is none; null while it stands and nothing was refused."""
    return decision_frame(state.loop.newest)


@router.get("/style")
async def style(state: ConsoleState) -> StyleFrame:
    """Colours, thresholds and leg names that the machine is drawn with."""
    return style_frame(state.loop.newest.machine)


@router.put("/command", status_code=202)
async def command(body: CommandBody, state: ConsoleState) -> dict[str, Any]:
    """Drive for at most `ttl_s`; repeat it to go on. Refused (409) while a page drives or after a
    stop.
    """
    _or_refuse(state.lease.command(body.command(), body.ttl_s))
    return {"tick": state.loop.newest.tick, "ttl_s": body.ttl_s}


@router.post("/posture", status_code=202)
async def posture(body: PostureBody, state: ConsoleState) -> dict[str, Any]:
    """Stop, then sit down, stand up, or take the standard posture. Refused (409) while a page
    drives, after a stop, or fallen.
    """
    _or_refuse(state.lease.take_posture(body.posture))
    return {"tick": state.loop.newest.tick, "posture": body.posture}


@router.put("/attitude", status_code=202, dependencies=CHANGING)
async def attitude(body: AttitudeBody, state: ConsoleState) -> dict[str, Any]:
    """The body level, or leaning with the ground. Refused (409) for a planner that walks level
    only.
    """
    now = state.loop.newest
    if body.attitude != "level" and not now.capabilities.may_lean:
        raise HTTPProblem(409, registry.only_leans_with())
    state.loop.request(Follow(body.attitude))
    return {"tick": now.tick, "attitude": body.attitude}


@router.post("/push", status_code=202)
async def push(body: PushBody, state: ConsoleState) -> dict[str, Any]:
    """Push the torso; a fallen machine is pushed no further."""
    ticks = round(body.duration_s / TICK)
    state.loop.request(Push(body.fx_n, body.fy_n, ticks))
    return {"tick": state.loop.newest.tick, "ticks": ticks}


@router.post("/route")
async def route(body: RouteBody, state: ConsoleState) -> RouteAnswer:
    """Plan ahead to a place, before anything goes there: reached or not, steps, time, or why not.
    Nothing moves. Refused (409) on a given trace, and while the machine is not on its feet.
    """
    now = state.loop.newest
    if now.given_trace:
        raise HTTPProblem(409, "it follows its trace: free its stick first")
    if now.mode in (Mode.TIPPING, Mode.FALLEN, Mode.SIT, Mode.SIT_DOWN):
        raise HTTPProblem(409, "it does not stand on its feet")
    async with PLANNING_AHEAD:
        found = await asyncio.to_thread(preview_route, now, (body.x_m, body.y_m), body.speed_m_s)
    return RouteAnswer(
        reachable=found.reachable,
        steps=found.steps,
        time_s=found.time,
        distance_m=found.distance,
        left_m=found.left,
        reason=found.reason,
    )


@router.post("/stop")
async def stop(state: ConsoleState) -> dict[str, Any]:
    """Stop, until `rearm`. Anybody may."""
    state.lease.stop()
    state.wake()
    await state.lease.latch.wait(KEPT_TIME)
    return {"stopped": True}


@router.post("/rearm")
async def rearm(state: ConsoleState, x_lease: OwnName = "") -> dict[str, Any]:
    """End a stop: by the page that drives, its stick at rest, or, while none does, within the
    `ttl_s` of a command of no speed and no turn. Refused (409) otherwise.
    """
    _or_refuse(state.lease.rearm(x_lease))
    state.wake()
    return {"stopped": False}


@router.post("/reset", response_model=SnapshotFrame, dependencies=CHANGING)
async def reset(state: ConsoleState) -> JSONResponse:
    """Back to the start of the scenario; also forgives a fault. A stop stays."""
    before = state.loop.newest
    state.lease.hold()
    state.loop.reset()
    await state.until_another_world(before)
    return _snapshot(state)


@router.post("/play", response_model=SnapshotFrame, dependencies=CHANGING)
async def play(state: ConsoleState) -> JSONResponse:
    """Begin anew and walk by the scenario's own timeline until somebody drives; refused (409) after
    a stop.
    """
    if state.lease.stopped:
        raise HTTPProblem(409, "stopped: rearm first")
    before = state.loop.newest
    state.lease.hold()
    state.loop.play()
    await state.until_another_world(before)
    return _snapshot(state)


@router.get("/played")
async def played(state: ConsoleState) -> PlayedFrame | None:
    """How the timeline played last ended, and what of the expected came; null while none has."""
    player = state.loop.player
    if player is None or player.ending is None:
        return None
    result, reason = player.ending
    expected = await asyncio.to_thread(player.expectations)
    return PlayedFrame(result=result, reason=reason, expected=expected)


@router.post("/pause", response_model=SnapshotFrame, dependencies=CHANGING)
async def pause(state: ConsoleState) -> JSONResponse:
    """Stop simulated time."""
    loop = state.loop
    loop.pause()
    await state.until(lambda: loop.newest.paused or loop.fault, SWITCH_TIME)
    return _snapshot(state)


@router.post("/resume", response_model=SnapshotFrame, dependencies=CHANGING)
async def resume(state: ConsoleState) -> JSONResponse:
    """Let simulated time go on; whoever drove must let go of the stick first."""
    loop = state.loop
    if not loop.playing:
        state.lease.hold()
    loop.resume()
    await state.until(lambda: not loop.newest.paused or loop.fault, SWITCH_TIME)
    return _snapshot(state)


@router.post("/advance", response_model=SnapshotFrame, dependencies=CHANGING)
async def advance(body: AdvanceBody, state: ConsoleState) -> JSONResponse:
    """Walk so many ticks; needs the paused state (409)."""
    pace = state.loop.pace
    if not pace.paused:
        raise HTTPProblem(409, "advance needs the paused state")
    pace.advance(body.ticks)
    if not await state.until(lambda: pace.owed == 0, ADVANCE_TIME):
        raise HTTPProblem(503, f"{pace.owed} ticks are still to be walked")
    return _snapshot(state)


@router.post("/rate", dependencies=CHANGING)
async def rate(body: RateBody, state: ConsoleState) -> dict[str, Any]:
    """0.1 to 8 times real time; a held command must be given again, a timeline walks on."""
    if body.rate != state.loop.pace.rate:
        if not state.loop.playing:
            state.lease.hold()
        state.loop.set_rate(body.rate)
    return {"rate": body.rate}


@router.put("/scenario", response_model=SnapshotFrame, dependencies=CHANGING)
async def scenario(body: ScenarioBody, state: ConsoleState) -> JSONResponse:
    """Load a scenario by name or inline. The machine holds; the old world walks on until the new
    one is made.
    """
    async with state.kept_world.turn:
        world = await asyncio.to_thread(world_of, body, state.uploads)
        before = state.loop.newest
        state.lease.hold()
        state.loop.load(world)
        state.kept_world.keep(body)
        await state.until_another_world(before)
    return _snapshot(state)


@router.get("/terrain.npz", response_class=Response)
async def terrain_file(state: ConsoleState) -> Response:
    """The ground as it is now, as a run's `terrain.npz` has it: `heights` (row y, column x; NaN is
    bottomless), `cell`, `origin`, `forbidden` (as the machine believes). Of a map of more than 4
    million cells it is the window about the machine, with its `place`: row and column of its first
    cell, rows and columns of the whole map.
    """
    packed = await asyncio.to_thread(packed_terrain, state.loop.newest.terrain)
    return Response(packed, media_type="application/octet-stream")


@router.patch("/terrain", dependencies=CHANGING)
async def terrain(body: TerrainBody, state: ConsoleState) -> dict[str, Any]:
    """Dig a hole, raise or lower, forbid or clear cells. Edits that come faster than the walk can
    take them wait for each other.
    """
    loop = state.loop
    if not await state.until(lambda: loop.requests_waiting < EDITS_A_TICK, SETTLE_TIME):
        raise HTTPProblem(503, "the walk stands still: the edit was not made")
    edit = edit_under(body, loop.newest.terrain)
    loop.request(edit)
    return {"action": edit.action, "cells": len(edit.cells)}
