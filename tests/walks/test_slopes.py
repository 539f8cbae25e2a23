"""Slopes up to 25 degrees: strides fitted to them, and a body that is level or follows the
ground.
"""

import math

import numpy as np
import pytest

from walking_console.planner.geometry.transforms import attitude_of
from walking_console.planner.motion.body_tilt import LEVEL
from walking_console.planner.types import Command, Mode
from walking_console.sim.requests import Edit, Follow, Push, TakePosture, input_from
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.runs.replay import replay
from walking_console.sim.runs.runner import run_scenario
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

SPEED = 0.08  # m/s
LOWEST = -0.001  # m of margin
# m a standing foot may be out of its control reach: early touch, and the lean that changes within a
# step; under a body that leans and sways as far as legs reach
OUT = 0.03
# rad: what a foot on the next cell, two centimetres off, tilts the body by until Level C has
# levelled it
UNEVEN = 0.001
FORWARD = Command(0.0, SPEED)
HOLD = Command()


def ran(scenario, folder):
    folder.mkdir()
    return run_scenario(scenario, folder)


def on_slope(degrees, course, attitude="level", **more):
    """A machine that faces ``course`` degrees to the left of the way up."""
    terrain = {"kind": "slope", "angle_deg": degrees, "heading_deg": -course}
    drive = [{"t": 0.0, "crab_angle_deg": 0.0, "speed": SPEED}]
    return scenario_from(
        {
            "name": "slope",
            "attitude": attitude,
            "terrain": terrain,
            "drive": drive,
            "end": {"distance": 6.0},
            **more,
        }
    )


class Hill:
    """A console on a slope, watched in every tick."""

    def __init__(self, degrees, course, attitude="level"):
        self.console = Simulation(prepare(on_slope(degrees, course, attitude)))
        self.recorder = Recorder(self.console)
        self.out = self.off = self.tilt = 0.0
        self.leant = False

    def tick(self, ticks=1):
        console, plant, walk = self.console, self.console.plant, self.console.walk
        for _ in range(ticks):
            console.step()
            self.recorder.note()
            legs = console.world.machine.legs
            for leg in plant.carrying:
                for value, (low, high) in zip(
                    plant.sense().feet_b[leg], (legs[leg].x, legs[leg].y, legs[leg].z), strict=True
                ):
                    self.out = max(self.out, low - value, value - high)
            self.leant = self.leant or walk.run.tracker.leans
            roll, pitch = attitude_of(walk.run.tracker.lean_at(walk.run.t), plant.body[5])
            self.off = max(self.off, abs(plant.body[3] - roll), abs(plant.body[4] - pitch))
            self.tilt = max(self.tilt, abs(plant.body[3]), abs(plant.body[4]))

    def walk(self, steps, command=FORWARD):
        console = self.console
        console.order(command)
        end = console.walk.steps_begun + steps
        while console.walk.steps_begun < end and console.plant.state == "standing":
            self.tick()
            assert not (console.walk.blocked and console.walk.stands), console.reason
            assert console.tick_count < 20_000

    def is_well(self):
        assert self.console.plant.state == "standing"
        assert (
            self.recorder.margin_min >= LOWEST
            and self.recorder.forbidden_steps == 0
            and self.recorder.falls == 0
        )
        reach = self.console.world.machine.overreach[0] if self.leant else OUT
        assert self.out <= reach and not self.console.walk.contacts.counts


@pytest.mark.parametrize("course", range(0, 360, 45))
def test_a_slope_of_15_degrees_is_walked_in_full_strides_in_every_direction(course):
    hill = Hill(15, course)
    hill.walk(13)
    hill.is_well()
    assert hill.console.distance > 11 * 0.156 and hill.tilt < UNEVEN


STEEPER = [
    (20, 30),
    (20, 135),
    (20, 225),
    (20, 300),
    (25, 0),
    (25, 45),
    (25, 90),
    (25, 180),
    (25, 250),
]


