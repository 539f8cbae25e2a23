"""The machine as shapes: torso, thighs, shins, joints and feet for any robot of four to eight legs.

The papers print no drawing we could copy, so the looks are ours: a torso of the machine's own size,
and two-segment legs just long enough for its mechanical reach, knees outward. Drawing only: the
planners know foot tips and reach boxes, no knees.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from walking_console.planner.robot.model import Machine

from .gltf import Part, glb
from .solids import Outline, RoundSolid, Solid, ball, loft, octagon, revolution
from .types import Floats

THIGH = 0.40  # share of a leg's length above the knee
STRETCH = 1.04  # leg length over the longest reach; 1.0: straight legs, which look broken
FOOT = 2.1  # foot pad radius over the machine's foot radius
ANKLE = 0.6  # height of the ankle over the foot tip, in foot pad radii
WAIST = 0.86  # hull's width over the torso's

SHELL = (0.86, 0.87, 0.86)
AMBER = (0.98, 0.60, 0.13)
GRAPHITE = (0.33, 0.355, 0.395)
DARK_GRAPHITE = (0.30, 0.325, 0.36)
TUBE = (0.47, 0.50, 0.55)
STEEL = (0.58, 0.62, 0.67)
VISOR = (0.30, 0.90, 1.0)
VENT = (0.08, 0.09, 0.10)


class LegPoses(NamedTuple):
    """Where the parts of all legs are, absolute."""

    hips: Floats  # (n, 3) m
    knees: Floats  # (n, 3) m
    thighs: Floats  # (n, 4) quaternions w, x, y, z that carry z onto hip → knee
    shins: Floats  # (n, 4) the same for knee → ankle


class RobotShapes:
    """Where a machine's hips, knees and feet are, and what each part looks like."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.count = len(machine.legs)
        self.hips_b = hips_of(machine)
        self.poles_b = poles_of(machine)
        self.length = STRETCH * max(self._farthest(i) for i in range(self.count))
        self.thigh = THIGH * self.length
        self.shin = self.length - self.thigh
        self.girth = 0.045 * self.length  # half a thigh's width
        self.foot = FOOT * machine.foot_radius

    def _farthest(self, index: int) -> float:
        """The longest way from hip to foot within the mechanical reach, m."""
        leg = self.machine.legs[index]
        spans = zip((leg.x, leg.y, leg.z), self.hips_b[index], self.machine.overreach, strict=True)
        far = [max(abs(span[0] - more - h), abs(span[1] + more - h)) for span, h, more in spans]
        return float(np.linalg.norm(far))

    def legs(self, origin: Floats, turn: Floats, feet: Floats) -> LegPoses:
        """Where every part is: body origin (3,), its rotation matrix (3, 3), foot tips (n, 3)."""
        hips = origin + self.hips_b @ turn.T
        poles = self.poles_b @ turn.T
        ankles = feet + (0.0, 0.0, ANKLE * self.foot)
        knees = bend(hips, ankles, poles, self.thigh, self.shin)
        return LegPoses(hips, knees, along(hips, knees, poles), along(knees, ankles, poles))

    # looks

    def torso(self) -> bytes:
        """Torso, deck, visor and hip shafts in body axes, as binary glTF."""
        parts = [*self._hull(), *self._deck(), *self._head()]
        for hip in self.hips_b:
            parts += self._hip(hip)
        return glb(parts)

    def _half(self) -> tuple[float, float, float]:
        length, width, height = self.machine.torso
        return length / 2, width / 2 * WAIST, height / 2

    def _hull(self) -> list[Part]:
        """The lower body, with three vents on either side."""
        a, w, h = self._half()
        cut = 0.35 * h
        side = octagon(w, h * 0.92, cut)
        tail = octagon(w * 0.72, h * 0.62, cut)
        front = octagon(w * 0.62, h * 0.55, cut)
        hull = loft([(-a, tail), (-a * 0.86, side), (a * 0.80, side), (a, front)])
        slit = octagon(w * 1.015, h * 0.30, 0.015)
        vents = [
            loft([(-a * (0.55 - 0.12 * k), slit), (-a * (0.49 - 0.12 * k), slit)]) for k in range(3)
        ]
        return [
            _plain(hull, colour=GRAPHITE, roughness=0.6),
            *(_plain(vent, colour=VENT, roughness=0.8) for vent in vents),
        ]

    def _deck(self) -> list[Part]:
        """The roof, with a stripe that shows from above which end is the front."""
        a, w, h = self._half()
        roof = octagon(w * 0.84, h * 0.30, 0.03, h)
        tail = octagon(w * 0.66, h * 0.10, 0.02, h * 0.90)
        brow = octagon(w * 0.58, h * 0.10, 0.02, h * 0.86)
        deck = loft([(-a * 0.80, tail), (-a * 0.70, roof), (a * 0.45, roof), (a * 0.78, brow)])
        band = octagon(w * 0.20, 0.006, 0.002, h * 1.305)
        tip = octagon(w * 0.10, 0.006, 0.002, h * 0.965)
        stripe = loft([(-a * 0.69, band), (a * 0.44, band)])
        nose = loft([(a * 0.44, band), (a * 0.775, tip)])
        return [
            _plain(deck, colour=SHELL, roughness=0.45),
            _plain(stripe, colour=AMBER, roughness=0.5),
            _plain(nose, colour=AMBER, roughness=0.5),
        ]

    def _head(self) -> list[Part]:
        """The front end, with a glowing visor."""
        a, w, h = self._half()
        neck = octagon(w * 0.50, h * 0.42, 0.03, h * 0.25)
        face = octagon(w * 0.40, h * 0.30, 0.03, h * 0.22)
        inner = octagon(w * 0.345, h * 0.11, 0.012, h * 0.27)
        outer = octagon(w * 0.33, h * 0.09, 0.012, h * 0.27)
        head = loft([(a * 0.78, neck), (a * 1.10, face)])
        visor = loft([(a * 1.08, inner), (a * 1.115, outer)])
        return [
            _plain(head, colour=DARK_GRAPHITE, roughness=0.45),
            _plain(visor, colour=VISOR, glow=1.0, roughness=0.3),
        ]

    def _hip(self, hip: Floats) -> list[Part]:
        """A hip joint and the bracket that holds it."""
        side = 1.0 if hip[1] > 0 else -1.0
        reach = abs(hip[1]) - self._half()[1] + 0.06
        g = self.girth
        cheek = octagon(reach, 1.1 * g, 0.4 * g)
        vertices, faces = loft([(-1.5 * g, cheek), (1.5 * g, cheek)])
        bracket = (vertices + (hip[0], hip[1] - side * 0.4 * reach, hip[2]), faces)
        points, triangles, normals = ball(1.08 * g)
        joint = (points + hip, triangles, normals)
        return [
            _plain(bracket, colour=STEEL, roughness=0.45),
            _round(joint, colour=GRAPHITE, roughness=0.38),
        ]

    def thigh_shape(self) -> bytes:
        """A boxy beam from the origin up z, for one thigh, as binary glTF."""
        beam = [
            (0.0, self._girder(0.85, 0.95, 0.30)),
            (0.12, self._girder(1.05, 1.25, 0.35)),
            (0.80, self._girder(0.80, 0.95, 0.30)),
            (1.0, self._girder(0.62, 0.70, 0.25)),
        ]
        band = [(0.56, self._girder(0.93, 1.10, 0.32)), (0.64, self._girder(0.91, 1.07, 0.32))]
        return glb(
            [
                _plain(self._upright(beam), colour=SHELL, roughness=0.45),
                _plain(self._upright(band), colour=AMBER, roughness=0.5),
            ]
        )

    def _girder(self, wide: float, high: float, cut: float) -> Outline:
        """A cross-section of a thigh, in its girths."""
        return octagon(self.girth * wide, self.girth * high, self.girth * cut)

    def _upright(self, stations: Sequence[tuple[float, Outline]]) -> Solid:
        """A skin over cross-sections at shares of the thigh's length."""
        return loft([(self.thigh * share, outline) for share, outline in stations], axis=2)

    def shin_shape(self) -> bytes:
        """A knee, and a tapering tube with a collar from it up z, for one shin, as binary glTF."""
        tube = [(0.0, 0.60), (0.05, 0.72), (0.40, 0.60), (0.93, 0.34), (1.0, 0.34)]
        collar = [(0.16, 0.70), (0.165, 0.86), (0.30, 0.82), (0.305, 0.60)]
        return glb(
            [
                _round(ball(1.08 * self.girth), colour=GRAPHITE, roughness=0.38),
                _round(self._tube(tube), colour=TUBE, roughness=0.42),
                _round(self._tube(collar), colour=SHELL, roughness=0.45),
            ]
        )

    def _tube(self, profile: Sequence[tuple[float, float]]) -> RoundSolid:
        """A tube from (share of the shin's length, radius in girths) pairs."""
        return revolution([(share * self.shin, r * self.girth) for share, r in profile])

    def foot_shape(self) -> Solid:
        """A pad standing on its tip, to be coloured by whether it carries."""
        r = self.foot
        cap = [(0.0, 0.0), (0.001, 0.80 * r), (0.16 * r, r)]
        neck = [(0.42 * r, 0.92 * r), (0.75 * r, 0.42 * r), (0.9 * r, 0.0)]
        return revolution([*cap, *neck])[:2]


