"""A recorded walk is read as it was walked, and what cannot be read is said."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from walking_console.sim.runs.run_files import RunError
from walking_console.web.figures.run_data import (
    Recipe,
    RecordedWalk,
    degrees,
    read_walk,
    walk_recipe,
)


def test_rows_of_switching_points_are_the_last_of_their_steps(walk: RecordedWalk) -> None:
    assert walk.row(0) == 0
    assert [walk.row(k) for k in range(1, 4)] == [step["tick"] - 1 for step in walk.steps[:3]]


def test_a_stance_has_the_feet_where_they_stood(walk: RecordedWalk) -> None:
    stance = walk.stance(2)
    row = walk.row(2)
    assert np.array(stance.feet) == pytest.approx(walk.log["feet"][row])
    x, y, z, _, _, yaw = walk.body[row]
    assert stance.body == pytest.approx((x, y, z, yaw))


def test_a_foot_swung_comes_down_where_the_step_says(walk: RecordedWalk) -> None:
    for k, step in enumerate(walk.steps, 1):
        leg = walk.swing(k)
        assert step["swing"] == [leg + 1]
        assert walk.stance(k).feet[leg][:2] == pytest.approx(step["landing"][:2], abs=1e-3)


def test_a_shift_on_four_legs_swings_none(walk: RecordedWalk) -> None:
    steps = [{**walk.steps[0], "swing": []}]
    shifted = RecordedWalk(
        walk.summary, walk.log, steps, walk.ground, walk.believed, walk.machine, walk.gait
    )
    assert shifted.swing(1) == -1


def test_the_way_grows_to_the_distance_walked_and_what_the_body_swayed(walk: RecordedWalk) -> None:
    assert np.all(np.diff(walk.way) >= 0.0)
    distance = walk.summary["distance"]
    assert walk.summary["body"] == "sway"
    assert 1.02 * distance < walk.way[-1] < 1.06 * distance


def test_holes_have_no_height(walk: RecordedWalk) -> None:
    rows, columns = np.nonzero(np.isnan(walk.ground.heights))
    x = walk.ground.origin[0] + (columns[:5] + 0.5) * walk.ground.cell
    y = walk.ground.origin[1] + (rows[:5] + 0.5) * walk.ground.cell
    assert np.isnan(walk.height_at(x, y)).all()
    landings = np.array([step["landing"] for step in walk.steps])
    assert walk.height_at(landings[:, 0], landings[:, 1]) == pytest.approx(landings[:, 2])


def test_one_direction_is_one_command(walk: RecordedWalk) -> None:
    [(row, angle)] = walk.commands()
    assert row == 0 and math.degrees(angle) == pytest.approx(28.0)


def test_the_extent_holds_every_foot(walk: RecordedWalk) -> None:
    x1, x2, y1, y2 = walk.extent
    feet = walk.log["feet"]
    assert (x1, x2) == pytest.approx((feet[..., 0].min(), feet[..., 0].max()))
    assert (y1, y2) == pytest.approx((feet[..., 1].min(), feet[..., 1].max()))


def test_the_posture_of_a_step_is_in_the_frame_of_its_standard_walk(walk: RecordedWalk) -> None:
    standard, posture = walk.posture(1)
    for leg, foot in zip(standard.body_leg, posture.feet, strict=True):
        assert posture.absolute(*foot) == pytest.approx(walk.stance(0).feet[leg][:2])


def test_a_recipe_may_lift_feet_at_another_speed(tmp_path: Path) -> None:
    recipe = Recipe("fig16", ("end={time=1.0}", "expect={}"), lift_speed=0.33)
    directory = walk_recipe(recipe, tmp_path / "run")
    assert json.loads((directory / "run.json").read_text())["robot"]["speed"][2] == 0.33


def test_a_run_without_steps_is_refused(run_directory: Path, tmp_path: Path) -> None:
    broken = tmp_path / "run"
    shutil.copytree(run_directory, broken)
    (broken / "steps.jsonl").write_text("")
    with pytest.raises(RunError, match="has no steps to draw"):
        read_walk(broken)


def test_a_step_beyond_the_last_tick_is_refused(run_directory: Path, tmp_path: Path) -> None:
    broken = tmp_path / "run"
    shutil.copytree(run_directory, broken)
    lines = (broken / "steps.jsonl").read_text().splitlines()
    last = {**json.loads(lines[-1]), "tick": 10**6}
    (broken / "steps.jsonl").write_text("\n".join([*lines[:-1], json.dumps(last)]) + "\n")
    with pytest.raises(RunError, match="steps at ticks it has not"):
        read_walk(broken)


def test_angles_are_told_in_whole_degrees() -> None:
    assert degrees(math.radians(28.4)) == "28°"