@pytest.mark.parametrize(("degrees", "course"), STEEPER)
def test_steeper_slopes_are_walked_level_with_shortened_strides(degrees, course):
    hill = Hill(degrees, course)
    hill.walk(13)
    hill.is_well()
    assert hill.console.distance > 0.5 and hill.tilt < UNEVEN
    # the standard walk of smaller boxes, no scramble
    assert all(step["planned_margin_min"] >= 0.008 for step in hill.recorder.steps)


@pytest.mark.parametrize(
    ("degrees", "course"), [(10, 0), (10, 90), (12, 215), (15, 45), (15, 270), (25, 45)]
)
def test_a_body_that_follows_the_ground_leans_up_the_slope(degrees, course):
    hill = Hill(degrees, course, "ground")
    hill.walk(18)
    hill.is_well()
    up = math.radians(-course)
    gx, gy = hill.console.walk.stance.lean
    steep = math.tan(math.radians(degrees))
    assert 0.15 * steep <= math.hypot(gx, gy) <= steep + 0.015
    assert math.cos(math.atan2(gy, gx) - up) > 0.99
    assert hill.off < UNEVEN  # Level C has it as the plan does, in every tick
    # aslant on 25 degrees, swayed into its first supports: 0.59 m; straight 0.72 m
    assert hill.console.distance > (0.58 if degrees == 25 else 0.6)


@pytest.mark.parametrize("course", [111, 249])
def test_a_lean_that_would_stand_on_an_edge_is_given_up(course):
    """On 25 degrees the way into a lean leads through strides so short that only steps without any
    margin are left.
    """
    hill = Hill(25, course, "ground")
    hill.walk(12)
    hill.is_well()
    assert hill.console.distance > 0.2


def test_across_a_slope_of_10_degrees_the_body_follows_it_nearly_all_the_way():
    hill = Hill(10, 90, "ground")
    hill.walk(16)
    assert (
        math.degrees(abs(hill.console.plant.body[3])) > 7.5
        and abs(hill.console.plant.body[4]) < 0.02
    )
    hill.is_well()


def test_the_body_stays_as_it_leans_when_it_is_stopped_and_goes_on_from_there():
    for ticks in (40, 63, 90, 117):
        hill = Hill(10, 0, "ground")
        hill.walk(6)
        hill.tick(ticks)
        hill.console.order(HOLD)
        hill.tick(100)
        lean = hill.console.walk.stance.lean
        assert hill.console.mode is Mode.STAND and lean != LEVEL and all(hill.console.plant.soles)
        assert hill.console.plant.body[4] == pytest.approx(attitude_of(lean, 0.0)[1], abs=1e-6)
        hill.walk(5)
        hill.is_well()


def test_the_operator_chooses_while_it_walks():
    hill = Hill(10, 90)
    hill.walk(3)
    assert hill.tilt < 1e-9 and hill.console.snapshot().attitude == "level"
    hill.console.request(Follow("ground"))
    hill.walk(8)
    assert hill.console.snapshot().attitude == "ground" and abs(hill.console.plant.body[3]) > 0.1
    hill.console.request(Follow("level"))
    hill.walk(12)
    assert abs(hill.console.plant.body[3]) < 1e-9 and hill.console.walk.stance.lean == LEVEL
    hill.is_well()


def test_a_leaning_machine_levels_before_it_sits_down():
    hill = Hill(10, 0, "ground")
    hill.walk(6)
    hill.console.request(TakePosture("sit"))
    hill.tick(600)
    assert hill.console.mode is Mode.SIT, hill.console.reason
    assert abs(hill.console.plant.body[4]) < 1e-6 and hill.console.walk.stance.lean == LEVEL


def test_it_turns_on_a_slope_it_leans_with():
    hill = Hill(8, 0, "ground")
    hill.walk(14, Command(0.0, 0.05, math.radians(3.0)))
    hill.is_well()
    assert abs(hill.console.plant.body[5]) > 0.2 and hill.tilt > 0.03