def _plain(solid: Solid, **looks: Any) -> Part:
    return Part(solid[0], solid[1], **looks)


def _round(solid: RoundSolid, **looks: Any) -> Part:
    return Part(solid[0], solid[1], normals=solid[2], **looks)


def hips_of(machine: Machine) -> Floats:
    """Where the hips sit in body axes, (n, 3): beside the torso, near the reach."""
    length, width, _ = machine.torso
    centres = np.array([leg.centre for leg in machine.legs])
    inner = np.array([min(abs(leg.y[0]), abs(leg.y[1])) for leg in machine.legs])
    x = np.clip(centres[:, 0], -0.42 * length, 0.42 * length)
    y = np.sign(centres[:, 1]) * np.minimum(width / 2 + 0.02, np.maximum(inner, 0.05))
    return np.stack([x, y, np.zeros(len(x))], axis=1)


def poles_of(machine: Machine) -> Floats:
    """Directions the knees point in, in body axes (n, 3): outwards and up."""
    centres = np.array([leg.centre for leg in machine.legs])
    ahead = 0.30 * np.sign(np.round(centres[:, 0], 6))
    outward = np.stack([ahead, np.sign(centres[:, 1]), np.full(len(centres), 0.35)], axis=1)
    return np.asarray(outward / np.linalg.norm(outward, axis=1, keepdims=True), dtype=np.float64)


