"""What lies on the ground around the machine says what is so, and is sent when it changes."""

import math
from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level, standing
from walking_console.planner.geometry.paths import arc_of_command
from walking_console.planner.geometry.transforms import placed
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Command
from walking_console.web.scene.overlays import (
    PATH_LENGTH,
    PATH_PIECES,
    NamesOverlay,
    PathOverlay,
    ReachOverlay,
    StabilityOverlay,
    margin_colour,
    path_ahead,
    polyline,
    reach_boxes,
    rotated,
    stroke_lines,
)
from walking_console.web.scene.palette import BAD, GOOD, MARGIN_GOOD, WARN, for_scene, leg_names
from walking_console.web.scene.terrain_tiles import TerrainTiles

YAW_LENGTH = 0.65  # m
COMMANDS = [(0.0, 0.1, 0.0), (math.pi / 2, 0.1, 0.0), (0.3, 0.1, 0.08), (-1.0, 0.05, -0.05)]


@pytest.fixture
def terrain(server: viser.ViserServer) -> TerrainTiles:
    tiles = TerrainTiles(server)
    tiles.draw(level())
    return tiles


@pytest.mark.parametrize("command", COMMANDS)
def test_the_path_drawn_is_the_path_commanded(command: tuple[float, float, float]) -> None:
    pose = (2.0, -1.0, 0.4)
    lines = path_ahead(pose, Command(*command), YAW_LENGTH)
    arc, _ = arc_of_command(*command, YAW_LENGTH)
    end = placed(pose, *arc.pose(PATH_LENGTH)[:2])
    assert lines[0, 0] == pytest.approx(pose[:2])
    assert lines[PATH_PIECES - 1, 1] == pytest.approx(end)


def test_a_command_to_the_left_is_drawn_to_the_left() -> None:
    lines = path_ahead((0.0, 0.0, 0.0), Command(math.pi / 2, 0.1, 0.0), YAW_LENGTH)
    assert lines[PATH_PIECES - 1, 1] == pytest.approx((0.0, PATH_LENGTH))


@pytest.mark.parametrize("turn_rate", [0.1, -0.1])
def test_a_turn_on_the_spot_is_an_arc_about_the_machine_to_its_side(turn_rate: float) -> None:
    lines = path_ahead((0.0, 0.0, 0.0), Command(0.0, 0.0, turn_rate), YAW_LENGTH)[:PATH_PIECES]
    assert np.linalg.norm(lines, axis=2) == pytest.approx(YAW_LENGTH)
    assert np.sign(lines[-1, 1, 1]) == np.sign(turn_rate)


