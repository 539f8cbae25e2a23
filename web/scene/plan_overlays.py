"""What the planner intends: the running step with its search, and the preview of a traced path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine
from walking_console.planner.types import GaitPreview, Phase, Point, StepPlan
from walking_console.sim.snapshot import Snapshot

from .draped_mesh import LIFT
from .overlays import FLAT, NOTHING, Overlay, polyline
from .palette import BAD, LEGS, PATH, WARN, for_scene
from .solids import circle, disc
from .terrain_tiles import TerrainTiles
from .types import Change, Floats, Segments

Colours = NDArray[np.uint8]  # of line segments, (n, 2 ends, 3)
Landing = tuple[float, float, float, int]  # x, y, z, leg

START_COLOUR = (232, 236, 242)
PAST_GOAL = (88, 104, 124)  # the path beyond what the preview was asked for
LANDING_LIFT = 0.012  # m above the foothold
START_LIFT = 0.016  # m above the search start
RING = 0.038  # m, radius of the ring round a planned foothold
RING_CORNERS = 10
DEAD_END = 0.16  # m, half the bar across the path where the way ends
REFUSED_SHOWN = 200  # cells
CROSS = 0.016  # m, half the size of the cross on a refused cell


class StepOverlay(Overlay):
    """Foot path and foothold J_u of the running step, and where it was searched: I_u, D_u and the
    refused cells.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        scene = server.scene
        amber = for_scene(WARN)
        self.path = scene.add_line_segments("/world/plan/path", NOTHING, amber, thickness=0.012)
        self.landing = scene.add_mesh_simple(
            "/world/plan/landing", *disc(0.055, 0.085), color=amber, visible=False, **FLAT
        )
        self.target = scene.add_mesh_simple(
            "/world/plan/target", *disc(0.0, 0.022), color=amber, visible=False, **FLAT
        )
        self.start = scene.add_mesh_simple(
            "/world/search/start", *disc(0.030, 0.042), color=START_COLOUR, visible=False, **FLAT
        )
        self.domain = scene.add_line_segments(
            "/world/search/domain", NOTHING, for_scene(PATH), thickness=0.009, visible=False
        )
        self.refused = scene.add_line_segments(
            "/world/search/refused", NOTHING, for_scene(BAD), thickness=0.007, visible=False
        )
        marks = [self.landing, self.target, self.start]
        self.handles = [self.path, *marks, self.domain, self.refused]
        self._plan: StepPlan | None = None

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before: once a step."""
        plan = snapshot.plan
        if plan is self._plan:
            return []
        self._plan = plan
        stepping = plan is not None and bool(plan.swing)
        return [
            *self._marked(plan if stepping else None),
            *_lines(self.domain, domain_outline(plan)),
            *_lines(self.refused, refused_crosses(plan, terrain)),
        ]

    def _marked(self, plan: StepPlan | None) -> list[Change]:
        landing = plan.landing if plan is not None else None
        start = plan.search_start if plan is not None else None
        return [
            *_placed(self.landing, landing, LANDING_LIFT),
            *_placed(self.target, landing, LANDING_LIFT),
            *_placed(self.start, start, START_LIFT),
            *_lines(self.path, foot_paths(plan) if plan is not None else None),
        ]


class PreviewOverlay(Overlay):
    """The path ahead of a trace walker, red where no way is found on it, and the footholds planned
    on it, each in its leg's colour.
    """

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        scene = server.scene
        colours = np.zeros((1, 2, 3), np.uint8)
        self.line = scene.add_line_segments(
            "/world/preview/line", NOTHING, colours, thickness=0.022, visible=False
        )
        self.rings = scene.add_line_segments(
            "/world/preview/footholds", NOTHING, colours, thickness=0.013, visible=False
        )
        self.handles = [self.line, self.rings]
        self._preview: GaitPreview | None = None

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before: once a planning."""
        preview = snapshot.ahead
        if preview is self._preview:
            return []
        self._preview = preview
        if preview is None:
            return [(self.line, "visible", False), (self.rings, "visible", False)]
        line, colours = preview_lines(preview)
        level = float(np.median([foot[2] for foot in snapshot.feet]))
        heights = terrain.heights(line.reshape(-1, 2), level).reshape(-1, 2, 1) + LIFT
        points = np.concatenate([line, heights], axis=2).astype(np.float32)
        footholds = [(*at, leg) for leg, places in enumerate(preview.footholds) for at in places]
        return [
            *_coloured_lines(self.line, points, colours),
            *_coloured_lines(self.rings, foothold_rings(footholds), ring_colours(footholds)),
        ]


def _placed(handle: viser.MeshHandle, place: Point | None, lift: float) -> list[Change]:
    """A mark at a place, or hidden."""
    if place is None:
        return [(handle, "visible", False)]
    above = (place[0], place[1], place[2] + lift)
    return [(handle, "visible", True), (handle, "position", above)]


