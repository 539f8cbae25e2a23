"""The viser canvas: handles made once under fixed names, ``draw(snapshot)`` assigns what changed.
Shows, never decides.

Everything lies under one frame, ``/world``. A client that follows the machine has a frame of its
own under that name, moved to minus the machine's place: the camera stays the user's, the ground
slides by.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import support_polygon
from walking_console.planner.types import GaitPreview, Phase, Point, StepPlan
from walking_console.sim.snapshot import Snapshot, TerrainView

from . import terrain as earth
from .robot_shapes import Figure, attitude, circle, quaternions

Floats = NDArray[np.float64]

FOLDS = 8  # small triangles a side when a polygon is laid over the ground
CORNERS = 8  # corners a support polygon can have: as many as a machine can have legs
SHADOW_RINGS, SHADOW_CORNERS = 5, 24
LIFT = 0.03  # m, overlays above the ground: less flickers through it
COURSE_LENGTH = 1.6  # m of course drawn ahead of the centre of gravity
RING, RING_CORNERS = 0.038, 10  # m and corners of the ring round a planned foothold
DEAD_END = 0.16  # m, half the bar across the trace where the way ends
REFUSED_SHOWN = 200  # cells
CROSS = 0.016  # m, half the size of the cross on a refused cell
TRAIL_HZ = 5.0  # trails are sent this often (line geometry is rebuilt on the page)
MARGIN_GOOD = 0.08  # m, polygon margin drawn fully green

# The page's renderer maps tones as a film does: bright colours pale, so these are stronger than
# they will look
CYAN = (0, 150, 235)
AMBER = (255, 138, 0)
WHITE = (232, 236, 242)
DARK = (4, 6, 10)
RED = (228, 28, 18)
GREEN = (0, 178, 84)
SKY_TOP, SKY_HORIZON, SKY_BELOW = (
    (0.050, 0.066, 0.098),
    (0.290, 0.335, 0.385),
    (0.150, 0.175, 0.210),
)
PAST_GOAL = (88, 104, 124)
FOG = (46, 55, 66)
FOOT_FREE, FOOT_CARRIES, FOOT_SLACK = AMBER, (222, 226, 230), RED
LEG_COLOURS = (
    (226, 38, 52), (246, 150, 0), (0, 172, 84), (20, 104, 240), (148, 52, 228), (232, 56, 150), (0, 172, 184), (176, 168, 0),
)  # fmt: skip

CAMERA = (-2.1, -2.5, 1.15)  # m, first look, from the machine's centre of gravity
LOOK_AT = (0.15, 0.0, -0.40)
LAYERS = {
    "Trails": "trails", "Plan": "plan", "Search": "search", "Stability": "stability", "Course": "course", "Trace": "trace",
    "Reach": "reach",
}  # fmt: skip
HIDDEN_AT_FIRST = ("Reach",)
BRUSHES = ("dig", "raise", "lower", "forbid", "clear")
BRUSH, WIDE_BRUSH = 0.12, 0.35  # m, radius
RAY_STEP = 0.02  # m along a click's ray between looks at the ground
RAY_MAX = 40.0  # m


class Scene:
    """One viser server's scene. Called from one thread; viser's callbacks only note who is looking."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self._watchers: dict[int, Watcher] = {}
        self._machine: Machine | None = None
        self._ground: GroundTiles | None = None
        self._overlay: Overlay | None = None
        self._walker: Walker | None = None
        # called from viser's threads
        self.on_paint: Callable[[str, float, float, float], None] = lambda brush, x, y, radius: None
        self._set_stage()
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._farewell)

    def draw(self, snapshot: Snapshot) -> None:
        """Show this instant: one atomic update, one flush."""
        if snapshot.machine is not self._machine and snapshot.machine != self._machine:
            self._rebuild(snapshot.machine)
        assert self._walker is not None and self._overlay is not None and self._ground is not None
        self._ground.draw(snapshot.terrain)
        changes = [*self._walker.changes(snapshot), *self._overlay.changes(snapshot, self._ground)]
        eye = (-snapshot.body[0], -snapshot.body[1], -snapshot.body[2])
        watchers = [w for w in list(self._watchers.values()) if w.follows]
        with self.server.atomic():
            for handle, name, value in changes:
                setattr(handle, name, value)
        for watcher in watchers:
            watcher.move(eye)
        self.server.flush()

    def _rebuild(self, machine: Machine) -> None:
        with self.server.atomic():
            for old in (self._walker, self._overlay):
                if old is not None:
                    old.remove()
            self._machine = machine
            self._walker = Walker(self.server, Figure(machine))
            self._overlay = Overlay(self.server, machine)
            if self._ground is None:
                self._ground = GroundTiles(self.server)

    def _set_stage(self) -> None:
        scene, gui = self.server.scene, self.server.gui
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        scene.add_frame("/world", show_axes=False)
        for folder in LAYERS.values():
            scene.add_frame(f"/world/{folder}", show_axes=False)
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        # reflections cost a quarter of the frame where there is no GPU
        scene.configure_environment_map(None)
        scene.add_light_directional(
            "/sun", color=(255, 244, 228), intensity=2.6, position=(-3.0, 3.0, 5.0)
        )
        scene.add_light_directional(
            "/fill", color=(205, 218, 240), intensity=1.0, position=(1.0, -4.0, 1.6)
        )
        scene.add_light_hemisphere(
            "/sky", sky_color=(200, 215, 235), ground_color=(96, 90, 82), intensity=2.0
        )
        scene.configure_fog(7.0, 26.0, color=FOG)
        scene.set_background_image(sky(), format="png")
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        camera = self.server.initial_camera
        camera.position, camera.look_at, camera.up, camera.fov = (
            CAMERA,
            LOOK_AT,
            (0.0, 0.0, 1.0),
            math.radians(50.0),
        )

    def _welcome(self, client: viser.ClientHandle) -> None:
        self._watchers[client.client_id] = Watcher(client, self._paint)

    def _paint(self, brush: str, eye: Floats, way: Floats, radius: float) -> None:
        """A click with a brush, as a ray in the world: on to whoever changes the ground."""
        place = self._ground.struck(eye, way) if self._ground is not None else None
        if place is not None:
            self.on_paint(brush, *place, radius)

    def _farewell(self, client: viser.ClientHandle) -> None:
        self._watchers.pop(client.client_id, None)


