"""``walking-console serve``: one process, one port, one line of output."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import socket
import sys
import threading
from collections.abc import Callable
from dataclasses import replace

from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import Snapshot
from walking_console.sim.world import World, prepare
from walking_console.web.scene.scene import Scene

from .api.app import create_app
from .api.errors import HTTPProblem
from .api.kept_world import KeptWorld
from .api.state import WORLD, AppSettings
from .api.terrain_edits import STROKES_A_TICK, edit_under, painted
from .bounded_log import OURS, BoundedHandler, LogBudget, is_of_others
from .browser import open_page
from .listening import (
    ANYWHERE,
    ServeError,
    check_names,
    check_token,
    check_viewer_token,
    is_loopback,
    lan_address,
    listen,
    own_names,
    url_of,
)
from .realtime_loop import RealtimeLoop
from .render_loop import RenderLoop
from .request_guard import LOOPBACK, is_address
from .scheduling import raise_priority
from .serve_options import FIRST_SCENARIO, LogLevel, ServeOptions
from .uploaded_file import read_by_child
from .uploads import Uploads
from .uvicorn_server import ConsoleServer, config_for
from .viser_bridge import BridgeError, ViserBridge

log = logging.getLogger(__name__)
LOG_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def serve(options: ServeOptions) -> None:
    """Serve the console until a signal ends it; raises ``ServeError``, or what a bad scenario or
    robot raises.
    """
    log_to_stderr(options.log_level)
    options = for_the_network(options) if options.lan else options
    check_token(options.host, options.token)
    check_viewer_token(options.token, options.viewer_token)
    check_names(options.allow_host, options.root_path)
    world = first_world(options)
    # explained for the page's inspector; a tick takes no longer for it
    loop = RealtimeLoop(Simulation(world, explain=True))
    listening = listen(options.host, options.port)
    try:
        bridge = ViserBridge()
    except BridgeError as error:
        listening.close()
        raise ServeError(str(error)) from None
    rendering = RenderLoop(loop, _scene(bridge, loop), lambda: bridge.watched)
    app = create_app(loop, app_settings(options), bridge)
    server = ConsoleServer(config_for(app), loop.hold_for_good)
    watching = url_of(listening, options.host, options.viewer_token)
    _announce_when_ready(server, url_of(listening, options.host, options.token), watching, options)
    log.info("runs are kept in %s", options.data.absolute())
    loop.start()
    rendering.start()
    raise_priority()
    bridge.server.get_event_loop().call_soon_threadsafe(raise_priority)
    try:
        asyncio.run(server.serve(sockets=[listening]))
    finally:
        loop.stop()
        rendering.stop()
        bridge.stop()


def first_world(options: ServeOptions) -> World:
    """The one that was asked for; where none was, the one last loaded. Raises what a bad scenario
    or robot raises.
    """
    if options.scenario is None and options.robot is None:
        kept = KeptWorld(options.data / WORLD).made(Uploads(options.data))
        if kept is not None:
            return kept
    robot = [] if options.robot is None else [f"robot={_quoted(options.robot)}"]
    return prepare(load_scenario(options.scenario or FIRST_SCENARIO, robot))


def for_the_network(options: ServeOptions) -> ServeOptions:
    """``--lan``: the address others reach this computer by, and tokens unless they are given."""
    unnamed = is_loopback(options.host) or options.host in ANYWHERE
    return replace(
        options,
        host=lan_address() if unnamed else options.host,
        token=options.token or secrets.token_urlsafe(32),
        viewer_token=options.viewer_token or secrets.token_urlsafe(32),
    )


def app_settings(options: ServeOptions) -> AppSettings:
    """Which names the app answers for, and where it keeps its runs."""
    host = options.host
    named = () if host in LOOPBACK or is_address(host) else (host,)
    alone = is_loopback(host)
    return AppSettings(
        data=options.data,
        hosts=named if alone else (*named, *own_names(socket.gethostname())),
        authorities=options.allow_host,
        root_path=options.root_path,
        addresses=not alone,
        token=options.token,
        viewer_token=options.viewer_token,
        sit_after=options.sit_after,
        read_upload=read_by_child,
    )


def log_to_stderr(level: LogLevel) -> None:
    """Say what happens, from this level on, on standard error; standard output has the address.
    Libraries say what is wrong, and no more; all together within the budget of one log.
    """
    ours = logging.getLogger(OURS)
    if not ours.handlers:
        budget = LogBudget()
        ours.addHandler(_on_stderr(budget))
        others = _on_stderr(budget)
        others.addFilter(is_of_others)
        logging.getLogger().addHandler(others)
    ours.setLevel(level.upper())


def _on_stderr(budget: LogBudget) -> BoundedHandler:
    shown = BoundedHandler(sys.stderr, budget)
    shown.setFormatter(logging.Formatter(LOG_FORMAT))
    return shown


def _scene(bridge: ViserBridge, loop: RealtimeLoop) -> Callable[[Snapshot], None]:
    """The drawing of one scene; made here, so that only ``web`` knows how. A click with a brush
    leaves a request for the walk.
    """
    scene = Scene(bridge.server)

    def paint(brush: str, x: float, y: float, radius: float) -> None:
        if loop.requests_waiting >= STROKES_A_TICK:
            return  # the next stroke is near enough
        with contextlib.suppress(HTTPProblem):  # beside the map
            loop.request(edit_under(painted(brush, x, y, radius), loop.newest.terrain))

    scene.on_paint = paint
    return scene.draw


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _announce_when_ready(
    server: ConsoleServer, url: str, watching: str, options: ServeOptions
) -> None:
    words = (server, url, watching, options)
    threading.Thread(target=_announce, args=words, daemon=True).start()


def _announce(server: ConsoleServer, url: str, watching: str, options: ServeOptions) -> None:
    """The one line of output, once the address answers; for telephones also as a picture. With a
    token for viewers a line for them, too.
    """
    server.listening.wait()
    print(url, flush=True)
    if options.lan:
        from .qr_code import print_qr_code  # here, so that nobody else needs its library

        print_qr_code(url)
    if options.viewer_token is not None:
        print(f"to watch and stop only: {watching}", flush=True)
    if options.open_page:
        open_page(url)
