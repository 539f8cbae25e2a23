"""The machine as shapes: torso, thighs, shins, joints and feet for any walker of four to eight
legs.

The papers print no drawing we could copy, so the figure is ours: a torso of the machine's own size,
and two-segment legs just long enough for its mechanical reach, knees outward. Drawing only: the
planners know foot tips and reach boxes, no knees.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from walking_console.planner.robot.model import Machine

from .gltf import Part, glb

Floats = NDArray[np.float64]

THIGH = 0.40  # share of a leg's length above the knee
SLACK = 1.04  # leg length over the longest reach: straight legs look broken
FOOT = 2.1  # foot pad radius over the machine's foot radius

SHELL = (0.86, 0.87, 0.86)
AMBER = (0.98, 0.60, 0.13)
GRAPHITE = (0.33, 0.355, 0.395)
STEEL = (0.58, 0.62, 0.67)
EYE = (0.30, 0.90, 1.0)


def loft(stations: Sequence[tuple[float, Floats]], axis: int = 0) -> tuple[Floats, NDArray[Any]]:
    """A closed skin over outlines (n, 2) placed along an axis (0: outlines are y, z; 2: x, y),
    capped at both ends.
    """
    rings = []
    for at, outline in stations:
        across = np.full((len(outline), 1), at)
        rings.append(np.hstack([across, outline] if axis == 0 else [outline, across]))
    count = len(stations[0][1])
    points = np.concatenate([*rings, rings[0].mean(axis=0)[None], rings[-1].mean(axis=0)[None]])
    i, j = np.arange(count), (np.arange(count) + 1) % count
    faces = []
    for ring in range(len(rings) - 1):
        a, b = ring * count, (ring + 1) * count
        faces += [np.stack([a + i, a + j, b + j], 1), np.stack([a + i, b + j, b + i], 1)]
    bottom, top, last = len(points) - 2, len(points) - 1, (len(rings) - 1) * count
    faces += [
        np.stack([np.full(count, bottom), j, i], 1),
        np.stack([np.full(count, top), last + i, last + j], 1),
    ]
    return points, np.concatenate(faces)


def octagon(half_width: float, half_height: float, chamfer: float, lift: float = 0.0) -> Floats:
    """A rectangle with cut corners, counter-clockwise, its middle at height ``lift``."""
    w, h, c = half_width, half_height, min(chamfer, half_width, half_height)
    corners = [
        (w, -h + c),
        (w, h - c),
        (w - c, h),
        (-w + c, h),
        (-w, h - c),
        (-w, -h + c),
        (-w + c, -h),
        (w - c, -h),
    ]
    return np.array(corners) + (0.0, lift)


def circle(radius: float, count: int = 20) -> Floats:
    angle = np.arange(count) * 2 * np.pi / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def turned(
    profile: Sequence[tuple[float, float]], count: int = 20
) -> tuple[Floats, NDArray[Any], Floats]:
    """A body of revolution about z from (z, radius) pairs, with smooth normals across its round
    side.
    """
    table = np.array(profile)
    around = circle(1.0, count)
    points = np.concatenate([np.hstack([around * r, np.full((count, 1), z)]) for z, r in table])
    slope = np.gradient(table[:, 1], table[:, 0])
    normals = np.concatenate([np.hstack([around, np.full((count, 1), -s)]) for s in slope])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    i, j = np.arange(count), (np.arange(count) + 1) % count
    faces = []
    for ring in range(len(table) - 1):
        a, b = ring * count, (ring + 1) * count
        faces += [np.stack([a + i, a + j, b + j], 1), np.stack([a + i, b + j, b + i], 1)]
    return points, np.concatenate(faces), normals


def ball(radius: float, count: int = 18) -> tuple[Floats, NDArray[Any], Floats]:
    """A sphere; its normals are its points."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, count // 2 + 1)
    points = np.concatenate(
        [np.hstack([circle(np.cos(t), count), np.full((count, 1), np.sin(t))]) for t in tilt]
    )
    _, faces, _ = turned([(float(np.sin(t)), 1.0) for t in tilt], count)
    return points * radius, faces, points