Change = tuple[Any, str, Any]  # handle, property, new value


class Watcher:
    """One viewer: whether it follows the machine and which layers it sees. The page works these
    switches from its own menu.
    """

    def __init__(
        self, client: viser.ClientHandle, paint: Callable[[str, Floats, Floats, float], None]
    ) -> None:
        self.client = client
        self.paint = paint
        self.brush, self.radius = "", BRUSH
        self.follows = True
        self.world = client.scene.add_frame("/world", show_axes=False)
        if client.camera.aspect < 1.0:
            self._home()  # an upright phone sees less to the sides
        self.layers: dict[str, viser.FrameHandle] = {}
        follow = client.gui.add_checkbox("Follow", True)
        follow.on_update(lambda event: self._set_follow(bool(event.target.value)))
        for label in LAYERS:
            box = client.gui.add_checkbox(label, label not in HIDDEN_AT_FIRST)
            box.on_update(self._switch(label))
            if label in HIDDEN_AT_FIRST:
                self._show(label, False)
        for brush in BRUSHES:
            client.gui.add_checkbox(f"Paint {brush}", False).on_update(self._take(brush))
        client.gui.add_checkbox("Wide brush", False).on_update(
            lambda event: self._widen(bool(event.target.value))
        )
        client.gui.add_button("Home").on_click(lambda _: self._home())

    def _take(self, brush: str) -> Callable[[Any], None]:
        """A brush in hand makes clicks paint; with none the scene is not asked for clicks at all."""

        def take(event: Any) -> None:
            held = self.brush
            self.brush = brush if event.target.value else "" if held == brush else held
            if self.brush and not held:
                self.client.scene.on_click()(self._click)
            elif held and not self.brush:
                self.client.scene.remove_click_callback()

        return take

    def _widen(self, wide: bool) -> None:
        self.radius = WIDE_BRUSH if wide else BRUSH

    def _click(self, event: viser.SceneClickEvent) -> None:
        if self.brush:
            self.paint(
                self.brush,
                np.array(event.ray_origin) - self.world.position,
                np.array(event.ray_direction),
                self.radius,
            )

    def _set_follow(self, follows: bool) -> None:
        self.follows = follows

    def _switch(self, label: str) -> Callable[[Any], None]:
        return lambda event: self._show(label, bool(event.target.value))

    def _show(self, label: str, shown: bool) -> None:
        if label not in self.layers:
            self.layers[label] = self.client.scene.add_frame(
                f"/world/{LAYERS[label]}", show_axes=False, visible=shown
            )
        self.layers[label].visible = shown

    def _home(self) -> None:
        away = min(max(1.0, 1.25 / self.client.camera.aspect), 2.2)
        place = tuple(look + away * (eye - look) for eye, look in zip(CAMERA, LOOK_AT, strict=True))
        with self.client.atomic():
            self.client.camera.position, self.client.camera.look_at = (
                np.array(place),
                np.array(LOOK_AT),
            )
            self.client.camera.up_direction = (0.0, 0.0, 1.0)

    def move(self, position: tuple[float, float, float]) -> None:
        self.world.position = position