def test_the_path_is_shown_while_something_is_commanded(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = PathOverlay(server, standing().machine)
    driven = replace(standing(), command=Command(0.0, 0.1))
    shown = {name: value for _, name, value in overlay.changes(driven, terrain)}
    assert shown["visible"] is True and len(shown["points"]) == PATH_PIECES + 2
    assert overlay.changes(driven, terrain) == []
    assert overlay.changes(standing(), terrain) == [(overlay.line, "visible", False)]


@pytest.mark.parametrize("machine", ["titan3", "hexapod"])
def test_every_foot_carries_its_leg_s_name_above_it(
    server: viser.ViserServer, terrain: TerrainTiles, machine: str
) -> None:
    standing_so = standing(machine)
    overlay = NamesOverlay(server, standing_so.machine)
    assert [label.text for label in overlay.handles] == list(leg_names(standing_so.machine.legs))
    for (label, name, place), foot in zip(
        overlay.changes(standing_so, terrain), standing_so.feet, strict=True
    ):
        assert name == "position" and place[:2] == foot[:2] and place[2] > foot[2]
        assert label in overlay.handles


def test_stroke_lines_are_as_long_as_the_stroke() -> None:
    # λ* of H §4.3 at 30 degrees
    line = stroke_lines(load_machine("titan3"), math.radians(30.0))[0]
    assert np.linalg.norm(line[1] - line[0]) == pytest.approx(0.5774, abs=1e-4)


def test_every_leg_has_its_reach_rectangle() -> None:
    machine = load_machine("hexapod")
    pieces = reach_boxes(machine).reshape(len(machine.legs), -1, 3)
    for corners, (x0, x1, y0, y1) in zip(pieces, machine.boxes, strict=True):
        assert (corners[:, 0].min(), corners[:, 0].max()) == pytest.approx((x0, x1))
        assert (corners[:, 1].min(), corners[:, 1].max()) == pytest.approx((y0, y1))


def test_reach_is_carried_along_at_standing_height(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    machine = standing().machine
    overlay = ReachOverlay(server, machine)
    snapshot = replace(standing(), body=(1.0, 2.0, machine.height + 0.5, 0.0, 0.0, math.pi / 2))
    values = {name: v for h, name, v in overlay.changes(snapshot, terrain) if h is overlay.boxes}
    assert values["position"] == pytest.approx((1.0, 2.0, 0.53))
    assert values["wxyz"] == pytest.approx((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))


def test_margins_run_from_red_over_amber_to_green() -> None:
    assert margin_colour(-math.inf) == margin_colour(-0.01) == margin_colour(0.0) == for_scene(BAD)
    assert margin_colour(MARGIN_GOOD / 2) == for_scene(WARN)
    assert margin_colour(MARGIN_GOOD) == margin_colour(1.0) == for_scene(GOOD)


def test_the_polygon_has_the_feet_that_carry_as_its_corners(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StabilityOverlay(server, standing().machine)
    overlay.changes(standing(), terrain)
    lifted = replace(standing(), support=(False, True, True, True))
    points = {name: v for h, name, v in overlay.changes(lifted, terrain) if h is overlay.outline}
    ends = {tuple(np.round(end, 3)) for end in points["points"].reshape(-1, 3)[:, :2].tolist()}
    feet = [tuple(np.round(foot[:2], 3)) for foot in standing().feet]
    assert feet[0] not in ends and set(feet[1:]) <= ends


def test_a_polygon_that_stays_is_sent_once(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StabilityOverlay(server, standing().machine)
    overlay.changes(standing(), terrain)
    assert {name for _, name, _ in overlay.changes(standing(), terrain)} == {"position"}


def test_a_machine_on_no_foot_has_a_polygon_of_nothing(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StabilityOverlay(server, standing().machine)
    fallen = replace(standing(), support=(False,) * 4, polygon_margin=-math.inf)
    overlay.changes(standing(), terrain)
    changes = {(h.name, name): v for h, name, v in overlay.changes(fallen, terrain)}
    mesh = changes["/world/stability/fill", "vertices"]
    assert np.ptp(mesh[:, :2], axis=0) == pytest.approx((0.0, 0.0))
    assert changes["/world/stability/fill", "color"] == for_scene(BAD)


def test_a_polygon_with_little_margin_is_dashed_for_those_who_do_not_see_its_colour(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StabilityOverlay(server, standing().machine)
    pieces = []
    for margin in (2 * MARGIN_GOOD, MARGIN_GOOD / 2):
        shown = replace(standing(), polygon_margin=margin)
        changes = {(h.name, name): v for h, name, v in overlay.changes(shown, terrain)}
        pieces.append(len(changes["/world/stability/outline", "points"]))
    assert pieces[1] == pieces[0] / 2


def test_points_are_turned_counter_clockwise() -> None:
    assert rotated(np.array([(1.0, 0.0)]), math.pi / 2)[0] == pytest.approx((0.0, 1.0))


def test_a_chain_of_points_is_joined_piece_by_piece() -> None:
    pieces = polyline([(0, 0, 0), (1, 0, 0), (1, 1, 0)])
    assert pieces.tolist() == [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 1, 0]]]