def _plain(shape: tuple[Floats, NDArray[Any]], **looks: Any) -> Part:
    return Part(shape[0], shape[1], **looks)


def _round(shape: tuple[Floats, NDArray[Any], Floats], **looks: Any) -> Part:
    return Part(shape[0], shape[1], normals=shape[2], **looks)


def _moved(
    shape: tuple[Floats, NDArray[Any]], offset: Sequence[float]
) -> tuple[Floats, NDArray[Any]]:
    return shape[0] + np.asarray(offset), shape[1]


class Figure:
    """Where a machine's hips, knees and feet are, and what each part looks like."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        length, width, height = machine.torso
        self.count = len(machine.legs)
        self.centres = np.array([leg.centre for leg in machine.legs])
        side = np.sign(self.centres[:, 1])
        inner = np.array([min(abs(leg.y[0]), abs(leg.y[1])) for leg in machine.legs])
        along_x = np.clip(self.centres[:, 0], -0.42 * length, 0.42 * length)
        self.hips_b = np.stack(
            [
                along_x,
                side * np.minimum(width / 2 + 0.02, np.maximum(inner, 0.05)),
                np.zeros(self.count),
            ],
            axis=1,
        )
        self.length = SLACK * max(self._farthest(i) for i in range(self.count))
        self.thigh, self.shin = THIGH * self.length, (1.0 - THIGH) * self.length
        self.girth = 0.045 * self.length  # half a thigh's width
        outward = np.stack(
            [0.30 * np.sign(np.round(self.centres[:, 0], 6)), side, np.full(self.count, 0.35)],
            axis=1,
        )
        self.poles_b = outward / np.linalg.norm(outward, axis=1, keepdims=True)
        self.foot = FOOT * machine.foot_radius
        self.deck = height / 2

    def _farthest(self, index: int) -> float:
        leg, hip, extra = self.machine.legs[index], self.hips_b[index], self.machine.overreach
        far = [max(abs(span[0] - more - h), abs(span[1] + more - h))
               for span, h, more in zip((leg.x, leg.y, leg.z), hip, extra, strict=True)]  # fmt: skip
        return float(np.linalg.norm(far))

    def legs(
        self, origin: Floats, turn: Floats, feet: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Hips, knees (n, 3), and the directions of thighs and shins as quaternions (n, 4), all
        absolute.
        """
        hips = origin + self.hips_b @ turn.T
        poles = self.poles_b @ turn.T
        ankles = feet + (0.0, 0.0, 0.6 * self.foot)
        knees = bend(hips, ankles, poles, self.thigh, self.shin)
        return hips, knees, along(hips, knees, poles), along(knees, ankles, poles)

    # looks

    def torso(self) -> bytes:
        """Torso, deck, eye and hip shafts in body axes."""
        length, width, height = self.machine.torso
        a, w, h = length / 2, width / 2 * 0.86, height / 2
        cut = 0.35 * h
        hull = loft([(-a, octagon(w * 0.72, h * 0.62, cut)), (-a * 0.86, octagon(w, h * 0.92, cut)),
                     (a * 0.80, octagon(w, h * 0.92, cut)), (a, octagon(w * 0.62, h * 0.55, cut))])  # fmt: skip
        roof, band = (
            octagon(w * 0.84, h * 0.30, 0.03, h),
            octagon(w * 0.20, 0.006, 0.002, h * 1.305),
        )
        tail, brow = (
            octagon(w * 0.66, h * 0.10, 0.02, h * 0.90),
            octagon(w * 0.58, h * 0.10, 0.02, h * 0.86),
        )
        deck = loft([(-a * 0.80, tail), (-a * 0.70, roof), (a * 0.45, roof), (a * 0.78, brow)])
        stripe = loft([(-a * 0.69, band), (a * 0.44, band)])
        nose = [(a * 0.44, band), (a * 0.775, octagon(w * 0.10, 0.006, 0.002, h * 0.965))]
        head = loft(
            [
                (a * 0.78, octagon(w * 0.50, h * 0.42, 0.03, h * 0.25)),
                (a * 1.10, octagon(w * 0.40, h * 0.30, 0.03, h * 0.22)),
            ]
        )
        visor = loft(
            [
                (a * 1.08, octagon(w * 0.345, h * 0.11, 0.012, h * 0.27)),
                (a * 1.115, octagon(w * 0.33, h * 0.09, 0.012, h * 0.27)),
            ]
        )
        slit = octagon(w * 1.015, h * 0.30, 0.015)
        vents = [
            loft([(-a * (0.55 - 0.12 * k), slit), (-a * (0.49 - 0.12 * k), slit)]) for k in range(3)
        ]
        parts = [
            _plain(hull, colour=GRAPHITE, roughness=0.6),
            _plain(deck, colour=SHELL, roughness=0.45),
            _plain(stripe, colour=AMBER, roughness=0.5),
            _plain(loft(nose), colour=AMBER, roughness=0.5),
            _plain(head, colour=(0.30, 0.325, 0.36), roughness=0.45),
            _plain(visor, colour=EYE, glow=1.0, roughness=0.3),
            *(_plain(vent, colour=(0.08, 0.09, 0.10), roughness=0.8) for vent in vents),
        ]
        for hip in self.hips_b:
            parts += self._hip(hip, width)
        return glb(parts)

    def _hip(self, hip: Floats, width: float) -> list[Part]:
        """A hip joint and the bracket that holds it."""
        side = 1.0 if hip[1] > 0 else -1.0
        reach = abs(hip[1]) - width / 2 * 0.86 + 0.06
        g = self.girth
        block = loft(
            [
                (-1.5 * g, octagon(reach, 1.1 * g, 0.4 * g)),
                (1.5 * g, octagon(reach, 1.1 * g, 0.4 * g)),
            ]
        )
        bracket = _moved(block, (hip[0], hip[1] - side * 0.4 * reach, hip[2]))
        points, faces, normals = ball(1.08 * g)
        joint = Part(points + hip, faces, colour=GRAPHITE, roughness=0.38, normals=normals)
        return [_plain(bracket, colour=STEEL, roughness=0.45), joint]

    def thigh_shape(self) -> bytes:
        """A boxy beam from the origin up z, for one thigh."""
        g, span = self.girth, self.thigh
        outlines = [
            (0.0, 0.85, 0.95, 0.30),
            (0.12, 1.05, 1.25, 0.35),
            (0.80, 0.80, 0.95, 0.30),
            (1.0, 0.62, 0.70, 0.25),
        ]
        beam = loft(
            [(span * at, octagon(g * wide, g * high, g * cut)) for at, wide, high, cut in outlines],
            axis=2,
        )
        band = loft(
            [
                (span * 0.56, octagon(g * 0.93, g * 1.10, g * 0.32)),
                (span * 0.64, octagon(g * 0.91, g * 1.07, g * 0.32)),
            ],
            axis=2,
        )
        return glb(
            [_plain(beam, colour=SHELL, roughness=0.45), _plain(band, colour=AMBER, roughness=0.5)]
        )

    def shin_shape(self) -> bytes:
        """A knee, and a tapering tube with a collar from it up z, for one shin."""
        g, span = self.girth, self.shin
        tube = turned(
            [
                (0.0, 0.60 * g),
                (0.05 * span, 0.72 * g),
                (0.40 * span, 0.60 * g),
                (0.93 * span, 0.34 * g),
                (span, 0.34 * g),
            ]
        )
        collar = turned(
            [
                (0.16 * span, 0.70 * g),
                (0.165 * span, 0.86 * g),
                (0.30 * span, 0.82 * g),
                (0.305 * span, 0.60 * g),
            ]
        )
        knee = _round(ball(1.08 * self.girth), colour=GRAPHITE, roughness=0.38)
        return glb(
            [
                knee,
                _round(tube, colour=(0.47, 0.50, 0.55), roughness=0.42),
                _round(collar, colour=SHELL, roughness=0.45),
            ]
        )

    def foot_shape(self) -> tuple[Floats, NDArray[Any]]:
        """A pad standing on its tip, coloured by whether it carries."""
        r = self.foot
        profile = [
            (0.0, 0.0),
            (0.001, 0.80 * r),
            (0.16 * r, r),
            (0.42 * r, 0.92 * r),
            (0.75 * r, 0.42 * r),
            (0.9 * r, 0.0),
        ]
        return turned(profile)[:2]


