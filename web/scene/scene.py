"""The viser scene: handles made once under fixed names, ``draw(snapshot)`` assigns what changed.
Shows, never decides.

Everything lies under one frame, ``/world``. A client that follows the machine has a frame of its
own under that name, moved to minus the machine's place: the camera stays the user's, the ground
slides by.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import viser

from walking_console.planner.geometry.transforms import XY
from walking_console.planner.robot.model import Machine
from walking_console.sim.snapshot import Snapshot

from .overlays import (
    NamesOverlay,
    Overlay,
    OverlayMaker,
    PathOverlay,
    ReachOverlay,
    StabilityOverlay,
)
from .plan_overlays import PreviewOverlay, StepOverlay
from .robot import RobotNode
from .robot_shapes import RobotShapes
from .shadow import ShadowOverlay
from .sky import DUSK, hang
from .terrain_tiles import TerrainTiles
from .trails import Trails
from .types import Change, Floats
from .viewer import CAMERA, LAYERS, LOOK_AT, POINT, UP, Viewer

OVERLAYS: tuple[OverlayMaker, ...] = (
    StabilityOverlay,
    PathOverlay,
    StepOverlay,
    PreviewOverlay,
    ShadowOverlay,
    ReachOverlay,
    NamesOverlay,
)
JUMP = 5.0  # s between two snapshots from which on they are of different runs
VIEW_ANGLE = math.radians(50.0)

Paint = Callable[[str, float, float, float], None]  # brush, x m, y m, radius m


class Scene:
    """One viser server's scene.

    ``follows`` moves the world past every camera, as for a recording that nobody can steer. Drawn
    from one thread; viser's callbacks, from threads of viser's own, only note who is looking
    and pass clicks with a brush on to ``on_paint``.
    """

    def __init__(self, server: viser.ViserServer, follows: bool = False) -> None:
        self.server = server
        self._follows = follows
        self.terrain = TerrainTiles(server)
        self.robot: RobotNode | None = None
        self.trails: Trails | None = None
        self.overlays: list[Overlay] = []
        self.on_paint: Paint = lambda brush, x, y, radius: None
        self._viewers: dict[int, Viewer] = {}
        self._machine: Machine | None = None
        self._time = 0.0
        self._stage = _set_stage(server)
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._farewell)

    def draw(self, snapshot: Snapshot) -> None:
        """Show this instant: one atomic update, one flush."""
        if snapshot.machine is not self._machine and snapshot.machine != self._machine:
            self._rebuild(snapshot.machine)
        self.terrain.draw(snapshot.terrain)
        changes = self._changes(snapshot)
        following = [viewer for viewer in list(self._viewers.values()) if viewer.follows]
        with self.server.atomic():
            for handle, name, value in changes:
                setattr(handle, name, value)
        x, y, z, _, _, yaw = snapshot.body
        if self._follows:
            self._stage.position = (-x, -y, -z)
        for viewer in following:
            viewer.follow(x, y, z, yaw)
        self.server.flush()

    def _changes(self, snapshot: Snapshot) -> list[Change]:
        """Everything that differs from the frame before."""
        assert self.robot is not None and self.trails is not None
        if not self._time <= snapshot.time <= self._time + JUMP:
            self.trails.forget()
        self._time = snapshot.time
        changes = self.robot.changes(snapshot)
        for overlay in self.overlays:
            changes += overlay.changes(snapshot, self.terrain)
        return changes + self.trails.changes(snapshot, self.terrain)

    def _rebuild(self, machine: Machine) -> None:
        """Another machine: everything that depends on it is made anew."""
        with self.server.atomic():
            for old in (self.robot, self.trails, *self.overlays):
                if old is not None:
                    old.remove()
            self._machine = machine
            self.robot = RobotNode(self.server, RobotShapes(machine))
            self.trails = Trails(self.server, machine)
            self.overlays = [make(self.server, machine) for make in OVERLAYS]
        for viewer in list(self._viewers.values()):
            viewer.look_at_machine(_size(machine))

    def _welcome(self, client: viser.ClientHandle) -> None:
        viewer = self._viewers[client.client_id] = Viewer(
            client, self._touch, self.terrain.floor_at
        )
        if self._machine is not None:
            viewer.look_at_machine(_size(self._machine))

    def _farewell(self, client: viser.ClientHandle) -> None:
        self._viewers.pop(client.client_id, None)

    def _touch(self, brush: str, origin: Floats, direction: Floats, radius: float) -> XY | None:
        """A click, as a ray in the world: where it meets the ground; with a brush on to whoever
        changes the ground.
        """
        place = self.terrain.hit(origin, direction)
        if place is not None and brush != POINT:
            self.on_paint(brush, *place, radius)
        return place


def _size(machine: Machine) -> float:
    """How far its feet stand from its middle, m."""
    return max(math.hypot(leg.centre[0], leg.centre[1]) for leg in machine.legs)


def _set_stage(server: viser.ViserServer) -> viser.FrameHandle:
    """Folders, lights, fog, sky and the first camera; the frame everything lies under."""
    scene = server.scene
    scene.set_up_direction("+z")
    scene.world_axes.visible = False
    world = scene.add_frame("/world", show_axes=False)
    for folder in LAYERS.values():
        scene.add_frame(f"/world/{folder}", show_axes=False)
    _light(scene)
    hang(scene, DUSK)
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
    camera = server.initial_camera
    camera.position = tuple(CAMERA)
    camera.look_at = tuple(LOOK_AT)
    camera.up = UP
    camera.fov = VIEW_ANGLE
    return world


def _light(scene: viser.SceneApi) -> None:
    """A sun from the left, a weak light from the right, and the sky."""
    scene.configure_default_lights(enabled=False, cast_shadow=False)
    # reflections cost a quarter of the frame where there is no GPU
    scene.configure_environment_map(None)
    sun = (255, 244, 228)
    scene.add_light_directional("/sun", color=sun, intensity=2.6, position=(-3.0, 3.0, 5.0))
    fill = (205, 218, 240)
    scene.add_light_directional("/fill", color=fill, intensity=1.0, position=(1.0, -4.0, 1.6))
    above = (200, 215, 235)
    below = (96, 90, 82)
    scene.add_light_hemisphere("/sky", sky_color=above, ground_color=below, intensity=2.0)
