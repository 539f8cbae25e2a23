"""The whole app: every route on one port, behind the guard. Carries; decides nothing.

Every route is a coroutine on the web loop; what takes longer than a millisecond (a world, a
scenario) goes to a worker thread, a run to a child process, and the walk has a thread of its own
(``realtime_loop``).
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI

from walking_console.sim.runs.runner import product_version

from ..path_prefix import PathPrefix
from ..realtime_loop import RealtimeLoop
from ..request_guard import RequestGuard
from ..schemas import Problem
from ..viser_bridge import ViserBridge
from . import (
    catalogue_routes,
    console_routes,
    drive_socket,
    pages,
    recording_routes,
    run_routes,
    session,
    sweep_routes,
    upload_routes,
)
from .errors import add_error_answers
from .openapi import DESCRIPTION, describe_frames
from .state import AppSettings, AppState

REFUSED: dict[int | str, dict[str, Any]] = {
    "default": {
        "model": Problem,
        "description": "refused",
        "content": {"application/problem+json": {}},
    }
}
# pages come last: they answer for every path that is left
ROUTERS = (
    catalogue_routes.router,
    console_routes.router,
    run_routes.router,
    sweep_routes.router,
    recording_routes.router,
    upload_routes.router,
    drive_socket.router,
    session.router,
    pages.router,
)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    state: AppState = app.state.console
    async with state.serving():
        yield


def create_app(
    loop: RealtimeLoop, settings: AppSettings | None = None, bridge: ViserBridge | None = None
) -> FastAPI:
    """The whole app around a real-time loop; the caller starts and stops loop and bridge."""
    settings = settings or AppSettings()
    app = FastAPI(
        title="walking-console",
        version=product_version(),
        description=DESCRIPTION,
        lifespan=_lifespan,
        docs_url=None,
        redoc_url=None,
        responses=REFUSED,
        servers=[{"url": "."}],  # where this description is, whatever prefix a proxy gives it
    )
    app.state.console = AppState(loop, settings, bridge)
    app.add_middleware(
        RequestGuard,
        hosts=settings.hosts,
        token=settings.token,
        viewer_token=settings.viewer_token,
        addresses=settings.addresses,
        authorities=settings.authorities,
    )
    app.add_middleware(PathPrefix, root_path=settings.root_path)  # the outermost
    add_error_answers(app)
    for router in ROUTERS:
        app.include_router(router)
    describe_frames(app)
    return app
