"""The figures of the 1986 paper, each walked by its name and held to what the paper shows in it;
and each drawn.
"""

import math
from functools import cache

import numpy as np
import pytest

from walking_console.planner.crab.step_plans import cruise_speed
from walking_console.planner.motion.strides import stroke_length
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import TICK
from walking_console.sim.runs.runner import run_scenario, succeeded
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario
from walking_console.web.figures import FIGURES, draw_figure
from walking_console.web.figures.run_data import FigureError, Recipe, read_walk, walk_recipe

from .telling import walked

NAMES = (
    "fig6a",
    "fig6b",
    "fig6c",
    "fig12",
    "fig13",
    "fig14",
    "fig15",
    "fig16",
    "fig17-up",
    "fig17-down",
    "fig19",
    "omni",
)
STANDARD = 0.05  # of λ*, the tolerance of H fig. 9


@pytest.fixture(scope="module")
def told(shared):
    """Every figure scenario, walked and read once."""
    return cache(shared.walked)


def standard_from(walk):
    """The first step from which on every step came out in the standard layout."""
    off = [step["off_standard"] for step in walk.steps]
    return next(
        k for k in range(len(off) + 1) if all(o is not None and o <= STANDARD for o in off[k:])
    )


def test_every_figure_of_the_issue_can_be_named():
    assert set(FIGURES) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_figure_is_walked_as_its_scenario_expects(told, name):
    summary = told(name).summary
    assert succeeded(summary), (summary["result"], summary["reason"], summary["expect"])
    assert summary["falls"] == 0 and summary["forbidden_steps"] == 0


@pytest.mark.parametrize(("name", "order"), [("fig6a", (1, 3, 4, 2)), ("fig6b", (1, 3, 2, 4))])
def test_the_legs_swing_in_the_order_of_fig_6(told, name, order):
    legs = told(name).legs
    first = order.index(legs[0])
    assert legs == [order[(first + k) % 4] for k in range(len(legs))]


def test_swinging_to_the_maximum_stride_is_stuck_at_the_fourth_step(tmp_path):
    walk = walked(tmp_path, "fig6c", "mode=naive", "expect={}")
    assert walk.legs == [1, 3, 4]
    assert walk.summary["result"] == "blocked"
    assert walk.summary["reason"].startswith(
        "leg 2: the centre of gravity cannot enter the triangle"
    )


def test_the_search_domains_bring_the_same_posture_into_the_standard_gait(told):
    walk = told("fig6c")
    assert walk.legs[:4] == [1, 3, 4, 2]
    assert standard_from(walk) <= 4


def test_between_holes_feet_land_off_the_start_of_the_search_but_never_in_a_hole(told):
    walk = told("fig12")
    moved = [math.dist(step["search_start"][:2], step["landing"][:2]) for step in walk.steps]
    assert sum(way > 0.01 for way in moved) >= 3
    assert not np.isnan(walk.ground_at(np.array([step["landing"] for step in walk.steps]))).any()


def test_the_river_is_as_wide_as_the_stride_and_twelve_steps_beyond_its_bank_the_gait_is_standard(
    told,
):
    walk = told("fig13")
    terrain, angle = walk.summary["scenario"]["terrain"], math.radians(16)
    reach = walk.machine.reach
    assert terrain["width"] == pytest.approx(
        stroke_length(reach.x_span, reach.y_span, angle), abs=1e-4
    )
    along = [
        step["landing"][0] * math.cos(angle) + step["landing"][1] * math.sin(angle)
        for step in walk.steps
    ]
    over = next(k for k, way in enumerate(along) if way > terrain["at"] + terrain["width"])
    # set-up before
    assert (
        3 <= next(k for k, step in enumerate(walk.steps) if step["off_standard"] > STANDARD) < over
    )
    assert standard_from(walk) - over <= 12
    stood = walk.log["feet"][walk.log["support"] & walk.log["contact"]]
    assert not np.isnan(walk.ground_at(stood)).any()


def test_a_river_of_the_stride_straight_ahead_cannot_be_crossed_within_the_control_reach():
    # Square to the body both fore legs are level: leg 1 comes down at most x* ahead of where leg 4
    # still stands, to the millimetre,
    # and a sole needs its own radius of bank on either side.
    machine = load_machine("titan3")
    assert (
        machine.reach.x_span
        < stroke_length(machine.reach.x_span, machine.reach.y_span, 0.0) + 2 * machine.foot_radius
    )


@pytest.mark.parametrize("name", ["fig15-known", "fig17-up-known", "fig17-down-known"])
def test_the_body_is_at_least_twice_as_smooth_as_by_the_average_of_the_supporting_legs(told, name):
    summary = told(name).summary
    assert summary["roughness"] <= 0.5 * summary["roughness_average_rule"]
    assert summary["roughness_ratio"] == pytest.approx(
        summary["roughness"] / summary["roughness_average_rule"]
    )


@pytest.mark.parametrize(
    ("name", "climb"),
    [
        ("fig17-up", 0.75),
        ("fig17-up-known", 0.75),
        ("fig17-down", -0.75),
        ("fig17-down-known", -0.75),
    ],
)
def test_five_risers_of_15_cm_are_climbed(told, name, climb):
    walk = told(name)
    terrain = walk.summary["scenario"]["terrain"]
    assert (terrain["rise"], terrain["count"]) == (0.15, 5)
    feet = walk.log["feet"][..., 2].mean(axis=1)
    assert feet[-1] - feet[0] == pytest.approx(climb, abs=0.06)  # one foot may still be in the air
    assert walk.log["body"][-1, 2] - walk.log["body"][0, 2] == pytest.approx(climb, abs=0.02)


