"""Sweeps: begin, list, follow, cancel, and the table and the drawing they leave."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, Response
from fastapi import Path as PathPart
from fastapi.responses import FileResponse

from ..schemas import SHIPPED_NAME, SweepBody, SweepState
from ..sweep_jobs import CURVE, SWEEP_FILES
from .errors import HTTPProblem
from .run_routes import FileName, NewestOnly
from .scenario_choice import sweep_order
from .state import ConsoleState

# words of the drawing are what somebody has typed
DRAWING_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'"

router = APIRouter(prefix="/api/v1/sweeps", tags=["sweeps"])


async def known_sweep(
    sweep_id: Annotated[str, PathPart(pattern=SHIPPED_NAME, examples=["holes-0001"])],
    state: ConsoleState,
) -> str:
    """The id of a sweep there is; 404 otherwise."""
    if not await state.sweeps.disk.ask(state.sweeps.knows, sweep_id):
        raise HTTPProblem(404, f"there is no sweep {sweep_id!r}")
    return sweep_id


KnownSweep = Annotated[str, Depends(known_sweep)]


@router.post("", status_code=202, response_model=SweepState)
async def start(
    body: SweepBody, request: Request, response: Response, state: ConsoleState
) -> dict[str, Any]:
    """Walk every combination of settings for every seed, in processes of their own."""
    order = await asyncio.to_thread(sweep_order, body, state.uploads)
    sweep_id = await state.sweeps.disk.ask(state.sweeps.start, order)
    response.headers["location"] = f"{request.scope['root_path']}/api/v1/sweeps/{sweep_id}"
    return await state.sweeps.disk.ask(state.sweeps.state, sweep_id)


@router.get("", response_model=list[SweepState])
async def listed(state: ConsoleState, limit: NewestOnly = 100) -> list[dict[str, Any]]:
    """The newest sweeps by name, with progress and result."""
    sweeps = state.sweeps
    return await sweeps.disk.ask(lambda: [sweeps.state(name) for name in sweeps.ids()[-limit:]])


@router.get("/{sweep_id}", response_model=SweepState)
async def one(sweep_id: KnownSweep, state: ConsoleState) -> dict[str, Any]:
    """Progress and result."""
    return await state.sweeps.disk.ask(state.sweeps.state, sweep_id)


@router.delete("/{sweep_id}", status_code=202, response_model=SweepState)
async def cancel(sweep_id: KnownSweep, state: ConsoleState) -> dict[str, Any]:
    """Cancel a sweep; what was walked stays in its table."""
    state.sweeps.cancel(sweep_id)
    return await state.sweeps.disk.ask(state.sweeps.state, sweep_id)


@router.get("/{sweep_id}/{name}", response_class=FileResponse)
async def file(sweep_id: KnownSweep, name: FileName, state: ConsoleState) -> FileResponse:
    """table.csv, table.parquet, sweep.json or pass-rate.svg of a sweep that is over."""
    if name not in SWEEP_FILES:
        there_are = f"a sweep has no {name!r}; there are: {', '.join(SWEEP_FILES)}"
        raise HTTPProblem(404, there_are, field="name", value=name, limit=list(SWEEP_FILES))
    path = await state.sweeps.disk.ask(state.sweeps.file, sweep_id, name)
    if path is None and name == CURVE:
        path = await state.drawings.drawing_of(state.sweeps, sweep_id)
    if path is None:
        raise HTTPProblem(404, f"sweep {sweep_id!r} has no {name} (yet)")
    headers = {"content-security-policy": DRAWING_POLICY} if name == CURVE else None
    return FileResponse(path, media_type=SWEEP_FILES[name], headers=headers)