def _lines(handle: viser.LineSegmentsHandle, points: Segments | None) -> list[Change]:
    """Line segments, or hidden ones."""
    if points is None:
        return [(handle, "visible", False)]
    return [(handle, "visible", True), (handle, "points", points)]


def _coloured_lines(
    handle: viser.LineSegmentsHandle, points: Segments, colours: Colours
) -> list[Change]:
    """Line segments in many colours, hidden when there are none."""
    if not len(points):
        return [(handle, "visible", False)]
    # colours first: the page lays lines at new points
    return [(handle, "visible", True), (handle, "colors", colours), (handle, "points", points)]


def foot_paths(plan: StepPlan) -> Segments:
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


def domain_outline(plan: StepPlan | None) -> Segments | None:
    """The search domain D_u where the plan's decision has it: corners in absolute x, y at the
    height of the search start.
    """
    if plan is None or not plan.decision:
        return None
    corners = plan.decision.get("domain")
    if not isinstance(corners, list | tuple) or len(corners) < 3:
        return None
    if any(len(corner) != 2 for corner in corners):
        return None
    place = plan.search_start or plan.landing
    z = (place[2] if place else 0.0) + LIFT
    return polyline([(x, y, z) for x, y in (*corners, corners[0])])


def refused_crosses(plan: StepPlan | None, terrain: TerrainTiles) -> Segments | None:
    """A small cross on every cell refused on the way from I_u to J_u, where the plan's decision has
    them.
    """
    if plan is None or not plan.decision or not plan.swing:
        return None
    cells = [
        (cell["x"], cell["y"])
        for trial in plan.decision.get("legs", ())
        if trial.get("leg") == plan.swing[0] + 1
        for cell in trial.get("refused", ())
    ]
    if not cells:
        return None
    places = np.array(cells[:REFUSED_SHOWN])
    otherwise = plan.landing[2] if plan.landing is not None else 0.0
    middles = np.column_stack([places, terrain.heights(places, otherwise) + LIFT])
    rising = [(-1.0, -1.0, 0.0), (1.0, 1.0, 0.0)]
    falling = [(-1.0, 1.0, 0.0), (1.0, -1.0, 0.0)]
    arms = CROSS * np.array([rising, falling])
    return (middles[:, None, None] + arms[None]).reshape(-1, 2, 3).astype(np.float32)


def preview_lines(preview: GaitPreview) -> tuple[Floats, Colours]:
    """The path as line segments (n, 2, 2) with colours: as far as the walk is sure, red up to the
    goal, pale beyond.

    At a dead end a bar lies across it.
    """
    table = np.array(preview.line)
    if len(table) < 2:
        return np.zeros((0, 2, 2)), np.zeros((0, 2, 3), np.uint8)
    s = table[:, 0]
    way = table[:, 1:]
    pieces = np.stack([way[:-1], way[1:]], axis=1)
    middle = (s[:-1] + s[1:]) / 2
    colours = np.full((len(pieces), 3), PAST_GOAL, np.uint8)
    colours[middle <= preview.goal] = for_scene(BAD)
    colours[middle <= preview.reached] = for_scene(PATH)
    if not preview.complete:
        at = min(int(np.searchsorted(s, preview.reached)), len(s) - 2)
        pieces = np.concatenate([pieces, [_bar_across(way[at], way[at + 1])]])
        colours = np.concatenate([colours, np.array([for_scene(BAD)], np.uint8)])
    return pieces, np.repeat(colours[:, None], 2, axis=1)


def _bar_across(start: Floats, end: Floats) -> Floats:
    """A segment (2, 2) at right angles to the way from start to end, at its start."""
    along = end - start
    across = np.array((-along[1], along[0])) / max(float(np.linalg.norm(along)), 1e-9)
    return np.array([start - DEAD_END * across, start + DEAD_END * across])


def foothold_rings(footholds: Sequence[Landing]) -> Segments:
    """A level ring round every foothold, as line segments."""
    rim = np.column_stack([circle(RING, RING_CORNERS), np.full(RING_CORNERS, LANDING_LIFT)])
    middles = np.array([foothold[:3] for foothold in footholds]).reshape(-1, 3)
    start = middles[:, None] + rim
    pieces = np.stack([start, np.roll(start, -1, axis=1)], axis=2)
    return pieces.reshape(-1, 2, 3).astype(np.float32)


def ring_colours(footholds: Sequence[Landing]) -> Colours:
    """The colours of those line segments: a leg's own."""
    each = [for_scene(LEGS[foothold[3]]) for foothold in footholds]
    colours = np.array(each, np.uint8).reshape(-1, 3)
    return np.repeat(np.repeat(colours, RING_CORNERS, axis=0)[:, None], 2, axis=1)
