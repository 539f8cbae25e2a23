"""What a browser loads: the page, its files, the API's documents, and the canvas."""

from __future__ import annotations

import asyncio
from html import escape
from pathlib import Path

from fastapi import APIRouter, Request, WebSocket
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from starlette.websockets import WebSocketDisconnect

from walking_console.planner.robot.toml_files import is_file

from ..problems import problem
from ..static_files import answer_with, static_file
from ..viser_bridge import ViserBridge, clean_query
from .errors import HTTPProblem, methods_at
from .state import ConsoleState

PAGE_FILES = frozenset(
    ".html .js .css .svg .png .jpg .ico .map .json .webmanifest .woff2 .txt".split()
)
PATH_SHOWN = 200  # characters of a path that is not there
NO_CANVAS = "this console has no canvas"
DOCS = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>walking-console API</title>
<meta name="viewport" content="width=device-width">
<link rel="stylesheet" href="vendor/swagger/swagger-ui.css">
<link rel="icon" href="vendor/swagger/favicon-32x32.png">
</head>
<body>
<div id="docs"></div>
<script src="vendor/swagger/swagger-ui-bundle.js"></script>
<script src="docs/start.js"></script>
</body>
</html>
"""
DOCS_START = """SwaggerUIBundle({
  url: "openapi.json", dom_id: "#docs", deepLinking: true, validatorUrl: null,
  tryItOutEnabled: true, presets: [SwaggerUIBundle.presets.apis], layout: "BaseLayout"
});
"""

router = APIRouter(include_in_schema=False)


def page_policy(host: str) -> str:
    """What the page may load and speak to: this console."""
    return (
        "default-src 'none'; script-src 'self'; worker-src 'self' blob:; "
        "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self'; "
        f"connect-src 'self' ws://{host} wss://{host}; frame-src 'self'; manifest-src 'self'; "
        "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    )


def page_headers(request: Request) -> dict[str, str]:
    """Sent with every file of the page."""
    policy = page_policy(request.headers["host"])
    return {"content-security-policy": policy, "cache-control": "no-cache"}


@router.get("/")
async def index(request: Request, state: ConsoleState) -> Response:
    """The page."""
    page = state.settings.web / "page" / "index.html"
    if not page.is_file():
        raise HTTPProblem(404, "the page is not installed")
    return await _file(request, page)


@router.get("/favicon.ico")
async def icon() -> Response:
    """Where programs look that have not read the page."""
    return RedirectResponse("favicon.svg", 307)


@router.get("/docs/")
async def docs_below() -> Response:
    """The documents, as people type them."""
    return RedirectResponse("../docs", 307)


@router.get("/docs")
async def docs(request: Request) -> Response:
    """The API's documents, without any outside host."""
    return HTMLResponse(DOCS, headers=page_headers(request))


@router.get("/docs/start.js")
async def docs_start() -> Response:
    """The one script of the documents that is our own."""
    return Response(DOCS_START, media_type="text/javascript")


@router.get("/view")
@router.get("/view/")
async def view(request: Request, state: ConsoleState) -> Response:
    """The canvas, for the frame in the page."""
    if state.bridge is None:
        raise HTTPProblem(503, NO_CANVAS)
    cleaned = _without_foreign_keys(request.url.query)
    if cleaned is not None:
        here = "./" if request.url.path.endswith("/") else "view/"
        return RedirectResponse(f"{here}?{cleaned}" if cleaned else here, 307)
    return _canvas(request, state.bridge)


def _without_foreign_keys(query: str) -> str | None:
    """What a query must become; None when it may stay."""
    try:
        return clean_query(query)
    except ValueError:
        return ""


def _canvas(request: Request, bridge: ViserBridge) -> Response:
    headers = {
        "content-security-policy": bridge.content_policy(request.headers["host"]),
        "cache-control": "no-cache",
        "etag": bridge.etag,
        "vary": "accept-encoding",
    }
    if request.headers.get("if-none-match") == bridge.etag:
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return HTMLResponse(bridge.page_gzipped, headers=headers | {"content-encoding": "gzip"})
    return HTMLResponse(bridge.page, headers=headers)


@router.websocket("/view")
@router.websocket("/view/")
async def canvas_stream(socket: WebSocket, state: ConsoleState) -> None:
    """The canvas's own stream."""
    if state.bridge is None:
        await socket.send_denial_response(problem(503, NO_CANVAS))
        return
    try:
        await state.bridge.carry(socket)
    except (WebSocketDisconnect, RuntimeError):
        pass  # gone while something was being sent


@router.get("/{path:path}")
async def static(request: Request, path: str, state: ConsoleState) -> Response:
    """Files of the page: by suffix, and never outside its folder."""
    if path.startswith("api/") and methods_at(request):
        raise HTTPProblem(405, "this is not got")
    parts = path.removeprefix("static/").split("/")
    web = state.settings.web
    found = file_under(web if parts[0] == "vendor" else web / "page", parts)
    if found is None:
        nothing = f"there is nothing at /{path[:PATH_SHOWN]}"
        if "text/html" in request.headers.get("accept", ""):
            return HTMLResponse(_sorry(request, nothing), 404, page_headers(request))
        raise HTTPProblem(404, nothing)
    return await _file(request, found)


def _sorry(request: Request, text: str) -> str:
    """For people, in place of problem+json."""
    page = f"{request.scope['root_path']}/"
    return f'<!doctype html><title>Not found</title><p>{escape(text)}. <a href="{page}">Drive</a>'


async def _file(request: Request, path: Path) -> Response:
    file = await asyncio.to_thread(static_file, path)
    return answer_with(request, file, page_headers(request))


def file_under(root: Path, parts: list[str]) -> Path | None:
    """A file of the page by the parts of its path; None for anything else."""
    if not all(_is_plain(part) for part in parts) or Path(parts[-1]).suffix not in PAGE_FILES:
        return None
    found = root.joinpath(*parts)
    if not found.resolve().is_relative_to(root.resolve()) or not is_file(found):
        return None
    return found


def _is_plain(part: str) -> bool:
    """A name of a file or folder that leads nowhere else."""
    return bool(part) and not part.startswith(".") and "\\" not in part and "\0" not in part