class GroundTiles:
    """The ground, drawn again tile by tile where it changed."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self.view: TerrainView | None = None
        self.tiles: dict[str, tuple[int, viser.GlbHandle]] = {}
        self.floor: viser.GlbHandle | None = None

    def draw(self, view: TerrainView) -> None:
        if self.view is not None and (view is self.view or _same_ground(view, self.view)):
            return
        ground = earth.Ground(view.heights, view.forbidden, view.cell, view.origin)
        wanted = {tile.name: tile for tile in ground.tiles()}
        fresh = {
            name: ground.draw(tile)
            for name, tile in wanted.items()
            if self.tiles.get(name, (None,))[0] != tile.key
        }
        with self.server.atomic():
            for name in set(self.tiles) - set(wanted):
                self.tiles.pop(name)[1].remove()
            for name, data in fresh.items():
                self.tiles[name] = (wanted[name].key, self._show(name, data))
            self._show_floor(ground, view)
        self.view = view

    def _show_floor(self, ground: earth.Ground, view: TerrainView) -> None:
        """The dark floor under the holes; without holes it would only be painted over."""
        if (
            self.view is None
            or view.origin != self.view.origin
            or view.heights.shape != self.view.heights.shape
        ):
            self.floor = self.server.scene.add_glb(
                "/world/ground/floor", earth.floor(ground), cast_shadow=False, receive_shadow=False
            )
        assert self.floor is not None
        self.floor.visible = bool(np.isnan(view.heights).any())

    def _show(self, name: str, data: bytes) -> viser.GlbHandle:
        if name in self.tiles:
            handle = self.tiles[name][1]
            handle.glb_data = data
            return handle
        return self.server.scene.add_glb(
            f"/world/ground/{name}", data, cast_shadow=False, receive_shadow=False
        )

    def height(self, x: float, y: float, otherwise: float) -> float:
        """Ground height under a point; ``otherwise`` over holes and outside."""
        view = self.view
        assert view is not None
        column, row = int((x - view.origin[0]) // view.cell), int((y - view.origin[1]) // view.cell)
        if not (0 <= row < view.heights.shape[0] and 0 <= column < view.heights.shape[1]):
            return otherwise
        height = float(view.heights[row, column])
        return otherwise if math.isnan(height) else height

    def heights(self, points: Floats, otherwise: float) -> Floats:
        """Ground heights under many points (n, 2)."""
        view = self.view
        assert view is not None
        column, row = (((points[:, k] - view.origin[k]) // view.cell).astype(int) for k in (0, 1))
        inside = (
            (row >= 0)
            & (row < view.heights.shape[0])
            & (column >= 0)
            & (column < view.heights.shape[1])
        )
        found = np.full(len(points), np.nan)
        found[inside] = view.heights[row[inside], column[inside]]
        return np.where(np.isnan(found), otherwise, found)

    def struck(self, eye: Floats, way: Floats) -> tuple[float, float] | None:
        """Where a ray first meets the ground; holes are met at the height of the ground around.
        None outside the map.
        """
        view = self.view
        if view is None:
            return None
        points = eye + way / np.linalg.norm(way) * np.arange(0.0, RAY_MAX, RAY_STEP)[:, None]
        solid = view.heights[np.isfinite(view.heights)]
        level = float(np.median(solid)) if solid.size else 0.0
        below = np.flatnonzero(points[:, 2] <= self.heights(points[:, :2], level))
        if not below.size:
            return None
        x, y = points[below[0], :2].tolist()
        rows, columns = view.heights.shape
        inside = (
            0.0 <= x - view.origin[0] < columns * view.cell
            and 0.0 <= y - view.origin[1] < rows * view.cell
        )
        return (x, y) if inside else None


def _same_ground(a: TerrainView, b: TerrainView) -> bool:
    return a.revision == b.revision and a.heights is b.heights and a.forbidden is b.forbidden


class Walker:
    """Torso, thighs, shins and feet, a node each: the page applies poses at once and all together,
    instances of a batch a frame later, and a leg a frame behind its torso is seen to come off, at
    ×8 above all.
    """

    def __init__(self, server: viser.ViserServer, figure: Figure) -> None:
        self.figure = figure
        scene, legs = server.scene, range(1, figure.count + 1)
        plain: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
        self.torso = scene.add_glb("/world/torso", figure.torso(), **plain)
        self.thighs = [
            scene.add_glb(f"/world/thigh_{leg}", figure.thigh_shape(), **plain) for leg in legs
        ]
        self.shins = [
            scene.add_glb(f"/world/shin_{leg}", figure.shin_shape(), **plain) for leg in legs
        ]
        self.feet = [
            scene.add_mesh_simple(f"/world/foot_{leg}", *figure.foot_shape(), **plain)
            for leg in legs
        ]
        self.colours: list[Any] = [None] * figure.count

    def changes(self, snapshot: Snapshot) -> list[Change]:
        """Poses of every part, and the colour of a foot that lifts, lands or slips."""
        x, y, z, roll, pitch, yaw = snapshot.body
        origin, turn, feet = (
            np.array((x, y, z)),
            attitude(roll, pitch, yaw),
            np.array(snapshot.feet),
        )
        hips, knees, thighs, shins = self.figure.legs(origin, turn, feet)
        changes: list[Change] = [
            (self.torso, "position", origin),
            (self.torso, "wxyz", quaternions(turn[None])[0]),
        ]
        for parts, places, turns in ((self.thighs, hips, thighs), (self.shins, knees, shins)):
            for part, place, way in zip(parts, places, turns, strict=True):
                changes += [(part, "position", place), (part, "wxyz", way)]
        for leg, (foot, place) in enumerate(zip(self.feet, feet, strict=True)):
            changes.append((foot, "position", place))
            colour = foot_colour(snapshot.contact[leg], snapshot.support[leg])
            if colour != self.colours[leg]:
                self.colours[leg] = colour
                changes.append((foot, "color", colour))
        return changes

    def remove(self) -> None:
        for handle in (self.torso, *self.thighs, *self.shins, *self.feet):
            handle.remove()


class Overlay:
    """What the walker thinks: support polygon, course, foothold and foot path of the running step,
    and where it has been.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        self.machine = machine
        self._plan: StepPlan | None = None
        self._ahead: GaitPreview | None = None
        self._seen: dict[str, Any] = {}
        scene = server.scene
        line: dict[str, Any] = {"points": np.zeros((1, 2, 3)), "colors": CYAN}
        flat: dict[str, Any] = {"side": "double", "cast_shadow": False, "receive_shadow": False}
        cloth = np.zeros((CORNERS * len(PATCH), 3))
        self.fill = scene.add_mesh_simple(
            "/world/stability/fill", cloth, cloth_faces(), color=GREEN, opacity=0.42, **flat
        )
        self.outline = scene.add_line_segments("/world/stability/outline", **line, thickness=0.014)
        upright = polyline([(0.0, 0.0, 0.0), (0.0, 0.0, machine.height)])
        self.plumb = scene.add_line_segments(
            "/world/stability/plumb", upright, WHITE, thickness=0.008
        )
        self.cog = scene.add_mesh_simple(
            "/world/stability/cog", *disc(0.0, 0.045), color=WHITE, **flat
        )
        self.course = scene.add_line_segments("/world/course/line", **line, thickness=0.022)
        self.path = scene.add_line_segments(
            "/world/plan/path", np.zeros((1, 2, 3)), AMBER, thickness=0.012
        )
        self.landing = scene.add_mesh_simple(
            "/world/plan/landing", *disc(0.055, 0.085), color=AMBER, visible=False, **flat
        )
        self.target = scene.add_mesh_simple(
            "/world/plan/target", *disc(0.0, 0.022), color=AMBER, visible=False, **flat
        )
        self.start = scene.add_mesh_simple(
            "/world/search/start", *disc(0.030, 0.042), color=WHITE, visible=False, **flat
        )
        self.domain = scene.add_line_segments(
            "/world/search/domain", **line, thickness=0.009, visible=False
        )
        self.refused = scene.add_line_segments(
            "/world/search/refused", np.zeros((1, 2, 3)), RED, thickness=0.007, visible=False
        )
        plain: dict[str, Any] = {
            "points": np.zeros((1, 2, 3)),
            "colors": np.zeros((1, 2, 3), np.uint8),
            "visible": False,
        }
        self.trace = scene.add_line_segments("/world/trace/line", **plain, thickness=0.022)
        self.treads = scene.add_line_segments("/world/trace/footholds", **plain, thickness=0.013)
        self.boxes = scene.add_line_segments(
            "/world/reach/boxes", reach_boxes(machine), (120, 150, 190), thickness=0.008
        )
        self.strokes = scene.add_line_segments(
            "/world/reach/strokes", np.zeros((1, 2, 3)), (200, 170, 110), thickness=0.010
        )
        shade = np.zeros(((SHADOW_RINGS + len(machine.legs)) * SHADOW_CORNERS, 3))
        self.shadow = scene.add_mesh_simple(
            "/world/shadow",
            shade,
            shadow_faces(len(machine.legs)),
            color=DARK,
            opacity=0.13,
            **flat,
        )
        self.trails = [
            Trail(scene, "/world/trails/feet", 72, 8, 0.012),
            Trail(scene, "/world/trails/body", 48, 8, 0.016),
        ]
        self._last_feet: list[Point] = []
        self._last_body: Point | None = None
        self._sent_trails = -math.inf
        self._clock = 0.0

    def changes(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        if snapshot.time < self._clock or snapshot.time > self._clock + 5.0:
            self._forget()
        self._clock = snapshot.time
        changes = self._stability(snapshot, ground)
        changes += self._course(snapshot, ground)
        if snapshot.plan is not self._plan:
            self._plan = snapshot.plan
            changes += self._intent(snapshot, ground)
        if snapshot.ahead is not self._ahead:
            self._ahead = snapshot.ahead
            changes += self._foreseen(snapshot, ground)
        changes += self._shade(snapshot, ground)
        changes += self._reach(snapshot)
        changes += self._traces(snapshot, ground)
        return changes

    def _stability(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        x, y = snapshot.body[:2]
        below = ground.height(x, y, min((foot[2] for foot in snapshot.feet), default=0.0))
        spot = (x, y, below + LIFT + 0.004)
        changes: list[Change] = [(self.cog, "position", spot), (self.plumb, "position", spot)]
        carrying = [
            foot for foot, carries in zip(snapshot.feet, snapshot.support, strict=True) if carries
        ]
        corners = support_polygon(carrying)
        if self._is_new("polygon", tuple((round(a, 3), round(b, 3)) for a, b in corners)):
            heights = {(foot[0], foot[1]): foot[2] for foot in carrying}
            ring = np.array([(cx, cy, heights[cx, cy]) for cx, cy in corners] or [(x, y, below)])
            cloth, hem = drape(ring, ground)
            changes += [(self.fill, "vertices", cloth), (self.outline, "points", hem)]
        colour = margin_colour(snapshot.polygon_margin)
        if self._is_new("margin", colour):
            changes += [
                (self.fill, "color", colour),
                (self.outline, "colors", np.array(colour, np.uint8)),
            ]
        return changes

    def _course(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        """The course ahead on the ground, with an arrow head; nothing while nothing is commanded."""
        command = snapshot.command
        x, y, yaw = snapshot.body[0], snapshot.body[1], snapshot.body[5]
        if snapshot.ahead is not None and snapshot.ahead.line:  # the trace itself is drawn
            return [(self.course, "visible", False)] if self._is_new("course", None) else []
        if not self._is_new("course", (round(x, 2), round(y, 2), round(yaw, 3), command)):
            return []
        if command.holds:
            return [(self.course, "visible", False)]
        lines = course_ahead(
            x, y, yaw, command.crab_angle, command.speed, command.turn_rate, self.machine.yaw_length
        )
        level = snapshot.body[2] - self.machine.height
        heights = [[ground.height(px, py, level) + LIFT for px, py in line] for line in lines]
        points = np.dstack([lines, heights]).astype(np.float32)
        return [(self.course, "points", points), (self.course, "visible", True)]

    def _foreseen(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        """The trace ahead, red where no way is found on it, and the footholds planned on it, each
        in its leg's colour.
        """
        ahead = snapshot.ahead
        if ahead is None:
            return [(self.trace, "visible", False), (self.treads, "visible", False)]
        level = float(np.median([foot[2] for foot in snapshot.feet]))
        line, colours = trace_lines(ahead)
        heights = ground.heights(line.reshape(-1, 2), level).reshape(-1, 2, 1)
        rings = [
            (x, y, z, leg) for leg, footholds in enumerate(ahead.footholds) for x, y, z in footholds
        ]
        changes: list[Change] = [
            (self.trace, "visible", len(line) > 0),
            (self.treads, "visible", bool(rings)),
        ]
        if len(line):
            points = np.concatenate([line, heights + LIFT], axis=2).astype(np.float32)
            # colours first: the page lays lines at new points
            changes += [(self.trace, "colors", colours), (self.trace, "points", points)]
        if rings:
            changes += [
                (self.treads, "colors", ring_colours(rings)),
                (self.treads, "points", foothold_rings(rings)),
            ]
        return changes

    def _intent(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        """Foot path, foothold J_u, search start I_u and search domain of the running step."""
        plan = snapshot.plan
        stepping = plan is not None and bool(plan.swing)
        changes: list[Change] = [(self.path, "visible", stepping)]
        landing = plan.landing if plan is not None and stepping else None
        start = plan.search_start if plan is not None and stepping else None
        for handle, place, lift in (
            (self.landing, landing, 0.012),
            (self.target, landing, 0.012),
            (self.start, start, 0.016),
        ):
            changes.append((handle, "visible", place is not None))
            if place is not None:
                changes.append((handle, "position", (place[0], place[1], place[2] + lift)))
        if plan is not None and stepping:
            changes.append((self.path, "points", foot_paths(plan)))
        outline = domain_outline(plan)
        changes.append((self.domain, "visible", outline is not None))
        if outline is not None:
            changes.append((self.domain, "points", outline))
        crosses = refused_crosses(plan, ground)
        changes.append((self.refused, "visible", crosses is not None))
        if crosses is not None:
            changes.append((self.refused, "points", crosses))
        return changes

    def _shade(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        """A soft shadow on the ground under the torso and under every foot: cheap, and it shows how
        high things are.
        """
        x, y, z, _, _, yaw = snapshot.body
        feet = [(foot[0], foot[1]) for foot in snapshot.feet]
        if not self._is_new(
            "shadow",
            (
                round(x, 2),
                round(y, 2),
                round(yaw, 2),
                tuple((round(a, 2), round(b, 2)) for a, b in feet),
            ),
        ):
            return []
        length, width, _ = self.machine.torso
        rim = (
            np.sign(circle(1.0, SHADOW_CORNERS))
            * np.sqrt(np.abs(circle(1.0, SHADOW_CORNERS)))
            * (length / 2, width / 2)
        )
        c, d = math.cos(yaw), math.sin(yaw)
        turned = rim @ np.array([[c, d], [-d, c]])
        rings = [turned * (0.55 + 0.16 * k) + (x + 0.12, y - 0.12) for k in range(SHADOW_RINGS)]
        spot = circle(2.6 * self.machine.foot_radius, SHADOW_CORNERS)
        flat = np.concatenate([*rings, *(spot + foot for foot in feet)])
        heights = ground.heights(flat, z - self.machine.height)
        level = np.repeat(np.arange(len(flat) // SHADOW_CORNERS) % SHADOW_RINGS, SHADOW_CORNERS)
        return [
            (
                self.shadow,
                "vertices",
                np.column_stack([flat, heights + 0.014 + 0.002 * level]).astype(np.float32),
            )
        ]

    def _reach(self, snapshot: Snapshot) -> list[Change]:
        """Reach rectangles at standing height, carried along by the body, and the stroke lines
        through their middles.
        """
        x, y, z, _, _, yaw = snapshot.body
        place = (x, y, z - self.machine.height + LIFT)
        spin = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
        changes: list[Change] = [
            (h, key, v)
            for h in (self.boxes, self.strokes)
            for key, v in (("position", place), ("wxyz", spin))
        ]
        if self._is_new("strokes", round(snapshot.command.crab_angle, 3)):
            changes.append(
                (self.strokes, "points", stroke_lines(self.machine, snapshot.command.crab_angle))
            )
        return changes

    def _traces(self, snapshot: Snapshot, ground: GroundTiles) -> list[Change]:
        feet_trail, body_trail = self.trails
        self._last_feet = self._last_feet or list(snapshot.feet)
        for index, (old, new) in enumerate(zip(self._last_feet, snapshot.feet, strict=True)):
            if math.dist(old, new) > 0.015:
                feet_trail.add(
                    (old[0], old[1], old[2] + 0.004),
                    (new[0], new[1], new[2] + 0.004),
                    LEG_COLOURS[index],
                )
                self._last_feet[index] = new
        x, y, z = snapshot.body[:3]
        here = (x, y, ground.height(x, y, z - self.machine.height) + LIFT)
        if self._last_body is None or math.dist(self._last_body[:2], here[:2]) > 0.06:
            if self._last_body is not None:
                body_trail.add(self._last_body, here, WHITE)
            self._last_body = here
        if snapshot.time - self._sent_trails < snapshot.rate / TRAIL_HZ:
            return []
        self._sent_trails = snapshot.time
        return [*feet_trail.changes(), *body_trail.changes()]

    def _is_new(self, name: str, value: Any) -> bool:
        if self._seen.get(name) == value:
            return False
        self._seen[name] = value
        return True

    def _forget(self) -> None:
        """Another run: the old trails mean nothing."""
        for trail in self.trails:
            trail.clear()
        self._last_feet, self._last_body, self._sent_trails = [], None, -math.inf

    def remove(self) -> None:
        parts = (self.fill, self.outline, self.plumb, self.cog, self.course, self.path, self.landing, self.target, self.start,
                 self.domain, self.refused, self.trace, self.treads, self.boxes, self.strokes, self.shadow)  # fmt: skip
        for handle in parts:
            handle.remove()
        for trail in self.trails:
            trail.remove()


class Trail:
    """Line pieces in a ring of chunks: only the chunk being filled is sent again, and the oldest is
    taken for reuse.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, size: int, chunks: int, thickness: float
    ) -> None:
        self.size = size
        self.handles = [
            scene.add_line_segments(
                f"{name}_{k}",
                np.zeros((1, 2, 3)),
                np.zeros((1, 2, 3), np.uint8),
                thickness=thickness,
                visible=False,
            )
            for k in range(chunks)
        ]
        self.clear()

    def clear(self) -> None:
        self.pieces: list[list[tuple[Point, Point]]] = [[] for _ in self.handles]
        self.colours: list[list[tuple[int, int, int]]] = [[] for _ in self.handles]
        self.at, self.stale = 0, set(range(len(self.handles)))

    def add(self, start: Point, end: Point, colour: tuple[int, int, int]) -> None:
        if len(self.pieces[self.at]) == self.size:
            self.at = (self.at + 1) % len(self.handles)
            self.pieces[self.at], self.colours[self.at] = [], []
        self.pieces[self.at].append((start, end))
        self.colours[self.at].append(colour)
        self.stale.add(self.at)

    def changes(self) -> list[Change]:
        """The chunks that differ from what was sent."""
        changes: list[Change] = []
        for k in sorted(self.stale):
            handle, pieces = self.handles[k], self.pieces[k]
            changes.append((handle, "visible", bool(pieces)))
            if pieces:
                changes.append(
                    (
                        handle,
                        "colors",
                        np.repeat(np.array(self.colours[k], np.uint8)[:, None], 2, axis=1),
                    )
                )
                changes.append((handle, "points", np.array(pieces, np.float32)))
        self.stale.clear()
        return changes

    def remove(self) -> None:
        for handle in self.handles:
            handle.remove()


def foot_colour(on_ground: bool, carries: bool) -> tuple[int, int, int]:
    """Light: carries. Amber: swings. Red: should carry and does not touch."""
    if carries:
        return FOOT_CARRIES if on_ground else FOOT_SLACK
    return FOOT_FREE


def margin_colour(margin: float) -> tuple[int, int, int]:
    """Red at 0 and below, amber, green from ``MARGIN_GOOD`` on; in 24 steps, so that it is seldom
    sent.
    """
    share = 0.0 if not math.isfinite(margin) else min(max(margin / MARGIN_GOOD, 0.0), 1.0)
    share = round(share * 24) / 24
    low, high, at = (RED, AMBER, share * 2) if share < 0.5 else (AMBER, GREEN, share * 2 - 1)
    red, green, blue = (round(a + (b - a) * at) for a, b in zip(low, high, strict=True))
    return red, green, blue


def disc(inner: float, outer: float, count: int = 28) -> tuple[Floats, NDArray[Any]]:
    """A level ring (a disc when ``inner`` is 0) facing up."""
    around = circle(1.0, count)
    points = np.hstack([np.concatenate([around * inner, around * outer]), np.zeros((2 * count, 1))])
    i, j = np.arange(count), (np.arange(count) + 1) % count
    return points, np.concatenate(
        [np.stack([i, count + i, count + j], 1), np.stack([i, count + j, j], 1)]
    )


def _cloth() -> Floats:
    """Weights (n, 3) of the points of a triangle cut into FOLDS² small ones: its middle corner,
    then the two outer ones.
    """
    return np.array(
        [
            (1 - i / FOLDS, (i - j) / FOLDS, j / FOLDS)
            for i in range(FOLDS + 1)
            for j in range(i + 1)
        ]
    )


PATCH = _cloth()


def cloth_faces() -> NDArray[Any]:
    """The small triangles of all corners' patches."""
    at = {(i, j): i * (i + 1) // 2 + j for i in range(FOLDS + 1) for j in range(i + 1)}
    up = [(at[i, j], at[i + 1, j], at[i + 1, j + 1]) for i in range(FOLDS) for j in range(i + 1)]
    down = [(at[i, j], at[i + 1, j + 1], at[i, j + 1]) for i in range(FOLDS) for j in range(i)]
    return np.concatenate([np.array(up + down) + corner * len(PATCH) for corner in range(CORNERS)])


def drape(ring: Floats, ground: GroundTiles) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """A polygon (n, 3) laid over the ground: points of its cloth, and its edge as line pieces.
    Never below the feet's own plane.
    """
    ring = np.concatenate([ring, np.repeat(ring[-1:], CORNERS - len(ring), axis=0)])
    middle, following = (
        ring[np.unique(ring, axis=0, return_index=True)[1]].mean(axis=0),
        np.roll(ring, -1, axis=0),
    )
    cloth = np.concatenate(
        [PATCH @ np.stack([middle, a, b]) for a, b in zip(ring, following, strict=True)]
    )
    share = np.linspace(0.0, 1.0, FOLDS + 1)[:, None]
    edges = np.stack([a * (1 - share) + b * share for a, b in zip(ring, following, strict=True)])
    for points, lift in ((cloth, LIFT), (edges.reshape(-1, 3), LIFT + 0.004)):
        points[:, 2] = np.maximum(points[:, 2], ground.heights(points[:, :2], -math.inf)) + lift
    return cloth.astype(np.float32), np.stack([edges[:, :-1], edges[:, 1:]], axis=2).reshape(
        -1, 2, 3
    ).astype(np.float32)


def shadow_faces(legs: int) -> NDArray[Any]:
    """Fans over rings of corners: some under the torso, stacked so that the edge is soft, and one
    under each foot.
    """
    fan = np.array([[0, i, i + 1] for i in range(1, SHADOW_CORNERS - 1)])
    return np.concatenate([fan + ring * SHADOW_CORNERS for ring in range(SHADOW_RINGS + legs)])


def polyline(points: Sequence[Sequence[float]] | Floats) -> NDArray[np.float32]:
    """A chain of points as line pieces (n-1, 2, 3)."""
    chain = np.asarray(points, np.float32)
    return np.stack([chain[:-1], chain[1:]], axis=1)


def course_ahead(
    x: float,
    y: float,
    yaw: float,
    crab_angle: float,
    speed: float,
    turn_rate: float,
    yaw_length: float,
) -> Floats:
    """The commanded course from (x, y) on as line pieces (n, 2, 2): a line, an arc or, on the spot,
    a turn arrow; then its head.
    """
    pace = math.hypot(speed, yaw_length * turn_rate)
    forward, turn = speed / pace, turn_rate / pace
    s = np.linspace(0.0, COURSE_LENGTH, 25)
    if forward < 0.05:  # turning on the spot: an arc about the machine
        angle = yaw + np.linspace(0.3, 0.3 + 1.2, 25) * math.copysign(1.0, turn_rate)
        points = np.stack([x + yaw_length * np.cos(angle), y + yaw_length * np.sin(angle)], axis=1)
    else:
        heading = yaw + crab_angle + turn * (s[:-1] + s[1:]) / 2
        steps = forward * (s[1] - s[0]) * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        points = np.concatenate([[(x, y)], (x, y) + np.cumsum(steps, axis=0)])
    along = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])
    across = np.array((-along[1], along[0]))
    barbs = [points[-1] - 0.14 * along + side * 0.08 * across for side in (1, -1)]
    return np.array(
        [
            *zip(points[:-1], points[1:], strict=True),
            *((points[-1] + 0.02 * along, barb) for barb in barbs),
        ]
    )


def foot_paths(plan: StepPlan) -> NDArray[np.float32]:
    """Paths of the swing feet through the plan's knots; the aim below the ground is cut off at the
    expected landing.
    """
    pieces = []
    for leg in plan.swing:
        path = plan.feet[:, leg].copy()
        if Phase.DOWN in plan.phases and leg not in plan.end.lifted:
            path[-1, 2] = max(path[-1, 2], plan.end.feet[leg][2])
        pieces.append(polyline(path))
    return np.concatenate(pieces)


def domain_outline(plan: StepPlan | None) -> NDArray[np.float32] | None:
    """The search domain D_u when the plan's decision tells it: corners in absolute x, y at the
    height of the search start.
    """
    decision = plan.decision if plan is not None else None
    corners = decision.get("domain") if decision else None
    if (
        plan is None
        or not isinstance(corners, list | tuple)
        or len(corners) < 3
        or any(len(corner) != 2 for corner in corners)
    ):
        return None
    place = plan.search_start or plan.landing
    z = (place[2] if place else 0.0) + LIFT
    return polyline([(c[0], c[1], z) for c in (*corners, corners[0])])


def refused_crosses(plan: StepPlan | None, ground: GroundTiles) -> NDArray[np.float32] | None:
    """A small cross on every cell refused on the way from I_u to J_u, when the plan's decision
    tells them.
    """
    decision = plan.decision if plan is not None else None
    if plan is None or not decision or not plan.swing:
        return None
    leg = plan.swing[0] + 1
    cells = [
        (cell["x"], cell["y"])
        for trial in decision.get("legs", ())
        if trial.get("leg") == leg
        for cell in trial.get("refused", ())
    ]
    if not cells:
        return None
    places = np.array(cells[:REFUSED_SHOWN])
    otherwise = plan.landing[2] if plan.landing is not None else 0.0
    middles = np.column_stack([places, ground.heights(places, otherwise) + LIFT])
    arms = CROSS * np.array(
        [[(-1.0, -1.0, 0.0), (1.0, 1.0, 0.0)], [(-1.0, 1.0, 0.0), (1.0, -1.0, 0.0)]]
    )
    return (middles[:, None, None] + arms[None]).reshape(-1, 2, 3).astype(np.float32)


def trace_lines(ahead: GaitPreview) -> tuple[Floats, NDArray[np.uint8]]:
    """The trace as line pieces (n, 2, 2) with colours (n, 2, 3): cyan as far as the walk is sure,
    red up to the goal, pale beyond.

    At a dead end a bar lies across it.
    """
    table = np.array(ahead.line)
    if len(table) < 2:
        return np.zeros((0, 2, 2)), np.zeros((0, 2, 3), np.uint8)
    s, way = table[:, 0], table[:, 1:]
    pieces = np.stack([way[:-1], way[1:]], axis=1)
    middle = (s[:-1] + s[1:]) / 2
    colours = np.where(
        (middle <= ahead.reached)[:, None],
        CYAN,
        np.where((middle <= ahead.goal)[:, None], RED, PAST_GOAL),
    )
    if not ahead.complete:
        at = min(int(np.searchsorted(s, ahead.reached)), len(s) - 2)
        along = way[at + 1] - way[at]
        across = np.array((-along[1], along[0])) / max(float(np.linalg.norm(along)), 1e-9)
        pieces = np.concatenate(
            [pieces, [[way[at] - DEAD_END * across, way[at] + DEAD_END * across]]]
        )
        colours = np.concatenate([colours, [RED]])
    return pieces, np.repeat(colours.astype(np.uint8)[:, None], 2, axis=1)


def foothold_rings(places: Sequence[tuple[float, float, float, int]]) -> NDArray[np.float32]:
    """A level ring round every (x, y, z, leg), as line pieces."""
    rim = np.column_stack([circle(RING, RING_CORNERS), np.full(RING_CORNERS, LIFT)])
    middles = np.array([place[:3] for place in places])
    start = middles[:, None] + rim
    return (
        np.stack([start, np.roll(start, -1, axis=1)], axis=2).reshape(-1, 2, 3).astype(np.float32)
    )


def ring_colours(places: Sequence[tuple[float, float, float, int]]) -> NDArray[np.uint8]:
    """The colours of those line pieces: a leg's own."""
    each = np.array([LEG_COLOURS[place[3]] for place in places], np.uint8)
    return np.repeat(np.repeat(each, RING_CORNERS, axis=0)[:, None], 2, axis=1)


def reach_boxes(machine: Machine) -> NDArray[np.float32]:
    """Every leg's reach rectangle in body axes, as line pieces at height 0."""
    pieces = []
    for x0, x1, y0, y1 in machine.boxes:
        pieces.append(polyline([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0), (x0, y0, 0)]))
    return np.concatenate(pieces)


def stroke_lines(machine: Machine, crab_angle: float) -> NDArray[np.float32]:
    """The stroke line of every leg: through the middle of its rectangle along the course, from edge
    to edge (H §4.3).
    """
    ux, uy = math.cos(crab_angle), math.sin(crab_angle)
    pieces = []
    for leg in machine.legs:
        (cx, cy), half_x, half_y = leg.centre, (leg.x[1] - leg.x[0]) / 2, (leg.y[1] - leg.y[0]) / 2
        half = min(half_x / max(abs(ux), 1e-9), half_y / max(abs(uy), 1e-9))
        pieces.append(
            [[cx - half * ux, cy - half * uy, 0.0], [cx + half * ux, cy + half * uy, 0.0]]
        )
    return np.array(pieces, np.float32)


def sky() -> NDArray[np.uint8]:
    """A dusk-blue gradient behind everything, lightest at the horizon."""
    down = np.linspace(0.0, 1.0, 256)
    colour = np.stack(
        [
            np.interp(down, (0.0, 0.42, 1.0), stops)
            for stops in zip(SKY_TOP, SKY_HORIZON, SKY_BELOW, strict=True)
        ],
        axis=1,
    )
    return np.asarray(np.rint(np.repeat(colour[:, None], 4, axis=1) * 255), dtype=np.uint8)
