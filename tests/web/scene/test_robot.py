"""The drawn robot stands where the snapshot says, and its feet show what they do."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import standing
from walking_console.planner.geometry.transforms import rotation
from walking_console.web.scene.palette import BAD, WARN, for_scene
from walking_console.web.scene.robot import RobotNode, foot_colour
from walking_console.web.scene.robot_shapes import RobotShapes


def drawn(server: viser.ViserServer, robot: str) -> RobotNode:
    return RobotNode(server, RobotShapes(standing(robot).machine))


@pytest.mark.parametrize("robot", ["titan3", "hexapod"])
def test_every_foot_is_drawn_at_its_tip(server: viser.ViserServer, robot: str) -> None:
    node = drawn(server, robot)
    snapshot = standing(robot)
    places = {id(h): v for h, name, v in node.changes(snapshot) if name == "position"}
    feet = [tuple(places[id(foot)]) for foot in node.feet]
    assert feet == [pytest.approx(foot) for foot in snapshot.feet]


def test_the_torso_is_turned_as_the_body_is(server: viser.ViserServer) -> None:
    node = drawn(server, "titan3")
    angles = (0.1, -0.2, 0.7)
    snapshot = replace(standing(), body=(1.0, 2.0, 0.8, *angles))
    values = {name: v for h, name, v in node.changes(snapshot) if h is node.torso}
    assert tuple(values["position"]) == pytest.approx((1.0, 2.0, 0.8))
    w, x, y, z = values["wxyz"]
    assert 2 * (x * z - w * y) == pytest.approx(rotation(*angles)[2][0])
    assert 2 * (x * y + w * z) == pytest.approx(rotation(*angles)[1][0])


def test_a_colour_is_sent_when_a_foot_changes_what_it_does_and_not_again(
    server: viser.ViserServer,
) -> None:
    node = drawn(server, "titan3")
    node.changes(standing())
    lifted = replace(standing(), support=(False, True, True, True))
    coloured = [(h, v) for h, name, v in node.changes(lifted) if name == "color"]
    assert coloured == [(node.feet[0], for_scene(WARN))]
    assert [c for c in node.changes(lifted) if c[1] == "color"] == []


def test_a_foot_that_should_carry_and_does_not_touch_is_red() -> None:
    assert foot_colour(on_ground=False, carries=True) == for_scene(BAD)
    assert foot_colour(on_ground=True, carries=False) == for_scene(WARN)
    assert len({foot_colour(True, True), foot_colour(False, True), foot_colour(False, False)}) == 3


def test_a_removed_robot_leaves_no_part(server: viser.ViserServer) -> None:
    drawn(server, "hexapod").remove()
    names = set(server.scene._handle_from_node_name)
    assert not any(name.startswith("/world/") for name in names)


def test_legs_reach_from_the_body_to_the_ground(server: viser.ViserServer) -> None:
    node = drawn(server, "titan3")
    snapshot = standing()
    places = {id(h): v for h, name, v in node.changes(snapshot) if name == "position"}
    hips = np.array([places[id(thigh)] for thigh in node.thighs])
    knees = np.array([places[id(shin)] for shin in node.shins])
    assert hips[:, 2] == pytest.approx(snapshot.body[2])
    assert np.linalg.norm(knees - hips, axis=1) == pytest.approx(node.shapes.thigh)
