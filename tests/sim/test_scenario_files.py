"""Scenario files, and what ``--set`` does to them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sim.scenario_words import CONTRACT, TITAN, flat, refusal
from walking_console.planner.robot.model import load_machine
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import (
    list_scenarios,
    load_scenario,
    scenario_from,
    scenario_names,
    with_settings,
)
from walking_console.sim.terrain.ground import make_ground


def test_the_contracts_example_loads(tmp_path: Path) -> None:
    (tmp_path / "cross.toml").write_text(CONTRACT)
    scenario = load_scenario(str(tmp_path / "cross.toml"))
    assert (
        scenario.name == "cross"
        and scenario.mode == "predictive"
        and scenario.expect.time_max == 90.0
    )
    assert scenario.gait_for(TITAN).duty_factor == 0.75


@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_loads_has_a_title_and_its_ground_can_be_made(name: str) -> None:
    scenario = load_scenario(name)
    machine = load_machine(scenario.robot, scenario.base)
    assert scenario.name == name and scenario.title and "\n" not in scenario.title
    assert scenario.end.time or scenario.end.distance
    assert scenario.expect.model_dump(exclude_none=True)
    ground = make_ground(
        scenario.terrain,
        machine,
        scenario.start_pose,
        scenario.seed,
        scenario.span(machine),
        scenario.base,
    )
    x_min, x_max, y_min, y_max = scenario.span(machine)
    assert ground.bounds[0] <= x_min - 2 and ground.bounds[1] >= x_max + 2
    assert ground.bounds[2] <= y_min - 2 and ground.bounds[3] >= y_max + 2


def test_scenarios_are_listed_with_their_titles() -> None:
    assert [name for name, _ in list_scenarios()] == list(scenario_names()) and all(
        title for _, title in list_scenarios()
    )


def test_paths_are_relative_to_the_scenario_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "deep").mkdir()
    np.save(tmp_path / "deep" / "dem.npy", np.zeros((80, 80)))
    (tmp_path / "deep" / "mine.toml").write_text(
        'robot = "../robot.toml"\n[terrain]\nfile = "dem.npy"\ncell = 0.05\n'
    )
    monkeypatch.chdir(tmp_path)
    scenario = load_scenario("deep/mine.toml")
    assert scenario.terrain.kind == "file" and Path(scenario.robot).is_absolute()
    assert make_ground(scenario.terrain, TITAN, base=scenario.base).heights.shape == (80, 80)
    again = scenario_from(scenario.as_data(), tmp_path)
    assert make_ground(again.terrain, TITAN, base=again.base).heights.shape == (80, 80)


@pytest.mark.parametrize(
    "data", [{"terrain": {"file": "/etc/passwd"}}, {"robot": "/elsewhere/robot.toml"}]
)
def test_a_scenario_that_came_without_a_file_cannot_name_files(data: dict[str, Any]) -> None:
    assert "cannot name files" in refusal(data)


@pytest.mark.parametrize(
    "text",
    [
        "title = ",
        "[drive",
        "a = 1\na = 2",
        "x = [1,\x00]",
        "x = " + "[" * 5000,
        "x = " + "1" * 5000,
    ],
)
def test_malformed_files_are_refused_in_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ScenarioError, match="is not valid TOML") as error:
        load_scenario(str(path))
    assert "\n" not in str(error.value)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="cannot read"):
        load_scenario(str(tmp_path / "bad.toml"))


def test_settings_apply_from_left_to_right() -> None:
    assert flat("seed=3", "seed=4").seed == 4


def test_a_value_that_is_not_toml_is_a_string() -> None:
    assert flat("mode=paper", "title=Hello there").title == "Hello there"
    assert flat('title="quoted"').title == "quoted"
    assert flat("title=").title == ""
    assert flat("title=2024-01-01").title == "2024-01-01"


def test_numeric_path_parts_index_arrays() -> None:
    assert flat("drive.0.speed=0.05").drive[0].speed == 0.05
    assert "drive is an array of 1; index it with 0 to 0, not '1'" in refusal(
        None, "drive.1.speed=0.05"
    )
    assert "not '-1'" in refusal(None, "drive.-1.speed=0.05")
    assert "not 'x'" in refusal(None, "drive.x.speed=0.05")


def test_a_table_or_array_replaces_the_whole_one() -> None:
    assert flat("end={time=60.0}").end.model_dump() == {"time": 60.0, "distance": None}
    assert flat("expect={}").expect.model_dump(exclude_none=True) == {}
    (entry,) = flat("drive=[{t=0.0,crab_angle_deg=15.0,speed=0.08}]").drive
    assert (entry.crab_angle_deg, entry.speed) == (15.0, 0.08)


def test_a_missing_table_is_made() -> None:
    assert flat("gait.duty_factor=0.75", "start.x=1").gait.duty_factor == 0.75


def test_a_new_course_replaces_the_old_one() -> None:
    scenario = flat("planner=trace", 'trace={kind="circle", radius=1}')
    assert scenario.trace is not None and scenario.trace.kind == "circle" and not scenario.drive


@pytest.mark.parametrize(
    "change",
    [
        "drive.0.speed=nan",
        "drive.0.speed=" + "9" * 400,
        "seed=" + "9" * 5000,
        "drive.0.speed=inf",
        "drive.0.speed=true",
        "foo=1",
        "end.tim=3",
        "start={z=1}",
    ],
)
def test_settings_are_checked_like_files(change: str) -> None:
    assert refusal(None, change)


@pytest.mark.parametrize("change", ["seed", "=3", ".seed=3", "drive..t=3", "title.x=3", "seed.0=1"])
def test_settings_that_lead_nowhere_are_refused(change: str) -> None:
    assert "--set" in refusal(None, change) or "should be" in refusal(None, change)


def test_a_setting_cannot_smuggle_in_other_keys() -> None:
    assert with_settings({}, ["title=1\nseed = 3"]) == {"title": "1\nseed = 3"}


def test_settings_leave_what_they_were_given_alone() -> None:
    data = {"drive": [{"speed": 0.1}]}
    with_settings(data, ["drive.0.speed=0.2"])
    assert data == {"drive": [{"speed": 0.1}]}


@given(
    st.lists(
        st.text(max_size=20)
        | st.from_regex(r"(drive|end|start|terrain)(\.[a-z0-9]{1,3}){0,2}=[\[\]{}0-9a-z.=,]{0,8}"),
        max_size=3,
    )
)
@settings(max_examples=200, deadline=None)
def test_any_settings_make_a_scenario_or_are_refused(changes: list[str]) -> None:
    try:
        flat(*changes)
    except ScenarioError as error:
        assert "\n" not in str(error)


def test_the_seed_option_is_a_setting_too() -> None:
    assert load_scenario("flat", ["seed=3"], seed=9).seed == 9
