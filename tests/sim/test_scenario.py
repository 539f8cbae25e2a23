"""A scenario as a whole: its machine, its span, its dump."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sim.scenario_words import TITAN, flat
from walking_console.planner.registry import DEFAULT_MODE
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import (
    load_scenario,
    scenario_from,
    scenario_names,
)
from walking_console.sim.terrain.ground import make_ground


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
