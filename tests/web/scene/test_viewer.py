"""One viewer: its switches change its own view, and a brush in its hand paints where it clicks."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from walking_console.web.scene.sky import DAY, DUSK, Sky
from walking_console.web.scene.viewer import (
    BRUSH,
    BRUSHES,
    CAMERA,
    CLEARANCE,
    FARTHEST,
    HIDDEN_AT_FIRST,
    LAYERS,
    LOOK_AT,
    LOOKS_EVERY,
    PIN,
    SHOTS,
    SIZE,
    WIDE_BRUSH,
    Viewer,
)


class Client:
    """What a viewer uses of a viser client, on the server's own scene and panels."""

    def __init__(self, server: viser.ViserServer, aspect: float) -> None:
        self.scene = server.scene
        self.gui = server.gui
        self.atomic = server.atomic
        self.flush = server.flush
        self.camera = SimpleNamespace(
            aspect=aspect, position=None, look_at=None, up_direction=None, on_update=self._on_update
        )
        self.updates: list[Any] = []
        self.clicks = 0
        self.scene.on_click = self._on_click  # type: ignore[method-assign]
        self.scene.remove_click_callback = self._remove  # type: ignore[method-assign]

    def _on_click(self) -> Any:
        self.clicks += 1
        return lambda callback: callback

    def _on_update(self, callback: Any) -> None:
        self.updates.append(callback)

    def _remove(self) -> None:
        self.clicks -= 1


Touch = tuple[str, np.ndarray, np.ndarray, float]


@pytest.fixture
def touches() -> list[Touch]:
    return []


@pytest.fixture
def viewer(server: viser.ViserServer, touches: list[Touch]) -> Viewer:
    server.gui.reset()
    client: Any = Client(server, 1.6)

    def touch(*words: Any) -> tuple[float, float]:
        touches.append(words)
        return (0.5, 0.25)

    return Viewer(client, touch, lambda x, y: 0.2 * x)


def switch(viewer: Viewer, label: str, on: bool) -> None:
    """Work a switch as the page does: by its label."""
    for handle in viewer.client.gui._gui_input_handle_from_uuid.values():
        if handle.label == label:  # type: ignore[attr-defined]
            event: Any = SimpleNamespace(target=SimpleNamespace(value=on))
            for callback in handle._impl.update_cb:
                callback(event)
            return
    raise AssertionError(f"no switch {label!r}")


def click(viewer: Viewer) -> None:
    event: Any = SimpleNamespace(ray_origin=(1.0, 2.0, 3.0), ray_direction=(0.0, 0.0, -1.0))
    viewer._click(event)


def test_every_layer_is_shown_at_first_but_for_those_that_hide_the_rest(viewer: Viewer) -> None:
    assert {label for label, frame in viewer.layers.items() if not frame.visible} == set(
        HIDDEN_AT_FIRST
    )


@pytest.mark.parametrize("label", LAYERS)
def test_a_layer_is_switched_off_and_on_by_its_label(viewer: Viewer, label: str) -> None:
    switch(viewer, label, False)
    assert viewer.layers[label].name == f"/world/{LAYERS[label]}"
    assert not viewer.layers[label].visible
    switch(viewer, label, True)
    assert viewer.layers[label].visible


def test_a_viewer_follows_until_it_is_free(viewer: Viewer) -> None:
    assert viewer.follows
    viewer.client.camera.position = np.array((5.0, 5.0, 5.0))
    switch(viewer, "Camera free", True)
    assert not viewer.follows
    assert viewer.client.camera.position == pytest.approx((5.0, 5.0, 5.0))  # nobody takes it


@pytest.mark.parametrize("name", [name for name in SHOTS if SHOTS[name].follows])
def test_a_camera_of_another_kind_takes_its_place_in_sizes_of_the_machine(
    viewer: Viewer, name: str
) -> None:
    viewer.look_at_machine(SIZE / 2)
    switch(viewer, f"Camera {name}", True)
    assert viewer.client.camera.position == pytest.approx(SHOTS[name].camera / 2)
    assert viewer.client.camera.look_at == pytest.approx(LOOK_AT / 2)


@pytest.mark.parametrize(("name", "turned"), [("chase", True), ("side", True), ("top", False)])
def test_the_world_turns_under_cameras_that_turn_with_the_machine(
    viewer: Viewer, touches: list[Touch], name: str, turned: bool
) -> None:
    switch(viewer, f"Camera {name}", True)
    viewer.follow(1.0, 0.0, 0.5, math.pi / 2)
    assert viewer.world.position == pytest.approx((0.0, 1.0, -0.5) if turned else (-1, 0, -0.5))
    switch(viewer, "Paint dig", True)
    click(viewer)  # through (1, 2) before the camera
    [(_, origin, _, _)] = touches
    assert origin == pytest.approx((-1.0, 1.0, 3.5) if turned else (2.0, 2.0, 3.5))


