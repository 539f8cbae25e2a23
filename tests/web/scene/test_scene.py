"""The scene: handles made once, only what changed is sent, and any machine on any ground."""

import math
from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level, preview, standing, stepping
from walking_console.planner.types import Command, Mode
from walking_console.web.scene.scene import Scene
from walking_console.web.scene.viewer import POINT


@pytest.fixture
def scene(server: viser.ViserServer) -> Scene:
    return Scene(server)


def names(scene: Scene) -> set[str]:
    return set(scene.server.scene._handle_from_node_name)


def shown(scene: Scene, name: str) -> bool:
    return bool(scene.server.scene._handle_from_node_name[name].visible)


@pytest.mark.parametrize("robot", ["titan3", "hexapod"])
def test_a_standing_machine_is_drawn(scene: Scene, robot: str) -> None:
    snapshot = standing(robot)
    scene.draw(snapshot)
    parts = {"/world/torso", "/world/thigh_1", "/world/foot_4"}
    assert parts | {"/world/ground/0_0", "/world/stability/fill"} <= names(scene)
    assert scene.robot is not None
    feet = [tuple(foot.position) for foot in scene.robot.feet]
    assert feet == [pytest.approx(foot) for foot in snapshot.feet]


def test_walking_makes_no_new_nodes(scene: Scene) -> None:
    snapshot = standing()
    scene.draw(snapshot)
    before = names(scene)
    for tick in range(1, 400):
        x = 0.002 * tick
        body = (x, 0.0, 0.85, 0.0, 0.0, 0.0)
        feet = tuple((a + x, b, c) for a, b, c in snapshot.feet)
        walking = replace(snapshot, body=body, feet=feet, command=Command(0.0, 0.1))
        scene.draw(replace(walking, tick=tick, time=0.02 * tick))
    assert names(scene) == before


def test_another_machine_replaces_the_drawn_robot(scene: Scene) -> None:
    scene.draw(standing("titan3"))
    four = names(scene)
    scene.draw(standing("hexapod"))
    assert "/world/foot_6" in names(scene)
    scene.draw(standing("titan3"))
    assert names(scene) == four


def test_a_fallen_machine_over_a_hole_is_drawn_where_it_lies(scene: Scene) -> None:
    terrain = level()
    heights = terrain.heights.copy()
    heights[70:90, 70:90] = np.nan
    over_hole = standing(terrain=replace(terrain, heights=heights, forbidden=np.isnan(heights)))
    body = (0.0, 0.0, 0.2, 0.3, 0.8, 1.0)
    fallen = replace(over_hole, mode=Mode.FALLEN, support=(False,) * 4, body=body)
    scene.draw(replace(fallen, margin=-math.inf, polygon_margin=-math.inf))
    assert scene.robot is not None
    assert tuple(scene.robot.torso.position) == pytest.approx(body[:3])
    assert shown(scene, "/world/ground/floor")
    positions = [tuple(handle.position) for handle in scene.overlays[0].handles]
    assert np.all(np.isfinite(positions))


def test_a_step_and_a_preview_are_drawn_and_go_again(scene: Scene) -> None:
    hexapod = standing("hexapod")
    scene.draw(replace(hexapod, plan=stepping(), ahead=preview(complete=True)))
    assert shown(scene, "/world/plan/landing") and shown(scene, "/world/preview/line")
    scene.draw(replace(hexapod, tick=1, time=0.02))
    assert not shown(scene, "/world/plan/landing") and not shown(scene, "/world/preview/line")


def test_trails_of_another_run_are_forgotten(scene: Scene) -> None:
    for k in range(5):
        body = (0.1 * k, 0.0, 0.85, 0.0, 0.0, 0.0)
        scene.draw(replace(standing(), time=1.0 * k, body=body))
    assert shown(scene, "/world/trails/body_0")
    scene.draw(standing())
    assert not shown(scene, "/world/trails/body_0")


def test_a_click_with_a_brush_is_passed_on_as_a_place_on_the_ground(scene: Scene) -> None:
    touched: list[tuple[str, float, float, float]] = []
    scene.draw(standing())
    scene.on_paint = lambda *touch: touched.append(touch)
    above = np.array((0.0, 0.0, 2.0))
    place = scene._touch("dig", above, np.array((1.0, 0.5, -2.0)), 0.12)
    assert place == pytest.approx((1.0, 0.5), abs=0.02)
    assert scene._touch("dig", above, np.array((0.0, 0.0, 1.0)), 0.12) is None  # into the sky
    assert scene._touch(POINT, above, np.array((1.0, 0.5, -2.0)), 0.12) == place
    assert [(brush, radius) for brush, _, _, radius in touched] == [("dig", 0.12)]
    assert touched[0][1:3] == pytest.approx((1.0, 0.5), abs=0.02)
