"""HTTP and WebSockets: the routes, the page, ``/drive`` and the canvas, all on one port. Carries;
decides nothing.

Every route is a coroutine on the web loop; what takes longer than a millisecond (a world, a
scenario) goes to a worker thread, a run to a child process, and the walk has a thread of its own
(``clock``).
"""

from __future__ import annotations

import asyncio
import math
import secrets
import time
import traceback
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from fastapi import FastAPI, HTTPException, Query, Request, WebSocket
from fastapi import Path as PathPart
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response
from pydantic import BaseModel
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.websockets import WebSocketDisconnect

from walking_console.planner import registry
from walking_console.planner.control.supervisor import DT
from walking_console.planner.robot.model import MachineError, is_file, load_machine, machine_names
from walking_console.sim.requests import EDIT_CELLS_MAX, Edit, Follow
from walking_console.sim.runs.runner import product_version
from walking_console.sim.scenario import (
    Scenario,
    ScenarioError,
    list_scenarios,
    list_terrains,
    load_scenario,
    scenario_from,
    scenario_names,
)
from walking_console.sim.snapshot import TerrainView
from walking_console.sim.terrain.ground import GroundError
from walking_console.sim.world import World, prepare

from .. import schemas
from ..control_lease import DEAD_MAN, SIT_AFTER, Operator, Seat, TooFast
from ..explanation_frames import AheadFrame, DecisionFrame, ahead_frame, decision_frame
from ..frames import (
    HelloFrame,
    LeaseFrame,
    RefusedFrame,
    SnapshotFrame,
    as_text,
    number,
    snapshot_frame,
)
from ..realtime_loop import WalkingClock
from ..request_guard import COOKIE, Door, problem
from ..run_jobs import FILES, RunRefused, Runs
from ..schemas import BadFrame, Problem, read_frame
from ..viser_bridge import Canvas, clean_query

FRAME_MAX = 4096  # bytes of one frame on /drive
DRIVERS_MAX = 32  # sockets on /drive
SHOW_RATE = 30.0  # Hz, snapshots to one page at most
SEND_TIME = 5.0  # s a page may take for one snapshot before it is cut
ADVANCE_TIME = 20.0  # s
DRAW_TIME = 120.0  # s to draw a run's replay.html
LOADS_AT_ONCE = 1
OUTGOING: tuple[type[BaseModel], ...] = (
    HelloFrame,
    LeaseFrame,
    RefusedFrame,
    SnapshotFrame,
    AheadFrame,
    DecisionFrame,
)
PAGE_FILES = {
    ".html",
    ".js",
    ".css",
    ".svg",
    ".png",
    ".ico",
    ".map",
    ".json",
    ".webmanifest",
    ".woff2",
    ".txt",
}

DOCS = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>walking-console API</title><meta name="viewport" content="width=device-width">
<link rel="stylesheet" href="/vendor/swagger/swagger-ui.css"><link rel="icon" href="/vendor/swagger/favicon-32x32.png"></head>
<body><div id="docs"></div><script src="/vendor/swagger/swagger-ui-bundle.js"></script><script src="/docs/start.js"></script></body></html>
"""
DOCS_START = (
    'SwaggerUIBundle({url: "/openapi.json", dom_id: "#docs", deepLinking: true, validatorUrl: null, tryItOutEnabled: true,'
    ' presets: [SwaggerUIBundle.presets.apis], layout: "BaseLayout"});\n'
)
# a run's own file, but made of what somebody may have typed: no origin, no network
REPLAY_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline' blob: 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; connect-src data: blob:; worker-src blob:"
)
DESCRIPTION = """
Drive a simulated walking machine. SI units, with the unit in every key; strict: NaN, infinities, booleans, numeric strings,
unknown keys and out-of-range values are refused with `application/problem+json`, nothing is clamped.

