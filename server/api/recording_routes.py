"""What was walked in the last minutes, as a page to keep."""

from __future__ import annotations

import asyncio
import subprocess
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from ..child_process import start_child
from ..live_recording import EVERY, KEPT_SECONDS
from ..snapshot_files import put_away
from .drawings import DRAW_TIME
from .errors import HTTPProblem
from .run_routes import REPLAY_POLICY
from .state import ConsoleState

router = APIRouter(prefix="/api/v1/console/recording", tags=["console"])

Seconds = Annotated[float, Query(gt=0.0, le=KEPT_SECONDS)]
NAME = "walk.html"


@router.get("")
async def kept(state: ConsoleState) -> dict[str, Any]:
    """How many seconds of what was walked are kept, and how many can be."""
    return {"seconds": state.recording.seconds, "seconds_max": KEPT_SECONDS, "every_ticks": EVERY}


@router.get("/replay.html", response_class=HTMLResponse)
async def replay(state: ConsoleState, seconds: Seconds = 30.0) -> HTMLResponse:
    """The last seconds that were walked, by whomever and over resets, as one page that needs no
    server; drawn by a child of the console.
    """
    snapshots = state.recording.last(seconds)
    if len(snapshots) < 2:
        raise HTTPProblem(409, "nothing has been walked yet")
    async with state.kept_world.turn:
        with tempfile.TemporaryDirectory() as folder:
            page = await asyncio.to_thread(_drawn, Path(folder), snapshots)
    if page is None:
        raise HTTPProblem(500, "the page could not be drawn")
    headers = {
        "content-security-policy": REPLAY_POLICY,
        "content-disposition": f'attachment; filename="{NAME}"',
    }
    return HTMLResponse(page, headers=headers)


def _drawn(folder: Path, snapshots: Any) -> bytes | None:
    """The page as a child draws it; None where it fails or takes too long."""
    kept_in = folder / "snapshots"
    out = folder / NAME
    put_away(snapshots, kept_in)
    child = start_child(["draw-recording", str(kept_in), str(out)], folder)
    try:
        child.wait(DRAW_TIME)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()
    return out.read_bytes() if out.is_file() and child.returncode == 0 else None
