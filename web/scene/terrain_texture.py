"""The picture on the ground: height colours, hill shading, contours, forbidden cells; as PNG.

The texture has the full resolution of the map, so forbidden cells and small holes stay crisp where
the triangles under it are thinned out.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

from .types import Bools, Floats

# m, relief that gets the whole colour ramp at least; less: small bumps look like mountains
SPAN_MIN = 0.4
CONTOUR = 0.05  # m between contour lines
LEVEL_SHARE = 0.22  # where in the colour ramp ground without any relief lies

# Height colours as OKLCh: lightness rises evenly, hue runs from slate blue over sage to sand
RAMP = (
    (0.48, 0.042, 262.0),
    (0.56, 0.045, 225.0),
    (0.65, 0.055, 165.0),
    (0.75, 0.075, 118.0),
    (0.84, 0.078, 85.0),
    (0.94, 0.035, 75.0),
)
FORBIDDEN = np.array([0.80, 0.22, 0.14])  # sRGB 0-1, as all colours below
FORBIDDEN_EDGE = np.array([0.36, 0.07, 0.07])
# where most ground is forbidden, the allowed cells are what should be seen
FORBIDDEN_FIELD = np.array([0.34, 0.17, 0.16])
ABYSS = np.array([0.018, 0.022, 0.032])

# OKLab to LMS and LMS to linear sRGB (B. Ottosson 2020)
LAB_TO_LMS = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
LMS_TO_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def oklch(lightness: Floats, chroma: Floats, hue: Floats) -> Floats:
    """OKLCh (hue in degrees) to sRGB 0-1 (..., 3): equal steps of it look equal."""
    ab = chroma * np.exp(1j * np.radians(hue))
    lab = np.stack([lightness, ab.real, ab.imag], axis=-1)
    lms = (lab @ LAB_TO_LMS.T) ** 3
    light = np.clip(lms @ LMS_TO_RGB.T, 0.0, 1.0)
    curved = 1.055 * light ** (1 / 2.4) - 0.055
    return np.asarray(np.where(light <= 0.0031308, 12.92 * light, curved), dtype=np.float64)


def _ramp() -> Floats:
    at = np.linspace(0.0, 1.0, 256)
    knots = np.linspace(0.0, 1.0, len(RAMP))
    columns = [np.interp(at, knots, [key[i] for key in RAMP]) for i in range(3)]
    return oklch(*columns)


COLOURS = _ramp()  # (256, 3) sRGB


def height_colours(heights: Floats, low: float, high: float) -> Floats:
    """sRGB 0-1 (..., 3) of heights on a map that reaches from ``low`` to ``high``, m."""
    if high <= low:
        share = LEVEL_SHARE + (heights - low) / SPAN_MIN
    else:
        span = max(high - low, SPAN_MIN)
        share = 0.5 + (heights - (high + low) / 2) / span
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(COLOURS[(share * 255).astype(np.uint8)], dtype=np.float64)


def hill_shade(heights: Floats, cell: float, stepped: bool) -> Floats:
    """Brightness under a low sun from the north-west and a wide sky; 1 on the level."""
    if min(heights.shape) < 2:
        return np.ones(heights.shape)
    dy, dx = np.gradient(heights, cell)
    if stepped:
        dy, dx = (np.clip(slope, -0.3, 0.3) for slope in (dy, dx))
    normal = 1.0 / np.sqrt(1.0 + dx * dx + dy * dy)
    sun = (0.42 * dx - 0.42 * dy + 0.80) * normal / 0.80
    return np.asarray(
        np.clip(0.30 + 0.70 * sun, 0.25, 1.45) * (0.55 + 0.45 * normal), dtype=np.float64
    )


def contours(heights: Floats, cell: float) -> Floats:
    """Up to 1 where a contour line runs, every fifth one full, the others half; soft, and none
    where the ground is nearly level.
    """
    if min(heights.shape) < 2:
        return np.zeros(heights.shape)
    dy, dx = np.gradient(heights, cell)
    slope = np.hypot(dx, dy)
    width = np.maximum(slope, 1e-6) * cell * 0.8
    shown = np.clip(slope / 0.08 - 0.25, 0.0, 1.0)
    lines = [
        np.clip(1.3 - np.abs(heights - np.rint(heights / gap) * gap) / width, 0.0, 1.0)
        for gap in (CONTOUR, 5 * CONTOUR)
    ]
    return np.asarray(np.maximum(0.5 * lines[0], lines[1]) * shown, dtype=np.float64)


def mark_forbidden(picture: Floats, forbidden: Bools, scale: int) -> None:
    """Tint forbidden cells and draw a thin dark line round each forbidden region."""
    if not forbidden.any():
        return
    tint = FORBIDDEN if forbidden.mean() < 0.5 else FORBIDDEN_FIELD
    picture[forbidden] = 0.42 * picture[forbidden] + 0.58 * tint * (
        0.55 + 0.9 * picture[forbidden].mean(axis=1, keepdims=True)
    )
    if scale < 2:
        return
    free = np.pad(~forbidden, 1, mode="edge")
    edge = forbidden & (free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:])
    picture[edge] = 0.45 * picture[edge] + 0.55 * FORBIDDEN_EDGE


def png(picture: Floats) -> bytes:
    """An (h, w, 3) or (h, w, 4) picture, 0-1, as PNG; each row is stored as the change from the one
    above, which packs well.
    """
    pixels = np.clip(np.rint(picture * 255), 0, 255).astype(np.uint8)
    rows, columns, channels = pixels.shape
    # filter 2, wraps round as PNG wants
    change = np.diff(pixels, axis=0, prepend=np.zeros((1, columns, channels), np.uint8))
    lines = np.concatenate([np.full((rows, 1), 2, np.uint8), change.reshape(rows, -1)], axis=1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(c)) + k + c + struct.pack(">I", zlib.crc32(k + c)) for k, c in chunks
    )
