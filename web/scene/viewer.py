"""One viewer: how its camera goes with the machine, which layers it sees, the brush in its hand.

The page works these switches from its own menu, by their labels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import viser

from walking_console.planner.geometry.transforms import XY, direction, turned, turned_back

from .palette import WARN, for_scene
from .sky import DAY, DUSK, hang
from .types import Floats

# m, where the camera is and looks at first, from the machine's centre of gravity
CAMERA = np.array((-2.1, -2.5, 1.15))
LOOK_AT = np.array((0.15, 0.0, -0.40))
UP = (0.0, 0.0, 1.0)


class Shot(NamedTuple):
    """How a camera goes with the machine. It stays the viewer's to orbit: the world moves and turns
    under it.
    """

    follows: bool
    turns: bool  # as the machine does
    camera: Floats  # m, where it is at first, from the machine's centre of gravity


SHOTS = {
    "follow": Shot(follows=True, turns=False, camera=CAMERA),
    "chase": Shot(follows=True, turns=True, camera=np.array((-3.0, 0.0, 1.15))),
    "top": Shot(follows=True, turns=False, camera=np.array((0.11, 0.0, 3.3))),
    "side": Shot(follows=True, turns=True, camera=np.array((0.15, -3.1, 0.1))),
    "free": Shot(follows=False, turns=False, camera=CAMERA),
}
FIRST_SHOT = "follow"
LOOKS_EVERY = 10  # steps of the machine between looks whether a hill has come over the camera
SIZE = 0.654  # m, of the machine they are for; others are looked at from as many of their sizes
NARROW = 1.25  # aspect below which the camera steps back, so that the legs stay in the picture
FARTHEST = 2.2  # times the first distance; more: the machine is a speck on a phone

LAYERS = {  # label of the switch: folder under /world
    "Trails": "trails",
    "Plan": "plan",
    "Search": "search",
    "Stability": "stability",
    "Path": "path",
    "Preview": "preview",
    "Reach": "reach",
    "Names": "names",
}
HIDDEN_AT_FIRST = ("Reach",)
BRUSHES = ("dig", "raise", "lower", "forbid", "clear")
POINT = "point"  # in place of a brush: a click chooses a place to go to
PIN = 0.35  # m, how high the pin stands there
PIN_RADIUS = 0.02  # m
BRUSH = 0.12  # m, radius
WIDE_BRUSH = 0.35  # m

CLEARANCE = 0.15  # m the camera stays above the ground; less: its near edge cuts through slopes

GroundAt = Callable[[float, float], float]  # height of the ground under x, y in the world, m
# brush, ray origin, ray direction, radius: where that meets the ground
TouchRay = Callable[[str, Floats, Floats, float], XY | None]


class Viewer:
    """One client of the scene, with switches and nodes of its own."""

    def __init__(self, client: viser.ClientHandle, touch: TouchRay, ground_at: GroundAt) -> None:
        self.client = client
        self.touch = touch
        self.ground_at = ground_at
        self.brush = ""
        self.radius = BRUSH
        self._pin: viser.CylinderHandle | None = None
        self.shot = SHOTS[FIRST_SHOT]
        self.turn = 0.0  # rad, of the world under the camera
        self._moves = 0
        self.scale = 1.0  # of the first look
        self.world = client.scene.add_frame("/world", show_axes=False)
        self.layers: dict[str, viser.FrameHandle] = {}
        if client.camera.aspect < 1.0:
            self.go_home()  # an upright phone sees less to the sides
        self._add_switches()
        client.camera.on_update(lambda _: self.rise_above_ground())

    def _add_switches(self) -> None:
        gui = self.client.gui
        for name in SHOTS:
            chosen = gui.add_checkbox(f"Camera {name}", name == FIRST_SHOT)
            chosen.on_update(self._shot_switch(name))
        for label in LAYERS:
            shown = label not in HIDDEN_AT_FIRST
            gui.add_checkbox(label, shown).on_update(self._layer_switch(label))
            if not shown:
                self._show(label, False)
        for brush in BRUSHES:
            gui.add_checkbox(f"Paint {brush}", False).on_update(self._brush_switch(brush))
        gui.add_checkbox("Point", False).on_update(self._brush_switch(POINT))
        self.pointed = gui.add_text("Pointed", "")  # the page reads it
        gui.add_checkbox("Light", False).on_update(self._change_sky)
        gui.add_checkbox("Wide brush", False).on_update(self._widen)
        gui.add_button("Home").on_click(lambda _: self.go_home())

    @property
    def follows(self) -> bool:
        """Whether the machine stays before the camera."""
        return self.shot.follows

    def _shot_switch(self, name: str) -> Callable[[Any], None]:
        def take(event: Any) -> None:
            if event.target.value:
                self.shot = SHOTS[name]
                if self.follows:
                    self.go_home()

        return take

    def _change_sky(self, event: Any) -> None:
        hang(self.client.scene, DAY if event.target.value else DUSK)

    def _layer_switch(self, label: str) -> Callable[[Any], None]:
        return lambda event: self._show(label, bool(event.target.value))

    def _show(self, label: str, shown: bool) -> None:
        if label not in self.layers:
            self.layers[label] = self.client.scene.add_frame(
                f"/world/{LAYERS[label]}", show_axes=False, visible=shown
            )
        self.layers[label].visible = shown

    def _brush_switch(self, brush: str) -> Callable[[Any], None]:
        """A brush in hand makes clicks paint, or point; with none the scene is not asked for
        clicks.
        """

        def take(event: Any) -> None:
            held = self.brush
            if event.target.value:
                self.brush = brush
            elif held == brush:
                self.brush = ""
            if self.brush and not held:
                self.client.scene.on_click()(self._click)
            elif held and not self.brush:
                self.client.scene.remove_click_callback()
            if self.brush != POINT and self._pin is not None:
                self._pin.remove()
                self._pin = None

        return take

    def _widen(self, event: Any) -> None:
        self.radius = WIDE_BRUSH if event.target.value else BRUSH

    def _click(self, event: viser.SceneClickEvent) -> None:
        if self.brush:
            ray = np.array(event.ray_direction)
            moved = np.array(event.ray_origin) - self.world.position
            place = self.touch(self.brush, self._unturned(moved), self._unturned(ray), self.radius)
            if self.brush == POINT and place is not None:
                self._point_at(*place)

    def _point_at(self, x: float, y: float) -> None:
        """Put the pin there, and leave the place for the page."""
        z = self.ground_at(x, y)
        self._pin = self.client.scene.add_cylinder(
            "/world/pin", PIN_RADIUS, PIN, color=for_scene(WARN), position=(x, y, z + PIN / 2)
        )
        self.pointed.value = f"{x:.3f} {y:.3f}"  # type: ignore[misc]

    def _unturned(self, vector: Floats) -> Floats:
        """A vector before the camera in the world's axes."""
        x, y, z = (float(value) for value in vector)
        return np.array((*turned_back(x, y, self.turn), z))

    def go_home(self) -> None:
        """Bring the camera back to the first look of its kind, farther off in a narrow window."""
        away = min(max(1.0, NARROW / self.client.camera.aspect), FARTHEST)
        with self.client.atomic():
            self.client.camera.position = self.scale * (
                LOOK_AT + away * (self.shot.camera - LOOK_AT)
            )
            self.client.camera.look_at = self.scale * LOOK_AT
            self.client.camera.up_direction = UP

    def look_at_machine(self, size: float) -> None:
        """Scale the first look with the machine, and take it where that changes."""
        scale = size / SIZE
        if abs(scale - self.scale) > 0.01:
            self.scale = scale
            self.go_home()

    def rise_above_ground(self) -> None:
        """Lift a camera that was dragged under the ground; what it looks at stays."""
        camera = self.client.camera
        x, y, z = (float(value) for value in camera.position)
        up = float(self.world.position[2])
        below = self._unturned(np.array(camera.position) - self.world.position)
        lowest = self.ground_at(float(below[0]), float(below[1])) + up + CLEARANCE
        if z < lowest:
            looked_at = camera.look_at
            with self.client.atomic():
                camera.position = (x, y, lowest)
                camera.look_at = looked_at

    def follow(self, x: float, y: float, z: float, yaw: float) -> None:
        """Bring the world under the camera so that a machine at x, y, z (m), heading ``yaw`` (rad),
        stays before it; at once, as the machine's own move goes out.
        """
        self.turn = -yaw if self.shot.turns else 0.0
        c, s = direction(self.turn / 2)
        with self.client.atomic():
            self.world.wxyz = (c, 0.0, 0.0, s)
            self.world.position = (*turned(-x, -y, self.turn), -z)
        self.client.flush()
        self._moves += 1
        if self._moves % LOOKS_EVERY == 0:
            self.rise_above_ground()
