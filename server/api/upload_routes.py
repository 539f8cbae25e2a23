"""Files that people bring: grounds and robots, by name."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Request
from fastapi import Path as PathPart

from ..forms import FormFault, FormFile, files_of, is_form
from ..uploads import UPLOAD_NAME, UploadRefused
from .errors import HTTPProblem
from .state import AppState, ConsoleState

router = APIRouter(prefix="/api/v1/uploads", tags=["uploads"])

Name = Annotated[str, PathPart(pattern=UPLOAD_NAME, examples=["ground.png"])]
RAW = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
FILE_OF_FORM = {"type": "object", "properties": {"file": {"type": "string", "format": "binary"}}}
FORM = {
    "requestBody": {
        "required": True,
        "content": {"multipart/form-data": {"schema": FILE_OF_FORM}},
    }
}


@router.get("")
async def listed(state: ConsoleState) -> dict[str, list[str]]:
    """Files that scenarios over HTTP may name."""
    return {"uploads": await asyncio.to_thread(state.uploads.names)}


@router.post("", status_code=201, openapi_extra=FORM)
async def upload_form(request: Request, state: ConsoleState) -> list[dict[str, Any]]:
    """Keep the files of a form, each under its own name (`curl -F file=@ground.png`): what a page
    sends. All are kept, or the first that is refused is answered.
    """
    files = await _files(request)
    return [await _stored(state, file.name, file.body) for file in files]


@router.put("/{name}", status_code=201, openapi_extra=RAW)
async def upload(name: Name, request: Request, state: ConsoleState) -> dict[str, Any]:
    """Keep a height file, or a robot's TOML file: the body is the file (`curl -T ground.png`), or a
    form with one.

    It is read at once: `note` says what was understood, `needs` which key of `[terrain]` it takes.
    Scenarios then name it: `terrain.file` or `robot`.
    """
    if is_form(request.headers.get("content-type", "")):
        body = (await _files(request))[0].body
    else:
        body = await request.body()
    return await _stored(state, name, body)


async def _files(request: Request) -> list[FormFile]:
    kind = request.headers.get("content-type", "")
    if not is_form(kind):
        raise HTTPProblem(415, "a form is wanted here (multipart/form-data), got " + repr(kind))
    body = await request.body()
    try:
        return await asyncio.to_thread(files_of, kind, body)
    except FormFault as error:
        raise HTTPProblem(422, str(error)) from None


async def _stored(state: AppState, name: str, body: bytes) -> dict[str, Any]:
    async with state.kept_world.turn:
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


@router.delete("/{name}", status_code=204, response_model=None)
async def remove(name: Name, state: ConsoleState) -> None:
    """Keep a file no longer."""
    if not state.uploads.holds(name):
        raise HTTPProblem(404, f"there is no upload {name!r}")
    await asyncio.to_thread(state.uploads.remove, name)