def test_a_hole_that_nobody_knew_of_is_met_leaning():
    hill = Hill(10, 0, "ground")
    hill.walk(8)
    before = dict(hill.console.walk.contacts.counts)
    hill.console.perception.mapper = None
    x, y, _ = (hill.console.walk.ready or hill.console.walk.plan).landing
    belief = hill.console.perception.belief
    row, column = belief.cell_at(x, y)
    cells = tuple((r, c) for r in range(row - 2, row + 3) for c in range(column - 2, column + 3))
    hill.console.request(Edit("dig", cells))
    hill.tick()
    hill.console.perception.belief = belief  # the map still shows what was there
    hill.walk(4)
    assert hill.console.walk.contacts.counts.get("no ground", 0) > before.get("no ground", 0)
    assert hill.console.plant.state == "standing" and hill.recorder.margin_min >= LOWEST
    assert hill.console.walk.stance.lean != LEVEL


def test_a_push_does_not_leave_it_askew():
    hill = Hill(10, 0, "ground")
    hill.walk(8)
    hill.console.request(Push(0.0, 80.0, 20))
    hill.walk(6)
    assert hill.console.plant.state == "standing"
    roll, pitch = attitude_of(hill.console.walk.stance.lean, hill.console.plant.body[5])
    assert hill.console.plant.body[4] == pytest.approx(pitch, abs=0.02) and hill.console.plant.body[
        3
    ] == pytest.approx(roll, abs=1e-3)


def test_noise_in_the_posture_sensor_does_not_make_it_fall(tmp_path):
    scenario = on_slope(
        10, 90, "ground", noise={"posture_deg": 0.2, "position": 0.0005}, end={"time": 30.0}
    )
    summary = ran(scenario, tmp_path / "noisy")
    assert summary["falls"] == 0 and summary["distance"] > 1.0


def test_a_walk_that_leans_is_the_same_every_time_and_replays(tmp_path):
    scenario = on_slope(12, 30, "ground", end={"time": 25.0})
    run = ran(scenario, tmp_path / "run")
    assert run["scenario"]["attitude"] == "ground"
    assert replay(tmp_path / "run")["equal"], "walked again, some tick was another"


def test_a_change_of_attitude_is_recorded_and_replayed():
    hill = Hill(10, 90)
    hill.walk(2)
    hill.console.request(Follow("ground"))
    hill.walk(3)
    given = [(record["tick"], input_from(record)) for record in hill.recorder.inputs]
    assert any(isinstance(one, Follow) for _, one in given)
    again = Simulation(prepare(on_slope(10, 90)))
    recorder = Recorder(again)
    for tick in range(hill.console.tick_count):
        for _, one in (entry for entry in given if entry[0] == tick):
            again.order(one) if isinstance(one, Command) else again.request(one)
        again.step()
        recorder.note()
    assert recorder.state_hash == hill.recorder.state_hash
    with pytest.raises(ValueError, match="there are: level, ground"):
        input_from({"input": "attitude", "attitude": "askew"})


@pytest.mark.parametrize("name", ["rough", "stairs-up"])
def test_uneven_ground_is_walked_by_a_body_that_follows_it(name):
    summary = run_scenario(load_scenario(name, ['attitude="ground"']))
    assert summary["result"] == "completed" and summary["falls"] == 0
    assert summary["forbidden_steps"] == 0 and summary["margin_min"] >= LOWEST


@pytest.mark.parametrize("more", [{"mode": "paper"}, {"mode": "naive"}, {"planner": "trace"}])
def test_planners_that_walk_level_refuse_to_follow_the_ground(more):
    with pytest.raises(
        ScenarioError, match='attitude = "ground" needs planner = "crab" and mode = "predictive"'
    ):
        scenario_from({"name": "x", "attitude": "ground", **more})
    hill = Simulation(prepare(scenario_from({"name": "x", **more})))
    hill.request(Follow("ground"))
    hill.step()
    assert "predictive" in hill.refused and hill.snapshot().attitude == "level"


def test_level_ground_is_walked_alike_whatever_the_attitude(tmp_path):
    flat = {"name": "flat", "drive": [{"t": 0.0, "speed": SPEED}], "end": {"time": 12.0}}
    level, ground = (
        ran(scenario_from({**flat, "attitude": attitude}), tmp_path / attitude)
        for attitude in ("level", "ground")
    )
    assert level["state_hash"] == ground["state_hash"]
    assert np.isfinite(level["margin_min"])
