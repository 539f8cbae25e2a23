"""What is behind everything: a gradient and its fog. Dusk, or day for projectors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import viser
from numpy.typing import NDArray

RGBShare = tuple[float, float, float]  # sRGB, 0-1

HORIZON = 0.42  # share of the picture above the horizon
FOG_FROM = 7.0  # m
FOG_TO = 26.0  # m


class Sky(NamedTuple):
    """Colours at the top, at the horizon and below, and of the fog (0-255)."""

    top: RGBShare
    horizon: RGBShare
    below: RGBShare
    fog: tuple[int, int, int]


DUSK = Sky((0.050, 0.066, 0.098), (0.290, 0.335, 0.385), (0.150, 0.175, 0.210), (46, 55, 66))
DAY = Sky((0.610, 0.700, 0.780), (0.905, 0.930, 0.950), (0.740, 0.780, 0.815), (214, 222, 229))


def hang(scene: viser.SceneApi, sky: Sky) -> None:
    """Put it behind a scene: everybody's, or that of one client."""
    scene.configure_fog(FOG_FROM, FOG_TO, color=sky.fog)
    scene.set_background_image(gradient(sky), format="png")


def gradient(sky: Sky) -> NDArray[np.uint8]:
    """Lightest at the horizon: (256, 4, 3)."""
    down = np.linspace(0.0, 1.0, 256)
    stops = (0.0, HORIZON, 1.0)
    channels = [np.interp(down, stops, channel) for channel in zip(*sky[:3], strict=True)]
    colour = np.stack(channels, axis=1)
    return np.asarray(np.rint(np.repeat(colour[:, None], 4, axis=1) * 255), dtype=np.uint8)
