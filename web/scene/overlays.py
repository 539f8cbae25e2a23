"""What lies on the ground around the machine: support polygon, commanded path, reach, names.

Every overlay makes its nodes once and then answers with what changed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from walking_console.planner.geometry.paths import arc_of_command
from walking_console.planner.geometry.transforms import direction, placed, turned
from walking_console.planner.robot.model import Machine
from walking_console.planner.stability import support_polygon
from walking_console.planner.types import Command, Point
from walking_console.sim.snapshot import Snapshot

from .draped_mesh import EDGE_LIFT, LIFT, VERTICES, drape, draped_faces
from .palette import BAD, GOOD, PATH, RGB, WARN, for_scene, leg_names, margin_share
from .solids import disc
from .terrain_tiles import TerrainTiles
from .types import Change, Floats, Segments

COG_COLOUR = (232, 236, 242)
REACH_COLOUR = (120, 150, 190)
STROKE_COLOUR = (200, 170, 110)

MARGIN_STEPS = 24  # shades from red to green; more: the colour is sent nearly every frame
PATH_LENGTH = 1.6  # m of path drawn ahead of the centre of gravity
PATH_PIECES = 24
SPOT_TURN = (0.3, 1.5)  # rad, a turn on the spot is drawn as an arc between these bearings
SPOT = 0.05  # share of the pace below which a command counts as a turn on the spot
BARB_BACK = 0.14  # m, the arrow's head
BARB_OUT = 0.08  # m
FLAT: dict[str, Any] = {"side": "double", "cast_shadow": False, "receive_shadow": False}
NAME_SCALE = 0.8  # of viser's letters; larger: they hide the feet
NOTHING = np.zeros((1, 2, 3))  # line segments that show nothing


class Overlay:
    """Nodes of one kind, and what they showed last."""

    def __init__(self) -> None:
        self.handles: list[Any] = []
        self._shown: dict[str, Any] = {}

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        raise NotImplementedError

    def remove(self) -> None:
        """Take its nodes out of the scene."""
        for handle in self.handles:
            handle.remove()

    def _is_new(self, name: str, value: Any) -> bool:
        """True when this is not what was shown under that name; it is from now on."""
        if self._shown.get(name) == value:
            return False
        self._shown[name] = value
        return True


OverlayMaker = Callable[[viser.ViserServer, Machine], Overlay]


class StabilityOverlay(Overlay):
    """The support polygon in the colour of its margin, dashed where that is small, and the centre
    of gravity over it.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        scene = server.scene
        folder = "/world/stability"
        flat = np.zeros((VERTICES, 3))
        self.fill = scene.add_mesh_simple(
            f"{folder}/fill", flat, draped_faces(), color=for_scene(GOOD), opacity=0.42, **FLAT
        )
        self.outline = scene.add_line_segments(
            f"{folder}/outline", NOTHING, for_scene(GOOD), thickness=0.014
        )
        upright = polyline([(0.0, 0.0, 0.0), (0.0, 0.0, machine.height)])
        self.plumb = scene.add_line_segments(
            f"{folder}/plumb", upright, COG_COLOUR, thickness=0.008
        )
        self.cog = scene.add_mesh_simple(
            f"{folder}/cog", *disc(0.0, 0.045), color=COG_COLOUR, **FLAT
        )
        self.handles = [self.fill, self.outline, self.plumb, self.cog]

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        x, y = snapshot.body[:2]
        below = terrain.height(x, y, min((foot[2] for foot in snapshot.feet), default=0.0))
        spot = (x, y, below + EDGE_LIFT)
        changes: list[Change] = [(self.cog, "position", spot), (self.plumb, "position", spot)]
        changes += self._reshaped(snapshot, terrain, below)
        colour = margin_colour(snapshot.polygon_margin)
        if self._is_new("margin", colour):
            changes.append((self.fill, "color", colour))
            changes.append((self.outline, "colors", np.array(colour, np.uint8)))
        return changes

    def _reshaped(self, snapshot: Snapshot, terrain: TerrainTiles, below: float) -> list[Change]:
        feet = zip(snapshot.feet, snapshot.support, strict=True)
        carrying = [foot for foot, carries in feet if carries]
        corners = support_polygon(carrying)
        dashed = margin_share(snapshot.polygon_margin) < 1.0  # not by its colour alone
        shape = tuple((round(a, 3), round(b, 3)) for a, b in corners)
        if not self._is_new("polygon", (shape, dashed)):
            return []
        heights = {(foot[0], foot[1]): foot[2] for foot in carrying}
        ring: list[Point] = [(x, y, heights[x, y]) for x, y in corners]
        mesh, edge = drape(np.array(ring or [(*snapshot.body[:2], below)]), terrain)
        shown = edge[::2] if dashed else edge
        return [(self.fill, "vertices", mesh), (self.outline, "points", shown)]


