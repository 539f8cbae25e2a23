"""The drawn robot: one node a part, moved to where the snapshot says."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from walking_console.planner.geometry.transforms import rotation
from walking_console.sim.snapshot import Snapshot

from .palette import BAD, RGB, WARN, for_scene
from .robot_shapes import RobotShapes, quaternions
from .types import Change, Floats

FOOT_CARRIES = (222, 226, 230)


class RobotNode:
    """Torso, thighs, shins and feet, a node each.

    The page applies poses at once and all together, instances of a batch a frame later, and a leg a
    frame behind its torso is seen to come off, at ×8 above all.
    """

    def __init__(self, server: viser.ViserServer, shapes: RobotShapes) -> None:
        self.shapes = shapes
        scene = server.scene
        names = range(1, shapes.count + 1)
        thigh = shapes.thigh_shape()
        shin = shapes.shin_shape()
        foot = shapes.foot_shape()
        plain: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
        self.torso = scene.add_glb("/world/torso", shapes.torso(), **plain)
        self.thighs = [scene.add_glb(f"/world/thigh_{leg}", thigh, **plain) for leg in names]
        self.shins = [scene.add_glb(f"/world/shin_{leg}", shin, **plain) for leg in names]
        self.feet = [scene.add_mesh_simple(f"/world/foot_{leg}", *foot, **plain) for leg in names]
        self._colours: list[RGB | None] = [None] * shapes.count

    def changes(self, snapshot: Snapshot) -> list[Change]:
        """Poses of every part, and the colour of a foot that lifts, lands or slips."""
        x, y, z, *angles = snapshot.body
        turn = np.array(rotation(*angles))
        origin = np.array((x, y, z))
        feet = np.array(snapshot.feet)
        legs = self.shapes.legs(origin, turn, feet)
        changes = _posed([self.torso], origin[None], quaternions(turn[None]))
        changes += _posed(self.thighs, legs.hips, legs.thighs)
        changes += _posed(self.shins, legs.knees, legs.shins)
        changes += [(foot, "position", at) for foot, at in zip(self.feet, feet, strict=True)]
        return changes + self._recoloured(snapshot)

    def _recoloured(self, snapshot: Snapshot) -> list[Change]:
        changes: list[Change] = []
        for leg, foot in enumerate(self.feet):
            colour = foot_colour(snapshot.contact[leg], snapshot.support[leg])
            if colour != self._colours[leg]:
                self._colours[leg] = colour
                changes.append((foot, "color", colour))
        return changes

    def remove(self) -> None:
        """Take the robot out of the scene."""
        for handle in (self.torso, *self.thighs, *self.shins, *self.feet):
            handle.remove()


def _posed(handles: list[viser.GlbHandle], places: Floats, turns: Floats) -> list[Change]:
    changes: list[Change] = []
    for handle, place, turn in zip(handles, places, turns, strict=True):
        changes += [(handle, "position", place), (handle, "wxyz", turn)]
    return changes


def foot_colour(on_ground: bool, carries: bool) -> RGB:
    """Light: carries. Amber: swings. Red: should carry and does not touch."""
    if not carries:
        return for_scene(WARN)
    return FOOT_CARRIES if on_ground else for_scene(BAD)