def bend(hips: Floats, feet: Floats, poles: Floats, thigh: float, shin: float) -> Floats:
    """Knees of two-segment legs, bent towards the pole; a foot out of reach gets a straight leg."""
    reach = feet - hips
    distance = np.linalg.norm(reach, axis=1)
    d = np.clip(distance, abs(thigh - shin) + 1e-6, thigh + shin - 1e-6)
    u = reach / np.maximum(distance, 1e-9)[:, None]
    side = _square_to(u, poles)
    forward = (thigh**2 + d**2 - shin**2) / (2 * d)
    off = np.sqrt(np.maximum(thigh**2 - forward**2, 0.0))
    return np.asarray(hips + forward[:, None] * u + off[:, None] * side, dtype=np.float64)


def along(start: Floats, end: Floats, poles: Floats) -> Floats:
    """Quaternions (n, 4) w, x, y, z that carry z onto start → end with x towards the pole."""
    z = end - start
    z /= np.maximum(np.linalg.norm(z, axis=1, keepdims=True), 1e-9)
    x = _square_to(z, poles)
    return quaternions(np.stack([x, np.cross(z, x), z], axis=-1))


def _square_to(axis: Floats, poles: Floats) -> Floats:
    """The poles' parts at right angles to unit axes, as unit vectors (n, 3)."""
    part = poles - np.sum(poles * axis, axis=1, keepdims=True) * axis
    length = np.maximum(np.linalg.norm(part, axis=1, keepdims=True), 1e-9)
    return np.asarray(part / length, dtype=np.float64)


def quaternions(turns: Floats) -> Floats:
    """Rotation matrices (n, 3, 3) to quaternions (n, 4) w, x, y, z.

    Of the four ways the one with the largest divisor is taken, so there is never a division by 0.
    """
    m = turns
    x, y, z = m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]
    wx, wy, wz = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    xy, xz, yz = m[:, 1, 0] + m[:, 0, 1], m[:, 0, 2] + m[:, 2, 0], m[:, 2, 1] + m[:, 1, 2]
    ways = np.array(
        [  # 4 w q, 4 x q, 4 y q, 4 z q
            [1.0 + x + y + z, wx, wy, wz],
            [wx, 1.0 + x - y - z, xy, xz],
            [wy, xy, 1.0 - x + y - z, yz],
            [wz, xz, yz, 1.0 - x - y + z],
        ]
    )
    divisors = ways[range(4), range(4)]
    best = ways[np.argmax(divisors, axis=0), :, np.arange(len(m))]
    return np.asarray(best / np.linalg.norm(best, axis=1, keepdims=True), dtype=np.float64)