def bend(hips: Floats, feet: Floats, poles: Floats, thigh: float, shin: float) -> Floats:
    """Knees of two-segment legs, bent towards the pole; a foot out of reach gets a straight leg."""
    reach = feet - hips
    distance = np.linalg.norm(reach, axis=1)
    d = np.clip(distance, abs(thigh - shin) + 1e-6, thigh + shin - 1e-6)
    u = reach / np.maximum(distance, 1e-9)[:, None]
    side = poles - np.sum(poles * u, axis=1, keepdims=True) * u
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    forward = (thigh**2 + d**2 - shin**2) / (2 * d)
    off = np.sqrt(np.maximum(thigh**2 - forward**2, 0.0))
    return np.asarray(hips + forward[:, None] * u + off[:, None] * side, dtype=np.float64)


def along(start: Floats, end: Floats, poles: Floats) -> Floats:
    """Quaternions (n, 4) w, x, y, z that carry z onto start → end with x towards the pole."""
    z = end - start
    z /= np.maximum(np.linalg.norm(z, axis=1, keepdims=True), 1e-9)
    x = poles - np.sum(poles * z, axis=1, keepdims=True) * z
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-9)
    return quaternions(np.stack([x, np.cross(z, x), z], axis=-1))


def quaternions(turns: Floats) -> Floats:
    """Rotation matrices (n, 3, 3) to quaternions (n, 4) w, x, y, z: the largest of the four first,
    so never a division by 0.
    """
    m = turns
    diagonal = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]], axis=1)
    trace = diagonal.sum(axis=1)
    # 4 w², 4 x², 4 y², 4 z²
    square = np.stack(
        [1.0 + trace, *(1.0 + 2.0 * diagonal[:, i] - trace for i in range(3))], axis=1
    )
    wx, wy, wz = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    xy, xz, yz = m[:, 1, 0] + m[:, 0, 1], m[:, 0, 2] + m[:, 2, 0], m[:, 2, 1] + m[:, 1, 2]
    rows = np.stack([np.stack([square[:, 0], wx, wy, wz], 1), np.stack([wx, square[:, 1], xy, xz], 1),
                     np.stack([wy, xy, square[:, 2], yz], 1), np.stack([wz, xz, yz, square[:, 3]], 1)], axis=1)  # fmt: skip
    best = rows[np.arange(len(m)), np.argmax(square, axis=1)]
    return np.asarray(best / np.linalg.norm(best, axis=1, keepdims=True), dtype=np.float64)


def attitude(roll: float, pitch: float, yaw: float) -> Floats:
    """Rotation matrix of yaw about z, then pitch about y (nose down positive), then roll about x."""
    (a, b), (c, d), (e, f) = ((np.cos(t), np.sin(t)) for t in (yaw, pitch, roll))
    return np.array(
        [
            [a * c, a * d * f - b * e, a * d * e + b * f],
            [b * c, b * d * f + a * e, b * d * e - a * f],
            [-d, c * f, c * e],
        ]
    )
