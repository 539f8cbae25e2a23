"""What the planner intends: a step and how it was searched, and the preview with its dead ends."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from tests.web.scene.snapshots import level, preview, standing, stepping
from walking_console.planner.types import Mode
from walking_console.web.scene.palette import BAD, LEGS, PATH, for_scene
from walking_console.web.scene.plan_overlays import (
    PAST_GOAL,
    RING,
    RING_CORNERS,
    PreviewOverlay,
    StepOverlay,
    domain_outline,
    foot_paths,
    foothold_rings,
    preview_lines,
    refused_crosses,
    ring_colours,
)
from walking_console.web.scene.terrain_tiles import TerrainTiles

DECISION = {
    "domain": [[0.5, 0.2], [0.9, 0.2], [0.9, 0.6], [0.5, 0.6]],
    "legs": [
        {"leg": 1, "refused": [{"x": 0.7, "y": 0.4, "reason": "prohibited cell"}]},
        {"leg": 2, "refused": [{"x": 0.1, "y": 0.1, "reason": "prohibited cell"}]},
    ],
}


@pytest.fixture
def terrain(server: viser.ViserServer) -> TerrainTiles:
    tiles = TerrainTiles(server)
    tiles.draw(level())
    return tiles


def test_the_foot_path_ends_on_the_ground_not_at_the_aim_below_it() -> None:
    assert foot_paths(stepping())[..., 2].min() == pytest.approx(0.0)


def test_a_step_shows_its_path_and_landing_until_it_is_over(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StepOverlay(server, standing().machine)
    plan = stepping()
    step = replace(standing(), plan=plan, mode=Mode.RETURN, time=0.5)
    changes = {(h.name, name): v for h, name, v in overlay.changes(step, terrain)}
    assert plan.landing is not None
    assert changes["/world/plan/landing", "position"][:2] == pytest.approx(plan.landing[:2])
    shown = {name for (name, what), value in changes.items() if what == "visible" and value}
    assert shown >= {"/world/plan/path", "/world/plan/landing", "/world/search/start"}
    assert overlay.changes(step, terrain) == []
    over = overlay.changes(standing(), terrain)
    assert {value for _, name, value in over if name == "visible"} == {False}


def test_a_shift_on_four_feet_marks_no_foothold(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = StepOverlay(server, standing().machine)
    shift = replace(standing(), plan=replace(stepping(), swing=()))
    assert {v for _, name, v in overlay.changes(shift, terrain) if name == "visible"} == {False}


def test_the_search_domain_is_drawn_where_the_decision_has_it() -> None:
    outline = domain_outline(replace(stepping(), decision=DECISION))
    assert outline is not None and len(outline) == 4
    assert outline[:, 0, :2] == pytest.approx(np.array(DECISION["domain"]))
    assert domain_outline(stepping()) is None
    assert domain_outline(replace(stepping(), decision={"domain": [[0.5, 0.2]]})) is None
    assert domain_outline(None) is None


def test_cells_refused_to_the_swing_leg_are_crossed_out(terrain: TerrainTiles) -> None:
    crosses = refused_crosses(replace(stepping(), decision=DECISION), terrain)
    assert crosses is not None and len(crosses) == 2
    assert crosses.mean(axis=(0, 1))[:2] == pytest.approx((0.7, 0.4))
    assert refused_crosses(stepping(), terrain) is None


def test_the_path_is_red_where_no_way_was_found() -> None:
    sure, _ = preview_lines(preview(complete=True))
    ended, colours = preview_lines(preview(complete=False))
    assert len(ended) == len(sure) + 1  # the bar across the dead end
    red = np.all(colours[:, 0] == for_scene(BAD), axis=1)
    assert red.sum() > 1
    assert ended[red][..., 0].min() >= 0.4 - 1e-9


def test_the_path_is_blue_as_far_as_it_is_sure_and_pale_beyond_the_goal() -> None:
    lines, colours = preview_lines(replace(preview(complete=True), goal=0.6, reached=0.6))
    middle = lines[..., 0].mean(axis=1)
    assert np.all(colours[middle < 0.6] == for_scene(PATH))
    assert np.all(colours[middle > 0.6] == PAST_GOAL)


def test_a_preview_of_one_point_draws_no_line() -> None:
    lines, colours = preview_lines(replace(preview(complete=True), line=((0.0, 0.0, 0.0),)))
    assert len(lines) == len(colours) == 0


def test_every_planned_foothold_has_a_ring_in_its_legs_colour() -> None:
    footholds = [(0.9, 0.6, 0.1, 0), (0.3, 0.6, 0.0, 1)]
    rings = foothold_rings(footholds).reshape(2, RING_CORNERS, 2, 3)
    assert rings.mean(axis=(1, 2))[:, :2] == pytest.approx(np.array(footholds)[:, :2])
    assert np.linalg.norm(rings[0, :, 0, :2] - (0.9, 0.6), axis=1) == pytest.approx(RING)
    colours = ring_colours(footholds).reshape(2, -1, 3)
    assert np.all(colours[0] == for_scene(LEGS[0])) and np.all(colours[1] == for_scene(LEGS[1]))


def test_a_preview_is_drawn_with_its_footholds_and_goes_with_them(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = PreviewOverlay(server, standing("hexapod").machine)
    ahead = replace(standing("hexapod"), ahead=preview(complete=True))
    changes = {(h.name, name): v for h, name, v in overlay.changes(ahead, terrain)}
    assert changes["/world/preview/line", "visible"]
    assert len(changes["/world/preview/footholds", "points"]) == 3 * RING_CORNERS
    assert overlay.changes(ahead, terrain) == []
    gone = overlay.changes(standing("hexapod"), terrain)
    assert gone == [(overlay.line, "visible", False), (overlay.rings, "visible", False)]


def test_a_preview_without_footholds_shows_none(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    overlay = PreviewOverlay(server, standing("hexapod").machine)
    bare = replace(preview(complete=True), footholds=((),) * 6)
    changes = overlay.changes(replace(standing("hexapod"), ahead=bare), terrain)
    shown = {handle.name: value for handle, name, value in changes if name == "visible"}
    assert shown == {"/world/preview/line": True, "/world/preview/footholds": False}