@pytest.mark.parametrize(("lift", "pace"), [(0.05, 0.4), (0.1, 0.8), (0.2, 0.8), (0.1, 1.0)])
def test_the_walked_speed_is_that_of_the_formula(tmp_path, lift, pace):
    gait = (f"gait.lift_up={lift}", f"gait.lift_down={2 * lift}")
    walk = read_walk(
        walk_recipe(
            Recipe("fig16", (*gait, "end={time=60.0, distance=2.0}", "expect={}"), pace),
            tmp_path / "run",
        )
    )
    first, last = walk.row(4), walk.row(4 + 4 * ((len(walk.steps) - 4) // 4))
    speed = (walk.way[last] - walk.way[first]) / ((last - first) * TICK)
    assert speed == pytest.approx(cruise_speed(walk.machine, walk.gait, 0.0), rel=0.01)


def test_the_block_is_found_by_touch_mapped_and_the_walk_ends_in_the_standard_gait(
    told,
):
    walk = told("fig19")
    assert walk.summary["emergent"].get("hit", 0) >= 1
    terrain = walk.terrain
    rows, columns = np.nonzero(terrain["believed_heights"] > 0.05)
    x = terrain["origin"][0] + (columns + 0.5) * terrain["cell"]
    block = walk.summary["scenario"]["terrain"]
    assert ((x > block["at"] - 0.1) & (x < block["at"] + 0.2)).any()  # at its near edge
    feet = walk.log["feet"][..., 2]
    # and it was stood on
    assert feet[walk.log["contact"]].max() == pytest.approx(block["height"], abs=0.005)
    assert walk.log["command"][100, 1] == pytest.approx(0.02)
    assert len(walk.steps) - standard_from(walk) >= 6


def test_every_direction_ends_in_its_own_standard_gait(told):
    walk = told("omni")
    angles = np.unique(np.round(np.degrees(walk.log["command"][:, 0])))
    assert angles.min() <= -150 and angles.max() == 180 and len(angles) == 12
    assert walk.summary["courses_unsettled"] == 0
    # no course lies near it: there s is a millimetre
    assert math.degrees(walk.machine.critical_angle) == pytest.approx(46.5, abs=0.1)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "fig16"])
def test_the_figure_is_drawn_from_its_run_directory(shared, tmp_path, name):
    pytest.importorskip("matplotlib")
    recipe = next(iter(FIGURES[name].walks.values()))
    settings = (
        (*recipe.settings, "end={time=60.0}", "expect={}")
        if name in ("omni", "fig14")
        else recipe.settings
    )
    run_directory = shared.directory(recipe.scenario, *settings)
    lines = draw_figure(name, tmp_path / "figure.svg", run_directory)
    drawn = (tmp_path / "figure.svg").read_text("utf-8")
    assert FIGURES[name].title in drawn and len(drawn) > 20_000
    assert str(tmp_path / "figure.svg") in lines[0]


def test_a_walk_with_foresight_is_drawn_too(tmp_path):
    pytest.importorskip("matplotlib")
    run_directory = walk_recipe(
        Recipe("fig12", ("mode=predictive", "terrain.fraction=0.5", "expect={}")), tmp_path / "run"
    )
    draw_figure("fig12", tmp_path / "figure.svg", run_directory)
    assert (tmp_path / "figure.svg").stat().st_size > 20_000


@pytest.mark.slow
def test_fig_16_is_drawn_from_its_sweep(tmp_path):
    pytest.importorskip("matplotlib")
    draw_figure("fig16", tmp_path / "figure.svg")
    assert "by the formula" in (tmp_path / "figure.svg").read_text("utf-8")


def test_the_same_run_gives_the_same_drawing(tmp_path):
    pytest.importorskip("matplotlib")
    run_directory = walk_recipe(Recipe("fig6a"), tmp_path / "run")
    for out in ("a.svg", "b.svg"):
        draw_figure("fig6a", tmp_path / out, run_directory)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_what_cannot_be_drawn_is_said_in_one_line(tmp_path):
    with pytest.raises(FigureError, match="unknown figure 'fig7'; there are: fig6a"):
        draw_figure("fig7", tmp_path / "figure.svg")
    run_directory = walk_recipe(Recipe("fig6a", ("end={time=20.0}", "expect={}")), tmp_path / "run")
    with pytest.raises(
        FigureError, match="fig13 is drawn from a walk over 'river', the run is one over 'flat'"
    ):
        draw_figure("fig13", tmp_path / "figure.svg", run_directory)
    with pytest.raises(FigureError, match="should end in .svg, .png or .pdf"):
        draw_figure("fig6a", tmp_path / "figure.docx", run_directory)


# the posture to begin in


@pytest.mark.parametrize(
    ("feet", "reason"),
    [
        ("[[0.3, 0.475], [-0.25, 0.475], [-0.5, -0.475], [0.9, -0.475]]", "foot 4 must be within"),
        (
            "[[0.3, 0.475], [-0.25, 0.475], [-0.5, -0.475], [0.5, -0.475], [0.0, 0.5]]",
            "has 4 legs, got 5 feet",
        ),
    ],
)
def test_a_posture_it_cannot_stand_in_is_refused_in_one_line(feet, reason):
    with pytest.raises(ScenarioError, match=reason):
        run_scenario(load_scenario("fig6c", (f"start.feet={feet}", "end={time=1.0}", "expect={}")))
