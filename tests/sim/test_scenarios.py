"""Scenario files, what ``--set`` does to them, and how refusals read."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walking_console.planner.registry import DEFAULT_MODE
from walking_console.planner.robot.model import load_machine
from walking_console.planner.trace.paths import KINDS as TRACE_KINDS
from walking_console.planner.trace.paths import trace_from
from walking_console.planner.types import Command
from walking_console.sim.scenario import (
    TRACES,
    Scenario,
    ScenarioError,
    list_scenarios,
    load_scenario,
    scenario_from,
    scenario_names,
    with_settings,
)
from walking_console.sim.terrain.ground import make_ground

TITAN = load_machine("titan3")
CONTRACT = """
title = "Cross a river as wide as the stride"
robot = "titan3"
planner = "crab"
mode = "predictive"
sensing = "known"
unknown = "flat"
seed = 1

[gait]
duty_factor = 0.75

[terrain]
kind = "river"
width = 0.5

[start]
x = 0.0
y = 0.0
yaw_deg = 0.0

[[drive]]
t = 0.0
crab_angle_deg = 0.0
speed = 0.1
turn_rate_deg_s = 0.0

[end]
time = 120.0

[expect]
distance_min = 3.0
margin_min = -0.001
forbidden_steps_max = 0
emergent_max = 0
falls_max = 0
time_max = 90.0
"""


def refusal(data: Any = None, *changes: str, name: str = "flat") -> str:
    with pytest.raises(ScenarioError) as error:
        scenario_from(data) if data is not None else load_scenario(name, changes)
    assert "\n" not in str(error.value)
    return str(error.value)


def flat(*changes: str) -> Scenario:
    return load_scenario("flat", changes)


# files


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


def test_the_elevation_walk_is_long_hilly_and_takes_three_directions() -> None:
    scenario = load_scenario("dem")
    ground = make_ground(
        scenario.terrain, TITAN, scenario.start_pose, scenario.seed, scenario.span(TITAN)
    )
    x = y = walked = 0.0
    heights, directions = [ground.height_at(x, y)], set()
    while walked < (scenario.end.distance or 0.0):
        entry = [entry for entry in scenario.drive if entry.t <= walked / scenario.drive[0].speed][
            -1
        ]
        angle = math.radians(entry.crab_angle_deg)
        x, y, walked = x + 0.1 * math.cos(angle), y + 0.1 * math.sin(angle), walked + 0.1
        heights.append(ground.height_at(x, y))
        directions.add(entry.crab_angle_deg)
    assert walked >= 15.0 and len(directions) == 3 and max(heights) - min(heights) >= 0.15


def test_scenarios_are_listed_with_their_titles() -> None:
    assert [name for name, _ in list_scenarios()] == list(scenario_names()) and all(
        title for _, title in list_scenarios()
    )


def test_an_empty_scenario_stands_on_flat_ground() -> None:
    scenario = scenario_from({})
    assert (
        scenario.terrain.kind == "flat"
        and scenario.robot == "titan3"
        and not scenario.drive
        and scenario.mode == DEFAULT_MODE
    )
    assert scenario.time_limit == 600.0


@pytest.mark.parametrize("name", scenario_names())
def test_a_dump_is_json_and_loads_back_equal(name: str) -> None:
    scenario = load_scenario(name, ["terrain.difficulty=0.4"])
    again = scenario_from(json.loads(json.dumps(scenario.as_data())), scenario.base)
    assert again == scenario and again.as_data() == scenario.as_data()


def test_integers_serve_as_floats() -> None:
    scenario = scenario_from(
        {"drive": [{"t": 0, "crab_angle_deg": 15, "speed": 1}], "end": {"time": 60}}
    )
    assert scenario.drive[0].speed == 1.0 and isinstance(scenario.drive[0].speed, float)


def test_a_drive_entry_is_a_command_in_radians() -> None:
    entry = flat("drive=[{t=0, crab_angle_deg=90, speed=0.05, turn_rate_deg_s=-18}]").drive[0]
    assert entry.command() == Command(math.pi / 2, 0.05, pytest.approx(-math.pi / 10))  # type: ignore[arg-type]


def test_gait_overrides_leave_the_rest_to_the_machine() -> None:
    gait = flat("gait={lift_up=0.05, smooth=false}").gait_for(TITAN)
    assert (gait.duty_factor, gait.lift_up, gait.lift_down, gait.height, gait.smooth) == (
        0.8,
        0.05,
        0.2,
        0.85,
        False,
    )


@pytest.mark.parametrize(
    ("change", "says"),
    [("gait.height=2.0", "within the legs' reach"), ("gait.lift_up=0.3", "at least lift_up")],
)
def test_a_gait_the_machine_cannot_walk_is_refused(change: str, says: str) -> None:
    with pytest.raises(ScenarioError, match=says):
        flat(change).gait_for(TITAN)


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


# refusals


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    with pytest.raises(ScenarioError, match="unknown scenario 'rivr'; there are: .*flat.*river"):
        load_scenario("rivr")
    assert "unknown terrain kind 'rivr'; there are: flat, slope" in refusal(
        {"terrain": {"kind": "rivr"}}
    )
    assert "unknown key 'sped' in drive.0; there are: t, crab_angle_deg, speed" in refusal(
        {"drive": [{"sped": 1.0}]}
    )
    assert "unknown key 'wide' in terrain; there are: kind" in refusal(
        {"terrain": {"kind": "river", "wide": 1}}
    )
    assert "unknown key 'x' in expect; there are: distance_min" in refusal({"expect": {"x": 1}})
    assert "unknown key 'x' in noise; there are: position" in refusal({"noise": {"x": 1}})
    assert "unknown key 'x' in trace; there are: " in refusal(
        {"planner": "trace", "trace": {"kind": "sine", "x": 1}}
    )
    assert "unknown trace kind 'cirle'; there are: waypoints, line, " in refusal(
        {"planner": "trace", "trace": {"kind": "cirle"}}
    )
    assert "unknown key 'tile'; there are: name, title" in refusal({"tile": "x"})
    assert "'crab' or 'trace', got 'goat'" in refusal({"planner": "goat"})


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, True, "0.1", None, [0.1], -0.1])
def test_numbers_are_numbers(bad: Any) -> None:
    assert "drive.0.speed should be" in refusal({"drive": [{"speed": bad}]})
    assert "terrain.width" in refusal({"terrain": {"kind": "river", "width": bad}})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"seed": 1.0}, "seed should be"),
        ({"seed": -1}, "seed should be"),
        ({"seed": True}, "seed should be"),
        ({"title": 3}, "title should be"),
        ({"drive": 3}, "drive should be"),
        ({"drive": [3]}, "drive.0 should be"),
        ({"terrain": 3}, "terrain should be"),
        ({"terrain": {}}, "terrain needs a kind"),
        ({"end": {"time": 3601}}, "end.time should be less"),
        ({"end": {"time": 0}}, "end.time should be greater"),
        ({"drive": [{"t": 1}, {"t": 1}]}, "drive.1.t must be later than drive.0.t = 1, got 1"),
        ({"drive": [{"t": 5000}]}, "drive.0.t should be less"),
        ({"gait": {"duty_factor": 0.6}}, "at least 0.75"),
        ({"trace": {"kind": "sine"}}, 'needs planner = "trace"'),
        ({"planner": "trace", "trace": {"kind": "sine"}, "drive": [{}]}, "either"),
        ({"planner": "trace", "trace": {"kind": "waypoints"}}, "trace.waypoints is missing"),
        (
            {"planner": "trace", "trace": {"kind": "waypoints", "waypoints": [[0, 0, 0], [1]]}},
            "trace.waypoints.1",
        ),
        ({"terrain": {"kind": "poles", "area": [1, 0, 0, 1]}}, "area must be"),
    ],
)
def test_every_refusal_names_the_place(data: dict[str, Any], says: str) -> None:
    assert says in refusal(data)


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


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(list(Scenario.model_fields)), JSON, max_size=4))
@settings(max_examples=200, deadline=None)
def test_any_data_is_a_scenario_or_refused_in_one_line(data: dict[str, Any]) -> None:
    try:
        scenario_from(data)
    except ScenarioError as error:
        assert "\n" not in str(error)


# --set


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


# how far a course leads


def test_a_straight_course_spans_its_distance() -> None:
    assert flat("end={distance=4.0}").span(TITAN) == pytest.approx((0.0, 4.0, 0.0, 0.0))
    assert flat("end={time=10.0}").span(TITAN) == pytest.approx((0.0, 0.8, 0.0, 0.0))
    assert flat("end={time=10.0}", "start.yaw_deg=90", "start.x=1").span(TITAN) == pytest.approx(
        (1.0, 1.0, 0.0, 0.8)
    )


def test_forward_and_back_span_the_way_forward() -> None:
    """The machine may be slower one way than the other, so the two do not cancel."""
    there_and_back = "drive=[{t=0,speed=0.1},{t=30,speed=0.1,crab_angle_deg=180}]"
    assert flat(there_and_back, "end={time=60}").span(TITAN) == pytest.approx((-3.0, 3.0, 0.0, 0.0))


def test_a_command_beyond_any_gait_does_not_ask_for_a_larger_map() -> None:
    # V (1-β)/β = 0.25 m/s
    assert flat("drive=[{speed=10}]", "end={time=100}").span(TITAN)[1] == pytest.approx(25.0)


ENTRY = st.tuples(
    st.floats(1, 50),
    st.floats(-180, 180),
    st.floats(0, 0.1),
    st.sampled_from([0.0, 0.0, 5.0, -20.0]),
)


@given(
    entries=st.lists(
        st.tuples(
            st.floats(1, 50),
            st.floats(-180, 180),
            st.floats(0, 0.1),
            st.sampled_from([0.0, 0.0, 5.0, -20.0]),
        ),
        min_size=1,
        max_size=4,
    ),
    slow=st.lists(st.floats(0, 1), min_size=4, max_size=4),
)
@settings(max_examples=100, deadline=None)
def test_no_course_leaves_its_span_however_slowly_it_is_walked(
    entries: list[tuple[float, float, float, float]], slow: list[float]
) -> None:
    drive, t = [], 0.0
    for length, angle, speed, turn in entries:
        drive.append({"t": t, "crab_angle_deg": angle, "speed": speed, "turn_rate_deg_s": turn})
        t += length
    x_min, x_max, y_min, y_max = scenario_from({"drive": drive, "end": {"time": t}}).span(TITAN)
    x = y = yaw = 0.0
    for (length, angle, speed, turn), pace in zip(entries, slow, strict=False):
        for _ in range(200):
            dt = length / 200 * pace
            x += math.cos(yaw + math.radians(angle)) * speed * dt
            y += math.sin(yaw + math.radians(angle)) * speed * dt
            yaw += math.radians(turn) * dt
            assert x_min - 0.02 <= x <= x_max + 0.02 and y_min - 0.02 <= y <= y_max + 0.02


TRACE_SPECS = [
    {"kind": "waypoints", "waypoints": [[0, 0, 0], [2, 1, 45], [1, 3], [4, 0, 0]]},
    {"kind": "line", "length": 20, "direction_deg": 30},
    {"kind": "line", "length": 20, "direction_deg": 30, "yaw": "tangent"},
    {"kind": "sideways"},
    {"kind": "circle", "angle_deg": -300},
    {"kind": "sine", "amplitude": -0.6},
    {"kind": "sine", "yaw": "tangent"},
    {"kind": "spiral"},
    {"kind": "spiral", "radius": 0.5, "radius_end": 2.0, "angle_deg": -700},
    {"kind": "turn"},
]


@pytest.mark.parametrize("spec", TRACE_SPECS, ids=str)
def test_no_trace_leaves_its_span(spec: dict[str, Any]) -> None:
    scenario = scenario_from(
        {"planner": "trace", "robot": "hexapod", "start": {"x": 1, "yaw_deg": 40}, "trace": spec}
    )
    assert scenario.trace is not None
    drawn = trace_from(scenario.trace.model_dump(), 0.75, scenario.start_pose)
    x_min, x_max, y_min, y_max = scenario.span()
    assert x_min - 0.01 <= min(drawn.x) and max(drawn.x) <= x_max + 0.01
    assert y_min - 0.01 <= min(drawn.y) and max(drawn.y) <= y_max + 0.01
    assert x_max - x_min < 22.0


def test_every_trace_kind_the_planner_draws_has_a_shape_here() -> None:
    assert set(TRACES) == set(TRACE_KINDS)
