"""Where the feet and the body have been, as lines on the ground."""

from __future__ import annotations

import math

import numpy as np
import viser

from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Point
from walking_console.sim.snapshot import Snapshot

from .palette import LEGS, RGB, for_scene
from .terrain_tiles import TerrainTiles
from .types import Change

TRAIL_HZ = 5.0  # trails are sent this often: the page builds line geometry anew every time
FOOT_STEP = 0.015  # m a foot goes before its trail grows
BODY_STEP = 0.06  # m; longer than the gaps, so that the body's trail looks dashed in turns
FOOT_LIFT = 0.004  # m above the foot tip
BODY_LIFT = 0.03  # m above the ground; less flickers through it
BODY_COLOUR = (232, 236, 242)


class Trail:
    """Line pieces in a ring of chunks: only the chunk being filled is sent again, and the oldest is
    taken for reuse.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, size: int, chunks: int, thickness: float
    ) -> None:
        self.size = size
        points = np.zeros((1, 2, 3))
        colours = np.zeros((1, 2, 3), np.uint8)
        self.handles = [
            scene.add_line_segments(
                f"{name}_{k}", points, colours, thickness=thickness, visible=False
            )
            for k in range(chunks)
        ]
        self.clear()

    def clear(self) -> None:
        """Empty it, also on the page with the next changes."""
        self.pieces: list[list[tuple[Point, Point]]] = [[] for _ in self.handles]
        self.colours: list[list[RGB]] = [[] for _ in self.handles]
        self.filling = 0
        self.stale = set(range(len(self.handles)))

    def add(self, start: Point, end: Point, colour: RGB) -> None:
        """One more piece."""
        if len(self.pieces[self.filling]) == self.size:
            self.filling = (self.filling + 1) % len(self.handles)
            self.pieces[self.filling] = []
            self.colours[self.filling] = []
        self.pieces[self.filling].append((start, end))
        self.colours[self.filling].append(colour)
        self.stale.add(self.filling)

    def changes(self) -> list[Change]:
        """The chunks that differ from what was sent."""
        changes: list[Change] = []
        for k in sorted(self.stale):
            handle = self.handles[k]
            pieces = self.pieces[k]
            changes.append((handle, "visible", bool(pieces)))
            if pieces:
                colours = np.repeat(np.array(self.colours[k], np.uint8)[:, None], 2, axis=1)
                changes.append((handle, "colors", colours))
                changes.append((handle, "points", np.array(pieces, np.float32)))
        self.stale.clear()
        return changes

    def remove(self) -> None:
        """Take it out of the scene."""
        for handle in self.handles:
            handle.remove()


class Trails:
    """The trails of all feet, each in its leg's colour, and of the body."""

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        self.height = machine.height
        self.feet = Trail(server.scene, "/world/trails/feet", 72, 8, 0.012)
        self.body = Trail(server.scene, "/world/trails/body", 48, 8, 0.016)
        self._colours = [for_scene(colour) for colour in LEGS]
        self.forget()

    def forget(self) -> None:
        """Another run begins: the old trails mean nothing."""
        self.feet.clear()
        self.body.clear()
        self._last_feet: list[Point] = []
        self._last_body: Point | None = None
        self._sent = -math.inf

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """What grew since it was sent last, a few times a second."""
        self._follow_feet(snapshot)
        self._follow_body(snapshot, terrain)
        if snapshot.time - self._sent < snapshot.rate / TRAIL_HZ:
            return []
        self._sent = snapshot.time
        return [*self.feet.changes(), *self.body.changes()]

    def _follow_feet(self, snapshot: Snapshot) -> None:
        self._last_feet = self._last_feet or list(snapshot.feet)
        for leg, (old, new) in enumerate(zip(self._last_feet, snapshot.feet, strict=True)):
            if math.dist(old, new) > FOOT_STEP:
                self.feet.add(_lifted(old), _lifted(new), self._colours[leg])
                self._last_feet[leg] = new

    def _follow_body(self, snapshot: Snapshot, terrain: TerrainTiles) -> None:
        x, y, z = snapshot.body[:3]
        here = (x, y, terrain.height(x, y, z - self.height) + BODY_LIFT)
        last = self._last_body
        if last is not None and math.dist(last[:2], here[:2]) <= BODY_STEP:
            return
        if last is not None:
            self.body.add(last, here, BODY_COLOUR)
        self._last_body = here

    def remove(self) -> None:
        """Take them out of the scene."""
        self.feet.remove()
        self.body.remove()


def _lifted(foot: Point) -> Point:
    return foot[0], foot[1], foot[2] + FOOT_LIFT