def test_a_hill_that_comes_over_a_camera_lifts_it(viewer: Viewer) -> None:
    viewer.client.camera.position = np.array((2.0, 0.0, 0.0))
    viewer.client.camera.look_at = np.array((0.0, 0.0, -0.4))
    for _ in range(LOOKS_EVERY):
        viewer.follow(8.0, 0.0, 1.6, 0.0)  # the ground is 0.2 x high in the world
    assert viewer.client.camera.position == pytest.approx((2.0, 0.0, 2.0 - 1.6 + CLEARANCE))


def test_a_light_page_has_a_sky_of_its_own(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    hung: list[tuple[Any, Sky]] = []
    monkeypatch.setattr(
        "walking_console.web.scene.viewer.hang", lambda scene, sky: hung.append((scene, sky))
    )
    switch(viewer, "Light", True)
    switch(viewer, "Light", False)
    assert hung == [(viewer.client.scene, DAY), (viewer.client.scene, DUSK)]


def test_the_world_moves_under_a_camera_that_follows(viewer: Viewer) -> None:
    viewer.follow(1.0, -0.5, 0.0, 0.3)
    assert tuple(viewer.world.position) == (-1.0, 0.5, 0.0)


@pytest.mark.parametrize(("z", "shown"), [(-1.0, 0.9), (0.89, 0.9), (0.95, 0.95)])
def test_a_camera_dragged_under_the_ground_rises_above_it_and_looks_where_it_did(
    viewer: Viewer, z: float, shown: float
) -> None:
    viewer.follow(1.0, 0.0, -0.15, 0.0)  # the ground is 0.2 x high in the world
    viewer.client.camera.position = np.array((2.0, 0.0, z))
    viewer.client.camera.look_at = np.array((0.0, 0.0, -0.4))
    viewer.client.updates[0](None)  # type: ignore[attr-defined]
    assert viewer.client.camera.position == pytest.approx((2.0, 0.0, shown))
    assert viewer.client.camera.look_at == pytest.approx((0.0, 0.0, -0.4))


@pytest.mark.parametrize("brush", BRUSHES)
def test_a_click_paints_with_the_brush_in_hand_where_the_world_is(
    viewer: Viewer, touches: list[Touch], brush: str
) -> None:
    viewer.follow(-1.0, -1.0, -1.0, 0.0)
    switch(viewer, f"Paint {brush}", True)
    click(viewer)
    [(used, origin, direction, radius)] = touches
    assert (used, radius) == (brush, BRUSH)
    assert origin.tolist() == [0.0, 1.0, 2.0] and direction.tolist() == [0.0, 0.0, -1.0]


def test_a_wide_brush_is_wider(viewer: Viewer, touches: list[Touch]) -> None:
    switch(viewer, "Paint dig", True)
    switch(viewer, "Wide brush", True)
    click(viewer)
    assert touches[0][3] == WIDE_BRUSH


def test_without_a_brush_clicks_are_not_asked_for_and_paint_nothing(
    viewer: Viewer, touches: list[Touch]
) -> None:
    client: Any = viewer.client
    assert client.clicks == 0
    switch(viewer, "Paint dig", True)
    switch(viewer, "Paint raise", True)  # one after the other, as the page does
    switch(viewer, "Paint dig", False)
    assert client.clicks == 1 and viewer.brush == "raise"
    switch(viewer, "Paint raise", False)
    assert client.clicks == 0
    click(viewer)
    assert touches == []


def test_pointing_leaves_the_place_and_a_pin_which_goes_with_it(viewer: Viewer) -> None:
    client: Any = viewer.client
    switch(viewer, "Point", True)
    assert client.clicks == 1 and viewer.pointed.value == ""
    click(viewer)
    assert viewer.pointed.value == "0.500 0.250"
    assert viewer._pin is not None and viewer._pin.position[2] == pytest.approx(0.1 + PIN / 2)
    switch(viewer, "Point", False)
    assert client.clicks == 0 and viewer._pin is None


def test_the_first_look_is_the_same_for_wide_windows_and_farther_off_for_narrow_ones(
    server: viser.ViserServer,
) -> None:
    def distance(aspect: float) -> float:
        server.gui.reset()
        client: Any = Client(server, aspect)
        Viewer(client, lambda *_: None, lambda x, y: 0.0).go_home()
        return float(np.linalg.norm(client.camera.position - LOOK_AT))

    first = float(np.linalg.norm(CAMERA - LOOK_AT))
    assert distance(1.6) == pytest.approx(first)
    assert distance(0.8) == pytest.approx(first * 1.25 / 0.8)
    assert distance(0.3) == pytest.approx(first * FARTHEST)


def test_a_small_machine_is_looked_at_from_as_many_of_its_sizes(viewer: Viewer) -> None:
    client: Any = viewer.client
    viewer.look_at_machine(SIZE)
    assert viewer.scale == 1.0
    viewer.look_at_machine(SIZE / 10)
    assert client.camera.position == pytest.approx(CAMERA / 10)
    assert client.camera.look_at == pytest.approx(LOOK_AT / 10)
