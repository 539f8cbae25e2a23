"""A soft shadow under the torso and every foot: cheap, and it shows how high things are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import viser

from walking_console.planner.robot.model import Machine
from walking_console.sim.snapshot import Snapshot

from .overlays import FLAT, Overlay, rotated
from .solids import circle
from .terrain_tiles import TerrainTiles
from .types import Change, Floats, Indices

SHADOW = (4, 6, 10)
CORNERS = 24
LIFT = 0.02  # m above the highest ground near by; less: relief flickers through
NEAR = 0.02  # m round a point in which ground counts as under it; less: slopes cut through
SUN = np.array((0.12, -0.12))  # m the torso's shadow lies off, away from the sun


class Band(NamedTuple):
    """A part of the torso's shadow, between shares of the torso's size."""

    shares: tuple[float, ...]  # of its rings, inner to outer
    opacity: float


# Beside each other, never on top: stacked ones flicker through each other.
BANDS = (
    Band((0.0, 0.2, 0.4, 0.63), 0.46),
    Band((0.63, 0.78, 0.92), 0.30),
    Band((0.92, 1.05, 1.19), 0.15),
)


class ShadowOverlay(Overlay):
    """Bands that fade outwards, laid over the ground; the feet's spots belong to the first."""

    def __init__(self, server: viser.ViserServer, machine: Machine) -> None:
        super().__init__()
        self.height = machine.height
        length, width, _ = machine.torso
        round_corners = circle(1.0, CORNERS)
        square = np.sign(round_corners) * np.sqrt(np.abs(round_corners))
        self.rim_b = square * (length / 2, width / 2)
        self.spot = circle(2.6 * machine.foot_radius, CORNERS)
        feet = len(machine.legs)
        spots = [feet, *[0] * (len(BANDS) - 1)]
        self.handles = [
            server.scene.add_mesh_simple(
                f"/world/shadow/{number}",
                np.zeros(((len(band.shares) + count) * CORNERS, 3)),
                band_faces(len(band.shares), count),
                color=SHADOW,
                opacity=band.opacity,
                **FLAT,
            )
            for number, (band, count) in enumerate(zip(BANDS, spots, strict=True))
        ]

    def changes(self, snapshot: Snapshot, terrain: TerrainTiles) -> list[Change]:
        """Everything that differs from the frame before."""
        x, y, z, _, _, yaw = snapshot.body
        feet = [(foot[0], foot[1]) for foot in snapshot.feet]
        place = (round(x, 2), round(y, 2), round(yaw, 2))
        if not self._is_new("shadow", (place, [(round(a, 2), round(b, 2)) for a, b in feet])):
            return []
        rim = rotated(self.rim_b, yaw)
        middle = np.array((x, y)) + SUN
        changes: list[Change] = []
        for handle, band in zip(self.handles, BANDS, strict=True):
            rings = [middle + share * rim for share in band.shares]
            if not changes:
                rings += [self.spot + foot for foot in feet]
            flat = np.concatenate(rings)
            heights = highest_near(terrain, flat, z - self.height) + LIFT
            vertices = np.column_stack([flat, heights]).astype(np.float32)
            changes.append((handle, "vertices", vertices))
        return changes


def highest_near(terrain: TerrainTiles, points: Floats, otherwise: float) -> Floats:
    """The highest ground close to every point (n, 2), m."""
    corners = NEAR * np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    around = np.concatenate([points + corner for corner in corners])
    heights = terrain.heights(around, otherwise).reshape(len(corners), -1)
    return np.asarray(heights.max(axis=0), dtype=np.float64)


def band_faces(rings: int, spots: int) -> Indices:
    """Strips between neighbouring rings of corners, then a fan over each of so many spots."""
    corner = np.arange(CORNERS)
    following = (corner + 1) % CORNERS
    a, b = corner, following
    c, d = a + CORNERS, b + CORNERS
    strip = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    fan = np.array([[0, i, i + 1] for i in range(1, CORNERS - 1)])
    strips = [strip + ring * CORNERS for ring in range(rings - 1)]
    fans = [fan + (rings + spot) * CORNERS for spot in range(spots)]
    return np.concatenate([*strips, *fans])
