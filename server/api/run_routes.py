"""Scripted runs: begin, list, follow, cancel, and the files they leave."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi import Path as PathPart
from fastapi.responses import FileResponse

from ..run_jobs import FILES, REPLAY
from ..schemas import SHIPPED_NAME, RunBody, RunState
from .errors import HTTPProblem
from .scenario_choice import chosen_scenario
from .state import ConsoleState

# a run's own file, but made of what somebody may have typed: no origin, no network
REPLAY_POLICY = (
    "sandbox allow-scripts; default-src 'none'; "
    "script-src 'unsafe-inline' blob: 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; connect-src data: blob:; worker-src blob:"
)

router = APIRouter(prefix="/api/v1/runs", tags=["runs"])


async def known_run(
    run_id: Annotated[str, PathPart(pattern=SHIPPED_NAME, examples=["flat-0001"])],
    state: ConsoleState,
) -> str:
    """The id of a run there is; 404 otherwise."""
    if not await state.jobs.disk.ask(state.jobs.knows, run_id):
        raise HTTPProblem(404, f"there is no run {run_id!r}")
    return run_id


KnownRun = Annotated[str, Depends(known_run)]
FileName = Annotated[str, PathPart(examples=["run.json"])]
NewestOnly = Annotated[int, Query(ge=1, le=1000)]


@router.post("", status_code=202, response_model=RunState)
async def start(
    body: RunBody, request: Request, response: Response, state: ConsoleState
) -> dict[str, Any]:
    """Start a scripted headless run in a process of its own."""
    scenario = await asyncio.to_thread(chosen_scenario, body, state.uploads)
    name = body.name or scenario.name
    jobs = state.jobs

    def begin() -> str:
        return jobs.start(scenario.as_data(), name, trace_decisions=body.trace_decisions)

    run_id = await jobs.disk.ask(begin)
    response.headers["location"] = f"{request.scope['root_path']}/api/v1/runs/{run_id}"
    return await jobs.disk.ask(jobs.state, run_id)


@router.get("", response_model=list[RunState])
async def listed(state: ConsoleState, limit: NewestOnly = 100) -> list[dict[str, Any]]:
    """The newest runs by name, with progress and result."""
    jobs = state.jobs
    return await jobs.disk.ask(lambda: [jobs.state(name) for name in jobs.ids()[-limit:]])


@router.get("/{run_id}", response_model=RunState)
async def one(run_id: KnownRun, state: ConsoleState) -> dict[str, Any]:
    """Progress and result."""
    return await state.jobs.disk.ask(state.jobs.state, run_id)


@router.delete("/{run_id}", status_code=202, response_model=RunState)
async def cancel(run_id: KnownRun, state: ConsoleState) -> dict[str, Any]:
    """Cancel a run; one that is over stays as it is."""
    state.jobs.cancel(run_id)
    return await state.jobs.disk.ask(state.jobs.state, run_id)


@router.get("/{run_id}/{name}", response_class=FileResponse)
async def file(run_id: KnownRun, name: FileName, state: ConsoleState) -> FileResponse:
    """run.json, ticks.npz, steps.jsonl, terrain.npz, inputs.jsonl or replay.html of a finished
    run.
    """
    if name not in FILES:
        there_are = f"a run has no {name!r}; there are: {', '.join(FILES)}"
        raise HTTPProblem(404, there_are, field="name", value=name, limit=list(FILES))
    path = await state.jobs.disk.ask(state.jobs.file, run_id, name)
    if path is None and name == REPLAY:
        path = await state.drawings.drawing_of(state.jobs, run_id)
    if path is None:
        raise HTTPProblem(404, f"run {run_id!r} has no {name} (yet)")
    headers = {"content-security-policy": REPLAY_POLICY} if name == REPLAY else None
    return FileResponse(path, media_type=FILES[name], headers=headers)
