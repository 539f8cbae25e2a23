"""The scene: handles made once, only what changed is sent, and any walker on any ground."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import viser

from walking_console.planner.geometry.paths import arc_of_command
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Command, GaitPreview, Mode, Phase, Stance, StepPlan
from walking_console.server.viser_bridge import viser_without_socket
from walking_console.sim.snapshot import Snapshot, TerrainView
from walking_console.web.scene.scene import (
    GREEN,
    RED,
    RING_CORNERS,
    Scene,
    course_ahead,
    foot_colour,
    foot_paths,
    margin_colour,
    stroke_lines,
    trace_lines,
)


@pytest.fixture(scope="module")
def canvas() -> Iterator[viser.ViserServer]:
    server, _ = viser_without_socket()
    yield server
    server.stop()


@pytest.fixture
def scene(canvas: viser.ViserServer) -> Scene:
    canvas.scene.reset()
    return Scene(canvas)


def level(revision: int = 1) -> TerrainView:
    heights = np.zeros((160, 160))
    return TerrainView(revision, heights, np.zeros(heights.shape, bool), 0.05, (-4.0, -4.0))


def standing(robot: str = "titan3", terrain: TerrainView | None = None) -> Snapshot:
    machine = load_machine(robot)
    legs = len(machine.legs)
    return Snapshot(
        tick=0,
        time=0.0,
        machine=machine,
        scenario="flat",
        planner="crab",
        planner_mode="paper",
        body=(0.0, 0.0, machine.height, 0.0, 0.0, 0.0),
        feet=tuple((*leg.centre, 0.0) for leg in machine.legs),
        contact=(True,) * legs,
        support=(True,) * legs,
        mode=Mode.STAND,
        reason="",
        command=Command(),
        speed=0.0,
        speed_max=0.0,
        margin=0.2,
        polygon_margin=0.2,
        energy_margin=0.05,
        step=0,
        distance=0.0,
        plan=None,
        plan_time=0.0,
        ready=None,
        terrain=terrain or level(),
        flags=(False, False, False),
        whiskers=(0,) * legs,
        paused=False,
        rate=1.0,
        late=0.0,
    )


def stepping() -> StepPlan:
    """Front left goes 0.3 m ahead, aiming below the ground so that touch decides."""
    feet = np.array([[(*leg.centre, 0.0) for leg in load_machine("titan3").legs]] * 4)
    feet[1:3, 0, 2], feet[2:, 0, 0], feet[3, 0, 2] = 0.1, feet[0, 0, 0] + 0.3, -0.1
    landing = (float(feet[3, 0, 0]), float(feet[3, 0, 1]), 0.0)
    end = Stance((0.1, 0.0, 0.85, 0.0), (landing, *(tuple(foot) for foot in feet[0, 1:])), 0)
    body = np.array([(0.0, 0.0, 0.85, 0.0)] * 4)
    phases = (Phase.UP, Phase.RETURN, Phase.DOWN)
    return StepPlan(
        (0,),
        np.array([0.0, 0.1, 0.6, 0.9]),
        body,
        feet,
        phases,
        end,
        landing=landing,
        search_start=landing,
    )


def foreseeing(complete: bool) -> GaitPreview:
    """A straight trace of 1 m with three footholds; without a way beyond 0.4 m when it is not
    complete.
    """
    line = tuple((0.05 * k, 0.05 * k, 0.0) for k in range(21))
    footholds = (((0.9, 0.6, 0.0), (1.2, 0.6, 0.0)), ((0.3, 0.6, 0.0),), (), (), (), ())
    return GaitPreview(
        line,
        footholds,
        ((),) * 6,
        (),
        1.0 if complete else 0.4,
        1.0,
        complete,
        "" if complete else "no foothold",
    )


def names(scene: Scene) -> set[str]:
    return set(scene.server.scene._handle_from_node_name)


@pytest.mark.parametrize("robot", ["titan3", "hexapod"])
def test_a_standing_machine_is_drawn(scene: Scene, robot: str) -> None:
    snapshot = standing(robot)
    scene.draw(snapshot)
    assert {
        "/world/torso",
        "/world/thigh_1",
        "/world/foot_4",
        "/world/ground/0_0",
        "/world/stability/fill",
    } <= names(scene)
    walker = scene._walker
    assert walker is not None
    assert [tuple(foot.position) for foot in walker.feet] == [
        pytest.approx(foot) for foot in snapshot.feet
    ]


def test_walking_makes_no_new_nodes(scene: Scene) -> None:
    snapshot = standing()
    scene.draw(snapshot)
    before = names(scene)
    for tick in range(1, 400):
        x = 0.002 * tick
        feet = tuple((a + x, b, c) for a, b, c in snapshot.feet)
        scene.draw(
            replace(
                snapshot,
                tick=tick,
                time=0.02 * tick,
                body=(x, 0.0, 0.85, 0.0, 0.0, 0.0),
                feet=feet,
                command=Command(0.0, 0.1),
            )
        )
    assert names(scene) == before


def test_another_machine_replaces_the_figure(scene: Scene) -> None:
    scene.draw(standing("titan3"))
    scene.draw(standing("hexapod"))
    assert scene._walker is not None
    assert "/world/foot_6" in names(scene)
    scene.draw(standing("titan3"))
    assert "/world/foot_6" not in names(scene)


def test_an_edited_patch_sends_one_tile(scene: Scene) -> None:
    first = level()
    forbidden = first.forbidden.copy()
    forbidden[30, 30] = True
    scene.draw(standing(terrain=replace(first, revision=2, forbidden=forbidden)))
    assert scene._ground is not None
    before = dict(scene._ground.tiles)
    again = forbidden.copy()
    again[31, 31] = True
    scene.draw(standing(terrain=replace(first, revision=3, forbidden=again)))
    after = scene._ground.tiles
    assert [name for name in after if after[name][0] != before[name][0]] == ["1_1"]
    assert all(after[name][1] is before[name][1] for name in after)


def test_a_map_of_another_size_leaves_no_old_tile(scene: Scene) -> None:
    scene.draw(standing())
    small = np.zeros((4, 4))
    scene.draw(
        standing(terrain=TerrainView(2, small, np.zeros(small.shape, bool), 1.0, (-2.0, -2.0)))
    )
    assert scene._ground is not None
    assert len(scene._ground.tiles) == 16
    assert {name for name in names(scene) if name.startswith("/world/ground/")} == {
        *(f"/world/ground/{name}" for name in scene._ground.tiles),
        "/world/ground/floor",
    }


def test_a_step_shows_its_path_and_landing(scene: Scene) -> None:
    plan = stepping()
    scene.draw(standing())
    scene.draw(
        replace(
            standing(), plan=plan, mode=Mode.RETURN, support=(False, True, True, True), time=0.5
        )
    )
    overlay = scene._overlay
    assert overlay is not None and overlay.landing.visible and overlay.path.visible
    assert overlay.landing.position[:2] == pytest.approx(plan.landing[:2] if plan.landing else None)
    scene.draw(replace(standing(), time=0.9))
    assert not overlay.landing.visible and not overlay.path.visible


def test_the_foot_path_ends_on_the_ground_not_at_the_aim_below_it() -> None:
    assert foot_paths(stepping())[..., 2].min() == pytest.approx(0.0)


def test_a_fallen_machine_over_a_hole_is_drawn_too(scene: Scene) -> None:
    terrain = level()
    heights = terrain.heights.copy()
    heights[70:90, 70:90] = np.nan
    snapshot = standing(terrain=replace(terrain, heights=heights, forbidden=np.isnan(heights)))
    fallen = replace(snapshot, mode=Mode.FALLEN, support=(False,) * 4)
    scene.draw(
        replace(
            fallen, body=(0.0, 0.0, 0.2, 0.3, 0.8, 1.0), margin=-math.inf, polygon_margin=-math.inf
        )
    )


COURSES = [(0.0, 0.1, 0.0), (math.pi / 2, 0.1, 0.0), (0.3, 0.1, 0.08), (-1.0, 0.05, -0.05)]


@pytest.mark.parametrize(("crab_angle", "speed", "turn_rate"), COURSES)
def test_the_course_drawn_is_the_course_walked(
    crab_angle: float, speed: float, turn_rate: float
) -> None:
    lines = course_ahead(2.0, -1.0, 0.4, crab_angle, speed, turn_rate, 0.65)
    arc, _ = arc_of_command(crab_angle, speed, turn_rate, 0.65)
    dx, dy, _ = arc.pose(1.6)
    end = (
        2.0 + dx * math.cos(0.4) - dy * math.sin(0.4),
        -1.0 + dx * math.sin(0.4) + dy * math.cos(0.4),
    )
    assert lines[0, 0] == pytest.approx((2.0, -1.0))
    assert lines[23, 1] == pytest.approx(end, abs=2e-3)


def test_a_turn_on_the_spot_is_drawn_as_an_arc_about_the_machine() -> None:
    lines = course_ahead(0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.65)
    assert np.linalg.norm(lines[:24], axis=2) == pytest.approx(0.65)


def test_stroke_lines_are_as_long_as_the_stroke() -> None:
    # λ* of gait-spec §3: 0.5774 at 30 degrees
    line = stroke_lines(load_machine("titan3"), math.radians(30.0))[0]
    assert np.linalg.norm(line[1] - line[0]) == pytest.approx(0.5774, abs=1e-4)


def test_margins_run_from_red_to_green() -> None:
    assert margin_colour(-math.inf) == margin_colour(-0.01) == margin_colour(0.0) == RED
    assert margin_colour(0.08) == margin_colour(1.0) == GREEN


def test_a_foot_that_should_carry_and_does_not_stands_out() -> None:
    assert len({foot_colour(True, True), foot_colour(False, True), foot_colour(False, False)}) == 3


def test_a_trace_ahead_is_drawn_with_its_footholds_and_goes_with_them(scene: Scene) -> None:
    ahead = foreseeing(complete=True)
    scene.draw(replace(standing("hexapod"), planner="trace", ahead=ahead))
    overlay = scene._overlay
    assert overlay is not None and overlay.trace.visible and overlay.treads.visible
    assert len(overlay.treads.points) == 3 * RING_CORNERS
    scene.draw(replace(standing("hexapod"), tick=1, planner="trace", ahead=None))
    assert not overlay.trace.visible and not overlay.treads.visible


def test_the_trace_is_red_where_no_way_was_found() -> None:
    sure, _ = trace_lines(foreseeing(complete=True))
    ended, colours = trace_lines(foreseeing(complete=False))
    assert len(ended) == len(sure) + 1  # the bar across the dead end
    reds = [piece for piece, colour in zip(ended, colours, strict=True) if tuple(colour[0]) == RED]
    assert all(piece[:, 0].min() >= 0.4 for piece in reds) and len(reds) > 1


def test_the_search_domain_and_refused_cells_of_a_step_are_drawn(scene: Scene) -> None:
    decision = {
        "domain": [[0.5, 0.2], [0.9, 0.2], [0.9, 0.6], [0.5, 0.6]],
        "legs": [
            {"leg": 1, "refused": [{"x": 0.7, "y": 0.4, "reason": "prohibited cell"}]},
            {"leg": 2, "refused": []},
        ],
    }
    told = replace(stepping(), decision=decision)
    scene.draw(replace(standing(), plan=told, mode=Mode.RETURN, decision=decision))
    overlay = scene._overlay
    assert overlay is not None and overlay.domain.visible and len(overlay.domain.points) == 4
    assert overlay.refused.visible and len(overlay.refused.points) == 2
    scene.draw(replace(standing(), tick=1, plan=stepping(), mode=Mode.RETURN))
    assert not overlay.domain.visible and not overlay.refused.visible


def test_a_click_meets_the_ground_where_it_is_seen(scene: Scene) -> None:
    touched: list[tuple[str, float, float, float]] = []
    scene.draw(standing())
    scene.on_paint = lambda *touch: touched.append(touch)
    scene._paint("dig", np.array((0.0, 0.0, 2.0)), np.array((1.0, 0.5, -2.0)), 0.12)
    scene._paint("dig", np.array((0.0, 0.0, 2.0)), np.array((0.0, 0.0, 1.0)), 0.12)  # into the sky
    # beside the map
    scene._paint("dig", np.array((9.0, 0.0, 2.0)), np.array((0.0, 0.0, -1.0)), 0.12)
    assert [(brush, radius) for brush, _, _, radius in touched] == [("dig", 0.12)]
    assert touched[0][1:3] == pytest.approx((1.0, 0.5), abs=0.02)