class PathOverlay(Overlay):
    """The commanded path ahead on the ground, with an arrow head; nothing while nothing is
    commanded.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        self.machine = machine
        self.line = server.scene.add_line_segments(
            "/world/path/line", NOTHING, for_scene(PATH), thickness=0.022, visible=False
        )
        self.handles = [self.line]

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        command = snapshot.command
        x, y, z, _, _, yaw = snapshot.body
        if snapshot.ahead is not None and snapshot.ahead.line:  # the preview's line is drawn
            return [(self.line, "visible", False)] if self._is_new("path", None) else []
        if not self._is_new("path", (round(x, 2), round(y, 2), round(yaw, 3), command)):
            return []
        if command.holds:
            return [(self.line, "visible", False)]
        lines = path_ahead((x, y, yaw), command, self.machine.yaw_length)
        heights = terrain.heights(lines.reshape(-1, 2), z - self.machine.height) + LIFT
        points = np.concatenate([lines, heights.reshape(-1, 2, 1)], axis=2).astype(np.float32)
        return [(self.line, "points", points), (self.line, "visible", True)]


class ReachOverlay(Overlay):
    """Reach rectangles at standing height, carried along by the body, and the stroke lines through
    their middles.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        self.machine = machine
        scene = server.scene
        boxes = reach_boxes(machine)
        self.boxes = scene.add_line_segments(
            "/world/reach/boxes", boxes, REACH_COLOUR, thickness=0.008
        )
        self.strokes = scene.add_line_segments(
            "/world/reach/strokes", NOTHING, STROKE_COLOUR, thickness=0.010
        )
        self.handles = [self.boxes, self.strokes]

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        x, y, z, _, _, yaw = snapshot.body
        place = (x, y, z - self.machine.height + LIFT)
        c, s = direction(yaw / 2)
        changes: list[Change] = []
        for handle in self.handles:
            changes += [(handle, "position", place), (handle, "wxyz", (c, 0.0, 0.0, s))]
        crab_angle = snapshot.command.crab_angle
        if self._is_new("strokes", round(crab_angle, 3)):
            changes.append((self.strokes, "points", stroke_lines(self.machine, crab_angle)))
        return changes


class NamesOverlay(Overlay):
    """The short name of every leg beside its foot, as page and charts call it."""

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        self.lift = 3.0 * machine.foot_radius
        self.handles = [
            server.scene.add_label(
                f"/world/names/{leg}", name, font_screen_scale=NAME_SCALE, anchor="bottom-center"
            )
            for leg, name in enumerate(leg_names(machine.legs), 1)
        ]

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        places = [(x, y, z + self.lift) for x, y, z in snapshot.feet]
        return [(label, "position", at) for label, at in zip(self.handles, places, strict=True)]


def margin_colour(margin: float) -> RGB:
    """Red at 0 and below, amber half-way, green from ``MARGIN_GOOD`` on, in the scene's colours."""
    share = round(margin_share(margin) * MARGIN_STEPS) / MARGIN_STEPS
    low, high = (BAD, WARN) if share < 0.5 else (WARN, GOOD)
    at = share * 2 if share < 0.5 else share * 2 - 1
    pairs = zip(for_scene(low), for_scene(high), strict=True)
    red, green, blue = (round(a + (b - a) * at) for a, b in pairs)
    return red, green, blue


def rotated(points: Floats, angle: float) -> Floats:
    """Points (n, 2) turned about the origin."""
    c, s = direction(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]), dtype=np.float64)


def polyline(points: Any) -> Segments:
    """A chain of points (n, 3) as line segments (n-1, 2, 3)."""
    chain = np.asarray(points, np.float32)
    return np.stack([chain[:-1], chain[1:]], axis=1)


def path_ahead(pose: tuple[float, float, float], command: Command, yaw_length: float) -> Floats:
    """The commanded path from a pose on as line segments (n, 2, 2), then its arrow head.

    A line, an arc or, where the machine turns on the spot, an arc about it.
    """
    arc, pace = arc_of_command(command.crab_angle, command.speed, command.turn_rate, yaw_length)
    if command.speed < SPOT * pace:
        points = _spot_turn(pose, math.copysign(yaw_length, command.turn_rate))
    else:
        s = np.linspace(0.0, PATH_LENGTH, PATH_PIECES + 1).tolist()
        points = np.array([placed(pose, *arc.pose(at)[:2]) for at in s])
    along = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])
    across = np.array((-along[1], along[0]))
    tip = points[-1] + 0.02 * along
    barbs = [points[-1] - BARB_BACK * along + side * BARB_OUT * across for side in (1, -1)]
    pieces = [*zip(points[:-1], points[1:], strict=True), *((tip, barb) for barb in barbs)]
    return np.array(pieces)


def _spot_turn(pose: tuple[float, float, float], radius: float) -> Floats:
    """An arc about the machine; to the right when ``radius`` is negative."""
    bearings = np.linspace(*SPOT_TURN, PATH_PIECES + 1) * math.copysign(1.0, radius)
    size = abs(radius)
    return np.array([placed(pose, *turned(size, 0.0, angle)) for angle in bearings.tolist()])


def reach_boxes(machine: Machine) -> Segments:
    """Every leg's reach rectangle in body axes, as line segments at height 0."""
    pieces = []
    for x0, x1, y0, y1 in machine.boxes:
        pieces.append(polyline([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0), (x0, y0, 0)]))
    return np.concatenate(pieces)


def stroke_lines(machine: Machine, crab_angle: float) -> Segments:
    """The stroke line of every leg: through the middle of its rectangle along the path, from edge
    to edge (H §4.3).
    """
    ux, uy = direction(crab_angle)
    pieces = []
    for leg in machine.legs:
        cx, cy = leg.centre
        half_x = (leg.x[1] - leg.x[0]) / 2
        half_y = (leg.y[1] - leg.y[0]) / 2
        half = min(half_x / max(abs(ux), 1e-9), half_y / max(abs(uy), 1e-9))
        rear = (cx - half * ux, cy - half * uy, 0.0)
        front = (cx + half * ux, cy + half * uy, 0.0)
        pieces.append((rear, front))
    return np.array(pieces, np.float32)
