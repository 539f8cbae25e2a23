"""Files that people bring: grounds and robots, by name."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Request
from fastapi import Path as PathPart

from ..uploads import UPLOAD_NAME, UploadRefused
from .errors import HTTPProblem
from .state import ConsoleState

router = APIRouter(prefix="/api/v1/uploads", tags=["uploads"])

Name = Annotated[str, PathPart(pattern=UPLOAD_NAME, examples=["ground.png"])]
RAW = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("")
async def listed(state: ConsoleState) -> dict[str, list[str]]:
    """Files that scenarios over HTTP may name."""
    return {"uploads": await asyncio.to_thread(state.uploads.names)}


@router.put("/{name}", status_code=201, openapi_extra=RAW)
async def upload(name: Name, request: Request, state: ConsoleState) -> dict[str, Any]:
    """Keep a height file, or a robot's TOML file: the body is the file (`curl -T ground.png`).

    It is read at once: `note` says what was understood, `needs` which key of `[terrain]` it takes.
    Scenarios then name it: `terrain.file` or `robot`.
    """
    if request.headers.get("content-type", "").startswith("multipart/"):
        raise HTTPProblem(415, "send the file itself as the body, as `curl -T FILE` does")
    body = await request.body()
    async with state.loads:
        try:
            return await asyncio.to_thread(state.uploads.store, name, body)
        except UploadRefused as error:
            raise HTTPProblem(
                error.status,
                str(error),
                field=name,
                value=f"{len(body)} bytes",
                faults=error.faults,
            ) from None


@router.delete("/{name}", status_code=204)
async def remove(name: Name, state: ConsoleState) -> None:
    """Keep a file no longer."""
    if not state.uploads.holds(name):
        raise HTTPProblem(404, f"there is no upload {name!r}")
    await asyncio.to_thread(state.uploads.remove, name)