`WS /drive` carries JSON text frames both ways: `DriveFrame`, `PostureFrame`, `TakeFrame`, `ReleaseFrame`, `StopFrame`, `RearmFrame` up;
`HelloFrame`, `LeaseFrame`, `RefusedFrame`, `SnapshotFrame` down (see Schemas). A held stick is repeated 20 to 30 times a
second; without a fresh frame the machine holds after 0.5 s and sits down after 10 s.
"""


@dataclass(frozen=True)
class Settings:
    """What the app is told when it is made."""

    data: Path = Path("walking-console-data")
    hosts: tuple[str, ...] = ()
    # any IP address may be the Host: for a console that listens beyond loopback
    addresses: bool = False
    token: str | None = None
    sit_after: float = SIT_AFTER  # s; 0: never
    # page/ and vendor/
    web: Path = field(default_factory=lambda: Path(str(resources.files("walking_console.web"))))


class Refusal(HTTPException):
    """A refusal with the field, value and limit that problem+json wants."""

    def __init__(
        self, status: int, detail: str, errors: list[dict[str, Any]] | None = None
    ) -> None:
        super().__init__(status, detail)
        self.errors = errors or []


def fault(name: str, value: Any, limit: Any, message: str) -> list[dict[str, Any]]:
    return [{"field": name, "value": value, "limit": limit, "message": message}]


class Pulse:
    """Wakes everybody who waits, at once: a new snapshot, a new holder, a refusal to send."""

    def __init__(self) -> None:
        self._next: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def beat(self) -> None:
        waited, self._next = self._next, asyncio.get_running_loop().create_future()
        waited.set_result(None)

    async def wait(self) -> None:
        await asyncio.shield(self._next)


class Desk:
    """What the routes share: the clock, who drives, the runs, the canvas."""

    def __init__(self, clock: WalkingClock, settings: Settings, canvas: Canvas | None) -> None:
        self.clock, self.settings, self.canvas = clock, settings, canvas
        self.operator = Operator(clock, settings.sit_after)
        self.runs = Runs(settings.data)
        self.pulse: Pulse | None = None
        self.drivers: set[str] = set()
        self.started = time.monotonic()
        self.loads = asyncio.Semaphore(LOADS_AT_ONCE)
        self._text: tuple[Any, str] = (None, "")

    @asynccontextmanager
    async def open(self) -> AsyncIterator[None]:
        """While the app serves, every snapshot wakes the pages; the walking thread only leaves a
        note for the loop.
        """
        loop = asyncio.get_running_loop()
        self.pulse = pulse = Pulse()

        def tell() -> None:
            try:
                loop.call_soon_threadsafe(pulse.beat)
            except RuntimeError:
                pass  # the loop has closed; the walk goes on until it is stopped

        self.clock.on_publish = tell
        try:
            yield
        finally:
            self.clock.on_publish = lambda: None
            self.operator.hold()
            await asyncio.to_thread(self.runs.stop)

    def wake(self) -> None:
        if self.pulse is not None:
            self.pulse.beat()

    def frame(self) -> dict[str, Any]:
        return snapshot_frame(
            self.clock.newest, stopped=self.operator.stopped, fault=self.clock.fault
        )

    def text(self) -> str:
        """The newest snapshot as JSON, made once for all pages."""
        key = (self.clock.newest, self.operator.stopped, self.clock.fault)
        if self._text[0] != key:
            self._text = (key, as_text(self.frame()))
        return self._text[1]

    async def until(self, done: Any, limit: float) -> bool:
        """Wait, snapshot by snapshot, until ``done()``; False when it took longer than ``limit`` s."""
        try:
            async with asyncio.timeout(limit):
                while not done():
                    if self.pulse is None or not self.clock.running:
                        # nobody else does: a test, or a console without its thread
                        self.clock.beat()
                    else:
                        await self.pulse.wait()
        except TimeoutError:
            return False
        return True


def create_app(
    clock: WalkingClock, settings: Settings | None = None, canvas: Canvas | None = None
) -> FastAPI:
    """The whole app around a clock; the caller starts and stops clock and canvas."""
    settings = settings or Settings()
    desk = Desk(clock, settings, canvas)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with desk.open():
            yield

    app = FastAPI(
        title="walking-console",
        version=product_version(),
        description=DESCRIPTION,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        responses={
            "default": {
                "model": Problem,
                "description": "refused",
                "content": {"application/problem+json": {}},
            }
        },
    )
    app.state.desk = desk
    app.add_middleware(
        Door, hosts=settings.hosts, token=settings.token, addresses=settings.addresses
    )
    app.add_exception_handler(RequestValidationError, _say_invalid)
    app.add_exception_handler(StarletteHTTPException, _say_http)
    app.add_exception_handler(Exception, _say_failure)
    _add_lists(app, desk)
    _add_console(app, desk)
    _add_runs(app, desk)
    _add_sockets(app, desk)
    _add_pages(app, desk)
    _describe_frames(app)
    return app


# errors


async def _say_invalid(_: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    errors = []
    for found in error.errors()[:20]:
        place = [str(part) for part in found["loc"] if part not in ("body", "query", "path")]
        limits = {key: value for key, value in (found.get("ctx") or {}).items() if key != "error"}
        value = found.get("input")
        errors.append(
            {
                "field": ".".join(place) or "body",
                "value": value,
                "limit": limits or None,
                "message": found["msg"],
            }
        )
    first = errors[0]
    return problem(422, f"{first['field']}: {first['message']}", errors)


async def _say_http(_: Request, error: Exception) -> Response:
    assert isinstance(error, StarletteHTTPException)
    headers = dict(error.headers) if error.headers else None
    return problem(error.status_code, str(error.detail), getattr(error, "errors", ()), headers)


async def _say_failure(_: Request, error: Exception) -> Response:
    trace = secrets.token_hex(4)
    print(f"trace {trace}: {''.join(traceback.format_exception(error))}", flush=True)
    return problem(500, f"the console failed; its log has trace {trace}")


# what there is


def _add_lists(app: FastAPI, desk: Desk) -> None:
    clock = desk.clock

    @app.get("/api/v1/health", tags=["what there is"])
    async def health() -> dict[str, Any]:
        """Version, uptime, tick lateness, and what is wrong if anything is."""
        return {
            "version": product_version(),
            "uptime_s": round(time.monotonic() - desk.started, 3),
            "ok": not clock.fault and not clock.stalled,
            "tick_late_s": {
                "last_second": number(clock.late),
                "worst": number(clock.worst),
            },
            "beats": clock.beats,
            "beats_skipped": clock.skipped,
            "beat_age_s": number(clock.beat_age),
            "stalled": clock.stalled,
            "fault": clock.fault.strip().rsplit("\n", 1)[-1],
            "paused": clock.paused,
            "rate": clock.rate,
            "drivers": len(desk.drivers),
            "canvases": desk.canvas.clients if desk.canvas else 0,
            "refused_frames": desk.operator.refusals,
            "holder": desk.operator.holder,
            "stopped": desk.operator.stopped,
        }

    @app.get("/api/v1/robots", tags=["what there is"])
    async def robots() -> list[dict[str, Any]]:
        machines = [load_machine(name) for name in machine_names()]
        return [
            {
                "name": m.name,
                "title": m.title,
                "legs": len(m.legs),
                "mass_kg": m.mass,
                "height_m": m.height,
            }
            for m in machines
        ]

    @app.get("/api/v1/terrains", tags=["what there is"])
    async def terrains() -> list[dict[str, str]]:
        return [{"name": name, "title": line} for name, line in list_terrains()]

    @app.get("/api/v1/scenarios", tags=["what there is"])
    async def scenarios() -> list[dict[str, str]]:
        return [{"name": name, "title": title} for name, title in list_scenarios()]


def chosen(body: schemas.ScenarioBody, settings: list[str] | None = None) -> Scenario:
    """The scenario a body names or holds. Over HTTP no file may be named."""
    try:
        if body.name is not None:
            if body.name not in scenario_names():
                raise ScenarioError(
                    f"unknown scenario {body.name!r}; there are: {', '.join(scenario_names())}"
                )
            data = load_scenario(body.name, settings or (), body.seed).as_data()
        else:
            given = scenario_from({"name": "inline", **(body.scenario or {})}, None)
            data = given.as_data() | ({} if body.seed is None else {"seed": body.seed})
            if settings:
                why = "settings change a scenario by name; put them into the inline one"
                raise Refusal(422, why, fault("settings", settings, None, why))
        if body.robot is not None:
            data["robot"] = body.robot
        if body.mode is not None:
            data["mode"] = body.mode
        scenario = scenario_from(data, None)
        load_machine(scenario.robot)
    except (ScenarioError, MachineError) as error:
        raise Refusal(
            422,
            str(error),
            fault("name" if body.name else "scenario", body.name or "inline", None, str(error)),
        ) from None
    return scenario


def made(scenario: Scenario) -> World:
    try:
        return prepare(scenario)
    except (ScenarioError, MachineError, GroundError) as error:
        raise Refusal(422, str(error), fault("scenario", scenario.name, None, str(error))) from None


# the console


def _add_console(app: FastAPI, desk: Desk) -> None:
    clock, operator = desk.clock, desk.operator
    tags: list[Any] = ["console"]

    @app.get("/api/v1/console", tags=tags, response_model=SnapshotFrame)
    async def newest() -> JSONResponse:
        """The newest snapshot."""
        return JSONResponse(desk.frame())

    @app.get("/api/v1/console/ahead", tags=tags, response_model=AheadFrame | None)
    async def ahead() -> AheadFrame | None:
        """What a trace walker foresees; null for any other."""
        return ahead_frame(clock.newest)

    @app.get("/api/v1/console/decision", tags=tags, response_model=DecisionFrame | None)
    async def decision() -> DecisionFrame | None:
        """Why the running step, or why there is none; null while it stands and nothing was
        refused.
        """
        return decision_frame(clock.newest)

    @app.put("/api/v1/console/command", tags=tags, status_code=202)
    async def command(body: schemas.CommandBody) -> dict[str, Any]:
        """Drive for at most `ttl_s`; repeat it to go on. Refused (409) while a page drives or after
        a stop.
        """
        why = operator.command(body.command(), body.ttl_s)
        if why:
            raise Refusal(409, why)
        return {"tick": clock.newest.tick, "ttl_s": body.ttl_s}

    @app.post("/api/v1/console/posture", tags=tags, status_code=202)
    async def posture(body: schemas.PostureBody) -> dict[str, Any]:
        """Stop, then sit down, stand up, or take the standard posture. Refused (409) while a page
        drives, after a stop, or fallen.
        """
        why = operator.pose(body.posture)
        if why:
            raise Refusal(409, why)
        return {"tick": clock.newest.tick, "posture": body.posture}

    @app.put("/api/v1/console/attitude", tags=tags, status_code=202)
    async def attitude(body: schemas.AttitudeBody) -> dict[str, Any]:
        """The body level, or leaning with the ground. Refused (409) for a planner that walks level
        only.
        """
        now = clock.newest
        if (
            body.attitude != "level"
            and not registry.capabilities(now.planner, now.planner_mode).may_lean
        ):
            able = registry.spoken(registry.choices_that(lambda planner: planner.may_lean))
            raise Refusal(409, f"the body follows the ground only with {able}")
        clock.request(Follow(body.attitude))
        return {"tick": now.tick, "attitude": body.attitude}

    @app.post("/api/v1/console/stop", tags=tags)
    async def stop() -> dict[str, Any]:
        """Stop, until `rearm`. Anybody may."""
        operator.stop()
        desk.wake()
        return {"stopped": True}

    @app.post("/api/v1/console/rearm", tags=tags)
    async def rearm() -> dict[str, Any]:
        """End a stop; refused (409) while a page drives: it must do so itself."""
        why = operator.rearm()
        if why:
            raise Refusal(409, why)
        desk.wake()
        return {"stopped": False}

    @app.post("/api/v1/console/reset", tags=tags, response_model=SnapshotFrame)
    async def reset() -> JSONResponse:
        """Back to the start of the scenario; also forgives a fault. A stop stays."""
        before = clock.newest
        operator.hold()
        clock.reset()
        await _settled(before)
        return JSONResponse(desk.frame())

    @app.post("/api/v1/console/pause", tags=tags, response_model=SnapshotFrame)
    async def pause() -> JSONResponse:
        clock.pause()
        await desk.until(lambda: clock.newest.paused or clock.fault, 1.0)
        return JSONResponse(desk.frame())

    @app.post("/api/v1/console/resume", tags=tags, response_model=SnapshotFrame)
    async def resume() -> JSONResponse:
        operator.hold()
        clock.resume()
        await desk.until(lambda: not clock.newest.paused or clock.fault, 1.0)
        return JSONResponse(desk.frame())

    @app.post("/api/v1/console/advance", tags=tags, response_model=SnapshotFrame)
    async def advance(body: schemas.AdvanceBody) -> JSONResponse:
        """Walk so many ticks; needs the paused state (409)."""
        if not clock.paused:
            raise Refusal(409, "advance needs the paused state")
        clock.advance(body.ticks)
        if not await desk.until(lambda: clock.owed == 0, ADVANCE_TIME):
            raise Refusal(503, f"{clock.owed} ticks are still to be walked")
        return JSONResponse(desk.frame())

    @app.post("/api/v1/console/rate", tags=tags)
    async def rate(body: schemas.RateBody) -> dict[str, Any]:
        """1 to 8 times real time; a held command must be given again."""
        if body.rate != clock.rate:
            operator.hold()
            clock.set_rate(body.rate)
        return {"rate": body.rate}

    @app.put("/api/v1/console/scenario", tags=tags, response_model=SnapshotFrame)
    async def scenario(body: schemas.ScenarioBody) -> JSONResponse:
        """Load a scenario by name or inline. The machine holds; the old world walks on until the
        new one is made.
        """
        async with desk.loads:
            world = await asyncio.to_thread(lambda: made(chosen(body)))
            before = clock.newest
            operator.hold()
            clock.load(world)
            await _settled(before)
        return JSONResponse(desk.frame())

    @app.patch("/api/v1/console/terrain", tags=tags)
    async def terrain(body: schemas.TerrainBody) -> dict[str, Any]:
        """Dig a hole, raise or lower, forbid or clear cells."""
        edit = edit_under(body, clock.newest.terrain)
        clock.request(edit)
        return {"action": edit.action, "cells": len(edit.cells)}

    async def _settled(before: Any) -> None:
        """Until a snapshot of the new world is out."""
        await desk.until(
            lambda: clock.newest.terrain.revision != before.terrain.revision or clock.fault, 5.0
        )


def edit_under(body: schemas.TerrainBody, terrain: TerrainView) -> Edit:
    """A terrain edit by its cells; raises ``Refusal`` when it is not on the map."""
    return Edit(body.action, cells_of(body, terrain), body.amount_m or 0.0)


def cells_of(body: schemas.TerrainBody, terrain: TerrainView) -> tuple[tuple[int, int], ...]:
    """The (row, column) cells under a terrain edit, all of them on the map."""
    ny, nx = terrain.heights.shape
    if body.cells is not None:
        for row, column in body.cells:
            if row >= ny or column >= nx:
                errors = fault(
                    "cells", [row, column], {"rows": ny, "columns": nx}, "not on the map"
                )
                raise Refusal(
                    422,
                    f"cell [{row}, {column}] is not on the map of {ny} rows and {nx} columns",
                    errors,
                )
        return tuple((row, column) for row, column in body.cells)
    place: schemas.Circle | schemas.Rectangle | None = body.circle or body.rectangle
    assert place is not None
    if isinstance(place, schemas.Circle):
        low, high = (
            (place.x_m - place.radius_m, place.y_m - place.radius_m),
            (place.x_m + place.radius_m, place.y_m + place.radius_m),
        )
    else:
        low, high = (place.x_m, place.y_m), (place.x_m + place.width_m, place.y_m + place.depth_m)
    spans = []
    for axis, count in ((0, nx), (1, ny)):
        first = math.floor((low[axis] - terrain.origin[axis]) / terrain.cell)
        last = math.floor((high[axis] - terrain.origin[axis]) / terrain.cell)
        spans.append(np.arange(max(0, first), min(count - 1, last) + 1))
    columns, rows = np.meshgrid(*spans)
    inside = np.ones(columns.shape, dtype=bool)
    if isinstance(place, schemas.Circle):
        x = terrain.origin[0] + (columns + 0.5) * terrain.cell - place.x_m
        y = terrain.origin[1] + (rows + 0.5) * terrain.cell - place.y_m
        inside = x * x + y * y <= place.radius_m**2
    cells = tuple(zip(rows[inside].tolist(), columns[inside].tolist(), strict=True))
    if not 1 <= len(cells) <= EDIT_CELLS_MAX:
        name = "circle" if isinstance(place, schemas.Circle) else "rectangle"
        detail = f"{name} covers {len(cells)} cells of the map; it must cover 1 to {EDIT_CELLS_MAX}"
        raise Refusal(422, detail, fault(name, len(cells), {"ge": 1, "le": EDIT_CELLS_MAX}, detail))
    return cells


# runs

RunId = Annotated[str, PathPart(pattern=schemas.SHIPPED_NAME, examples=["flat-0001"])]


def _add_runs(app: FastAPI, desk: Desk) -> None:
    runs = desk.runs
    tags: list[Any] = ["runs"]

    def known(run_id: str) -> str:
        if not runs.knows(run_id):
            raise Refusal(404, f"there is no run {run_id!r}")
        return run_id

    @app.post("/api/v1/runs", tags=tags, status_code=202, response_model=schemas.RunState)
    async def start(body: schemas.RunBody, response: Response) -> dict[str, Any]:
        """Start a scripted headless run in a process of its own."""
        scenario = await asyncio.to_thread(chosen, body, body.settings)
        try:
            run_id = runs.start(
                scenario.as_data(), body.name or scenario.name, trace_decisions=body.trace_decisions
            )
        except RunRefused as error:
            raise Refusal(error.status, str(error)) from None
        response.headers["location"] = f"/api/v1/runs/{run_id}"
        return runs.state(run_id)

    @app.get("/api/v1/runs", tags=tags, response_model=list[schemas.RunState])
    async def listed(limit: Annotated[int, Query(ge=1, le=1000)] = 100) -> list[dict[str, Any]]:
        """The newest runs by name, with progress and result."""
        return await asyncio.to_thread(
            lambda: [runs.state(run_id) for run_id in runs.ids()[-limit:]]
        )

    @app.get("/api/v1/runs/{run_id}", tags=tags, response_model=schemas.RunState)
    async def one(run_id: RunId) -> dict[str, Any]:
        """Progress and result."""
        return runs.state(known(run_id))

    @app.delete(
        "/api/v1/runs/{run_id}", tags=tags, status_code=202, response_model=schemas.RunState
    )
    async def cancel(run_id: RunId) -> dict[str, Any]:
        """Cancel a run; one that is over stays as it is."""
        runs.cancel(known(run_id))
        return runs.state(run_id)

    @app.get("/api/v1/runs/{run_id}/{name}", tags=tags, response_class=FileResponse)
    async def file(
        run_id: RunId, name: Annotated[str, PathPart(examples=["run.json"])]
    ) -> FileResponse:
        """run.json, ticks.npz, steps.jsonl, terrain.npz, inputs.jsonl or replay.html of a finished
        run.
        """
        known(run_id)
        if name not in FILES:
            raise Refusal(
                404,
                f"a run has no {name!r}; there are: {', '.join(FILES)}",
                fault("name", name, list(FILES), "unknown"),
            )
        path = runs.file(run_id, name)
        if path is None and name == "replay.html" and runs.file(run_id, "run.json") is not None:
            await _draw(run_id)
            path = runs.file(run_id, name)
        if path is None:
            raise Refusal(404, f"run {run_id!r} has no {name} (yet)")
        headers = {"content-security-policy": REPLAY_POLICY} if name == "replay.html" else None
        return FileResponse(path, media_type=FILES[name], headers=headers)

    async def _draw(run_id: str) -> None:
        child = runs.draw(run_id)
        try:
            await asyncio.to_thread(child.wait, DRAW_TIME)
        except Exception:
            child.kill()


# sockets


def _add_sockets(app: FastAPI, desk: Desk) -> None:
    operator, clock = desk.operator, desk.clock

    @app.websocket("/drive")
    async def drive(socket: WebSocket) -> None:
        if len(desk.drivers) >= DRIVERS_MAX:
            await socket.send_denial_response(
                problem(503, f"{DRIVERS_MAX} sockets are open already")
            )
            return
        name = secrets.token_hex(3)
        desk.drivers.add(name)
        seat = operator.sit(name)
        refused: deque[RefusedFrame] = deque(maxlen=16)
        try:
            await socket.accept()
            await socket.send_text(
                HelloFrame(
                    version=product_version(), lease_id=name, dead_man_s=DEAD_MAN, tick_s=DT
                ).model_dump_json()
            )
            showing = asyncio.create_task(show(socket, seat, refused))
            try:
                await hear(socket, seat, refused)
            finally:
                operator.leave(seat)  # before anything that waits: the machine holds at once
                showing.cancel()
                await asyncio.gather(showing, return_exceptions=True)
        except (WebSocketDisconnect, RuntimeError):
            pass  # gone while something was being sent
        finally:
            operator.leave(seat)
            desk.drivers.discard(name)
            desk.wake()

    async def hear(socket: WebSocket, seat: Seat, refused: deque[RefusedFrame]) -> None:
        """Every frame from one socket, until it goes, floods or sends what is no frame."""
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            try:
                operator.count(seat)
            except TooFast as error:
                operator.leave(seat)
                return await socket.close(1008, str(error))
            if text is None:
                operator.leave(seat)
                return await socket.close(1003, "text frames only")
            if len(text.encode("utf-8", "replace")) > FRAME_MAX:
                operator.leave(seat)
                return await socket.close(1009, f"a frame may have {FRAME_MAX} bytes")
            revision = operator.revision
            try:
                frame = read_frame(text)
                why, seq = operator.hear(seat, frame), getattr(frame, "seq", None)
            except BadFrame as error:
                operator.refusals += 1
                why, seq = str(error), error.seq
            if why:
                refused.append(RefusedFrame(seq=seq, reason=why))
            if why or operator.revision != revision:
                desk.wake()

    async def show(socket: WebSocket, seat: Seat, refused: deque[RefusedFrame]) -> None:
        """Who drives, what was refused and the newest snapshot, to one socket; a slow one misses
        snapshots, nobody else does.
        """
        assert desk.pulse is not None
        told, shown = -1, None
        foreseen: Any = None
        decided: Any = None
        try:
            while True:
                while refused:
                    await sent(socket, refused.popleft().model_dump_json())
                holder = operator.holder
                if told != operator.revision:
                    told = operator.revision
                    lease = LeaseFrame(
                        held=operator.holds(seat), holder=holder, stopped=operator.stopped
                    )
                    await sent(socket, lease.model_dump_json())
                text = desk.text()
                if text is not shown:
                    shown = text
                    await sent(socket, text)
                    newest = clock.newest
                    if newest.ahead is not foreseen:
                        foreseen = newest.ahead
                        foreseen_now = ahead_frame(newest)
                        gone = as_text({"type": "ahead"})
                        await sent(socket, foreseen_now.model_dump_json() if foreseen_now else gone)
                    if newest.decision is not None and newest.decision is not decided:
                        decided = newest.decision
                        why = decision_frame(newest)
                        assert why is not None
                        await sent(socket, why.model_dump_json())
                await asyncio.sleep(1.0 / SHOW_RATE)
                if desk.text() is shown and told == operator.revision and not refused:
                    await desk.pulse.wait()
        except (TimeoutError, WebSocketDisconnect, RuntimeError, OSError):
            operator.leave(seat)
            try:
                await asyncio.wait_for(socket.close(1008, "too slow"), 1.0)
            except (TimeoutError, WebSocketDisconnect, RuntimeError, OSError):
                pass

    async def sent(socket: WebSocket, text: str) -> None:
        async with asyncio.timeout(SEND_TIME):
            await socket.send_text(text)

    @app.websocket("/view")
    @app.websocket("/view/")
    async def view(socket: WebSocket) -> None:
        if desk.canvas is None:
            await socket.send_denial_response(problem(503, "this console has no canvas"))
            return
        try:
            await desk.canvas.carry(socket)
        except (WebSocketDisconnect, RuntimeError):
            pass


# pages


def page_policy(host: str) -> str:
    return (
        "default-src 'none'; script-src 'self'; worker-src 'self' blob:; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
        f"font-src 'self'; connect-src 'self' ws://{host} wss://{host}; frame-src 'self'; manifest-src 'self'; "
        "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    )


def _add_pages(app: FastAPI, desk: Desk) -> None:
    web, token = desk.settings.web, desk.settings.token
    page = web / "page"

    def page_headers(request: Request) -> dict[str, str]:
        return {
            "content-security-policy": page_policy(request.headers["host"]),
            "cache-control": "no-cache",
        }

    @app.get("/", include_in_schema=False)
    async def index(request: Request) -> Response:
        if not (page / "index.html").is_file():
            raise Refusal(404, "the page is not installed")
        return FileResponse(page / "index.html", headers=page_headers(request))

    @app.get("/login", include_in_schema=False)
    async def login(shown: Annotated[str, Query(alias="token", max_length=500)] = "") -> Response:
        """The printed address: keeps the token in a cookie that no script and no other page gets,
        and goes on to the page.
        """
        if token is None or not secrets.compare_digest(shown.encode(), token.encode()):
            raise Refusal(401, "this is not the token")
        answer = RedirectResponse("/", 303)
        answer.set_cookie(COOKIE, token, httponly=True, samesite="strict", path="/")
        return answer

    @app.get("/docs", include_in_schema=False)
    async def docs(request: Request) -> Response:
        return HTMLResponse(DOCS, headers=page_headers(request))

    @app.get("/docs/start.js", include_in_schema=False)
    async def docs_start() -> Response:
        return Response(DOCS_START, media_type="text/javascript")

    @app.get("/view", include_in_schema=False)
    @app.get("/view/", include_in_schema=False)
    async def view(request: Request) -> Response:
        if desk.canvas is None:
            raise Refusal(503, "this console has no canvas")
        try:
            cleaned = clean_query(request.url.query)
        except ValueError:
            cleaned = ""
        if cleaned is not None:
            return RedirectResponse(f"/view/?{cleaned}" if cleaned else "/view/", 307)
        canvas = desk.canvas
        headers = {
            "content-security-policy": canvas.content_policy(request.headers["host"]),
            "cache-control": "no-cache",
            "etag": canvas.etag,
            "vary": "accept-encoding",
        }
        if request.headers.get("if-none-match") == canvas.etag:
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            return HTMLResponse(canvas.page_gzipped, headers=headers | {"content-encoding": "gzip"})
        return HTMLResponse(canvas.page, headers=headers)

    @app.get("/{path:path}", include_in_schema=False)
    async def static(request: Request, path: str) -> Response:
        """Files of the page: by suffix, and never outside its folder."""
        parts = path.removeprefix("static/").split("/")
        suffix = Path(parts[-1]).suffix
        root = web if parts[0] == "vendor" else page
        found = root.joinpath(*parts)
        sound = all(
            part and not part.startswith(".") and "\\" not in part and "\0" not in part
            for part in parts
        )
        if (
            not sound
            or suffix not in PAGE_FILES
            or not found.resolve().is_relative_to(root.resolve())
            or not is_file(found)
        ):
            raise Refusal(404, f"there is nothing at /{path[:200]}")
        return FileResponse(found, headers=page_headers(request))


def _describe_frames(app: FastAPI) -> None:
    """The shapes of /drive among the schemas: OpenAPI has no word for WebSockets."""
    plain = app.openapi

    def described() -> dict[str, Any]:
        if app.openapi_schema is None:
            schema = plain()
            known = schema.setdefault("components", {}).setdefault("schemas", {})
            for shape in (*schemas.FRAMES.values(), *OUTGOING):
                known[shape.__name__] = shape.model_json_schema(
                    ref_template="#/components/schemas/{model}"
                )
            up, down = (
                [s.__name__ for s in schemas.FRAMES.values()],
                [s.__name__ for s in OUTGOING],
            )
            schema["x-websockets"] = {"/drive": {"client-to-server": up, "server-to-client": down}}
        return app.openapi_schema or plain()

    app.openapi = described  # type: ignore[method-assign]
