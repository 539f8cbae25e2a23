"""Sitting down, standing up and the standard posture, asked for in the middle of walks, and stopped
in the middle of themselves.
"""

import json
import math
import random

import numpy as np
import pytest

from tests.sweeps.hands import planned_polygon_margin
from walking_console.planner.control.activities import Activity
from walking_console.planner.crab.gait import AGREEMENT, off_standard
from walking_console.planner.types import POSTURES, Command, Mode
from walking_console.sim.perception import disc
from walking_console.sim.requests import Edit, Halt, Push, TakePosture
from walking_console.sim.runs.replay import replay
from walking_console.sim.runs.runner import succeeded
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario, scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

from .telling import assert_always_true, walked

WALK = Command(0.0, 0.1)
HOLD = Command()
THERE = 0.03  # of the stride: a foot within 1 cm of its place stays
SECOND = 50  # ticks
REST = 30  # ticks, the longest a body that sways takes to come to rest
WAY = 0.033  # m it goes on meanwhile at most
RISING = 2.0  # s, the longest a machine takes from sitting to walking
POSING = (Mode.SIT_DOWN, Mode.STAND_UP, Mode.REGROUP)
SIX = ("robot=hexapod", "planner=trace")


def walking(ticks: int, *settings: str, command: Command = WALK) -> Simulation:
    """A machine in the middle of a walk over level ground, or what the settings make of it."""
    console = Simulation(prepare(load_scenario("flat", ("end={time=100.0}", *settings))))
    console.order(command)
    run(console, ticks)
    return console


def run(console: Simulation, ticks: int) -> None:
    for _ in range(ticks):
        console.step()
        assert console.mode not in (Mode.TIPPING, Mode.FALLEN), console.reason
        assert planned_polygon_margin(console) >= -1e-6


def ask(console: Simulation, posture: str, seconds: float = 20.0) -> None:
    """Ask for a posture and wait until it is taken, or refused."""
    console.request(TakePosture(posture))
    console.step()
    for _ in range(round(seconds * SECOND)):
        if not console.walk.posing:
            return
        run(console, 1)
    raise AssertionError(f"still {console.mode.name} after {seconds} s")


def off(console: Simulation) -> float:
    """How far the machine stands from its standard layout, as a share of the stride."""
    walk = console.walk
    return off_standard(walk.run.machine, walk.run.gait, walk.state.crab_angle, walk.stance)


# whole walks


def test_a_walk_with_a_rest_in_it_on_rough_ground(shared):
    walk = shared.walked("postures")
    assert_always_true(walk)
    assert succeeded(walk.summary), walk.summary["expect"]
    modes = {name: number for name, number in walk.summary["modes"].items()}
    order = [
        mode
        for mode in walk.log["mode"][np.flatnonzero(np.diff(walk.log["mode"], prepend=-1))]
        if mode >= modes["sit_down"]
    ]
    told = ("sit_down", "sit", "stand_up", "regroup", "sit_down", "sit", "stand_up")
    assert order == [modes[name] for name in told]
    assert replay(shared.directory("postures"))["equal"]


def test_six_legs_rest_the_same_way(tmp_path):
    walk = walked(tmp_path, "postures", *SIX)
    assert_always_true(walk)
    assert walk.summary["result"] == "completed" and walk.summary["distance"] > 2.5
    assert {"sit", "regroup", "stand_up"} <= {
        name for name, number in walk.summary["modes"].items() if number in walk.log["mode"]
    }
    assert replay(tmp_path)["equal"]


FOOTHOLDS = 'terrain={kind="footholds", fraction=%g, cell=0.05}'
LEVEL = 'terrain={kind="flat"}'


@pytest.mark.parametrize(
    ("mode", "terrain"),
    [
        ("predictive", FOOTHOLDS % 0.7),
        ("predictive", FOOTHOLDS % 0.5),
        ("paper", FOOTHOLDS % 0.7),
        ("paper", LEVEL),
        ("naive", LEVEL),
    ],
)
def test_in_every_mode_and_between_forbidden_cells(tmp_path, mode, terrain):
    walk = walked(tmp_path, "postures", f"mode={mode}", terrain, "expect={}", "seed=11")
    assert_always_true(walk)
    assert (
        walk.summary["modes"]["regroup"] in walk.log["mode"]
        and walk.summary["modes"]["sit"] in walk.log["mode"]
    )


@pytest.mark.parametrize("sensing", ("eye", "none"))
def test_what_it_does_not_know_of_the_ground_does_not_keep_it_from_standing_in_order(
    tmp_path, sensing
):
    walk = walked(tmp_path, "postures", f"sensing={sensing}", "expect={}")
    assert walk.summary["falls"] == 0 and walk.summary["modes"]["regroup"] in walk.log["mode"]
    before_it_walks_on = 32 * SECOND - 2
    assert walk.log["mode"][before_it_walks_on] == walk.summary["modes"]["stand"]


def test_noisy_sensors_keep_it_from_nothing(tmp_path):
    walk = walked(tmp_path, "postures", "noise={position=0.002, posture_deg=0.2}", "expect={}")
    posing = np.isin(walk.log["mode"], [int(mode) for mode in POSING])
    assert walk.summary["falls"] == 0 and walk.log["polygon_margin"][posing].min() >= 0.0
    assert walk.log["mode"][31 * SECOND] == walk.summary["modes"]["stand"]
    assert walk.log["mode"][16 * SECOND] == walk.summary["modes"]["sit"]


# what a posture is


@pytest.mark.parametrize("degrees", (0.0, 30.0, 45.0, 90.0, 150.0, -120.0))
@pytest.mark.parametrize("ticks", (7, 140, 333))
def test_after_the_standard_posture_the_walk_goes_on_as_the_standard_walk_at_once(degrees, ticks):
    course = Command(math.radians(degrees), 0.08)
    console = walking(ticks, command=course)
    ask(console, "standard")
    assert console.mode is Mode.STAND and console.snapshot().posture == "standard"
    assert off(console) < THERE
    console.order(course)
    swings = []
    for _ in range(20 * SECOND):
        console.step()
        assert console.mode not in (Mode.BLOCKED, Mode.FALLEN)
        step = console.walk.executed
        if step is not None:
            swings.append(step.swing)
            machine, gait = console.world.machine, console.world.gait
            away = off_standard(machine, gait, course.crab_angle, step.end)
            assert away <= AGREEMENT, len(swings)
    assert len(swings) >= 4 and console.snapshot().posture == "stand"


def test_the_standard_posture_is_that_of_the_last_course_not_of_the_stick_at_rest():
    console = walking(100, command=Command(math.radians(90), 0.08))
    console.order(Command(math.radians(90), 0.0))
    run(console, 60)
    console.order(HOLD)
    ask(console, "standard")
    assert console.walk.state.crab_angle == pytest.approx(math.pi / 2) and off(console) < THERE
    assert console.walk.stance.quarter_turns == 1


@pytest.mark.parametrize("settings", ((), SIX))
def test_sitting_is_low_standing_is_high_and_neither_moves_a_foot(settings):
    console = walking(100, *settings)
    run_out = console.walk.stance
    console.order(HOLD)
    run(console, SECOND)
    feet = [list(foot) for foot in console.plant.feet]
    ask(console, "sit")
    low = console.plant.body[2]
    assert console.mode is Mode.SIT and run_out.body[2] - low > 0.3
    run(console, 5 * SECOND)
    assert console.plant.body[2] == pytest.approx(low, abs=1e-9)
    ask(console, "stand")
    assert console.mode is Mode.STAND and console.plant.body[2] == pytest.approx(
        console.world.gait.height, abs=1e-6
    )
    assert feet == [list(foot) for foot in console.plant.feet]


def test_from_sitting_into_the_standard_posture_it_stands_up_first():
    console = walking(130)
    ask(console, "sit")
    console.request(TakePosture("standard"))
    seen = []
    for _ in range(10 * SECOND):
        run(console, 1)
        if not seen or seen[-1] is not console.mode:
            seen.append(console.mode)
    assert [mode for mode in seen if mode in POSING] == [Mode.STAND_UP, Mode.REGROUP]
    assert console.mode is Mode.STAND and off(console) < THERE


def test_a_posture_taken_twice_moves_nothing():
    console = walking(50)
    for posture in ("sit", "stand", "standard"):
        ask(console, posture)
        before = console.plant.body.copy(), [list(foot) for foot in console.plant.feet]
        ask(console, posture)
        assert before[0] == pytest.approx(console.plant.body, abs=1e-6)
        assert before[1] == [list(foot) for foot in console.plant.feet]


# changing one's mind


@pytest.mark.parametrize("settings", ((), SIX))
def test_a_command_to_move_stands_a_sitting_machine_up_in_time_and_it_walks(settings):
    console = walking(100, *settings)
    ask(console, "sit")
    x = console.plant.body[0]
    console.order(WALK)
    for _ in range(round(RISING * SECOND)):
        assert console.mode is not Mode.STAND_UP or console.plant.body[0] == pytest.approx(
            x, abs=1e-9
        )
        run(console, 1)
    assert console.plant.body[0] > x + 1e-3, "it walks by now"
    begun = console.distance
    run(console, 10 * SECOND)
    assert console.distance - begun > 0.3


@pytest.mark.parametrize("interrupted", ("sit", "stand"))
@pytest.mark.parametrize("after", (1, 5, 20, 40, 55))
def test_a_command_to_move_in_the_middle_of_sitting_or_standing_raises_it_and_it_walks(
    interrupted, after
):
    console = walking(100)
    if interrupted == "stand":
        ask(console, "sit")
    console.request(TakePosture(interrupted))
    run(console, after + SECOND)  # the foot in the air is set down first
    console.order(WALK)
    run(console, 8 * SECOND)
    assert console.distance > 0.4 and console.mode not in (Mode.BLOCKED, *POSING)
    assert console.plant.body[2] == pytest.approx(0.85, abs=1e-3)


def test_letting_go_while_it_rises_stops_it_at_once_and_the_next_command_raises_the_rest():
    console = walking(100)
    ask(console, "sit")
    console.order(WALK)
    run(console, 20)
    assert console.mode is Mode.STAND_UP
    console.order(HOLD)
    z = console.plant.body[2]
    run(console, 3 * SECOND)
    assert console.plant.body[2] == pytest.approx(z, abs=1e-9) and console.mode is Mode.STAND
    console.order(WALK)
    run(console, 5 * SECOND)
    assert console.plant.body[2] == pytest.approx(0.85, abs=1e-6) and console.walk.steps


def stopped_on_its_way(after: int, *settings: str) -> Simulation:
    """On its way into the standard posture, stopped so many ticks after it was asked for."""
    console = walking(130, *settings)
    console.request(TakePosture("standard"))
    run(console, after)
    console.request(Halt())
    return console


def ticks_on_its_way(*settings: str) -> int:
    """Ticks that it takes into the standard posture."""
    console, ticks = walking(130, *settings), 0
    console.request(TakePosture("standard"))
    console.step()
    while console.walk.posing:
        console.step()
        ticks += 1
    assert ticks > 2 * SECOND
    return ticks


def assert_it_walks_on(console: Simulation) -> None:
    assert console.mode is Mode.STAND and all(console.plant.soles)
    console.order(WALK)
    way = console.distance
    run(console, 10 * SECOND)
    assert console.distance - way > 0.2, console.reason


@pytest.mark.parametrize("settings", ((), SIX))
def test_stopped_on_its_way_the_body_stops_at_once_and_all_feet_are_down_within_a_second(
    settings,
):
    printed = (*settings, "gait.body=straight")
    for after in range(1, ticks_on_its_way(*printed), 11):
        console = stopped_on_its_way(after, *printed)
        body = console.plant.body.copy()
        for _ in range(SECOND):
            run(console, 1)
            assert console.plant.body == pytest.approx(body, abs=1e-9), after
        assert_it_walks_on(console)


@pytest.mark.parametrize("settings", ((), SIX))
def test_stopped_on_its_way_a_swaying_body_rests_in_time_and_all_feet_are_down_within_a_second(
    settings,
):
    swayed = (*settings, "gait.body=sway")
    for after in range(1, ticks_on_its_way(*swayed), 11):
        console = stopped_on_its_way(after, *swayed)
        begun = console.plant.body[:2].copy()
        run(console, REST)
        body = console.plant.body.copy()
        assert math.dist(begun, body[:2]) <= WAY, after
        for _ in range(SECOND - REST):
            run(console, 1)
            assert console.plant.body == pytest.approx(body, abs=1e-9), after
        assert_it_walks_on(console)


def test_a_command_to_move_while_the_feet_are_being_put_in_order_is_followed():
    for after in range(60, 240, 23):
        console = walking(130)
        console.request(TakePosture("standard"))
        run(console, after)
        console.order(Command(math.radians(20), 0.08))
        way = console.distance
        run(console, 10 * SECOND)
        assert console.distance - way > 0.3, (after, console.reason)


def test_the_newest_posture_wins():
    console = walking(130)
    console.request(TakePosture("standard"))
    run(console, 100)
    assert console.mode is Mode.REGROUP
    ask(console, "sit")
    assert console.mode is Mode.SIT
    console.request(TakePosture("stand"))
    run(console, 10)
    ask(console, "sit")
    assert console.mode is Mode.SIT


def test_a_posture_asked_for_by_a_held_command_ends_that_command():
    console = walking(60)
    console.order(WALK, ttl_ticks=500)
    console.request(TakePosture("sit"))
    run(console, 4 * SECOND)
    assert console.command == HOLD and console.mode is Mode.SIT


@pytest.mark.parametrize("settings", ((), (FOOTHOLDS % 0.7,), (*SIX, FOOTHOLDS % 0.3)))
@pytest.mark.parametrize("seed", (1, 2))
def test_a_hand_that_cannot_make_up_its_mind_gets_a_machine_neither_down_nor_stuck(settings, seed):
    console, hand, until, low = walking(1, *settings, command=HOLD), random.Random(seed), 0, False
    for tick in range(40 * SECOND):
        if tick >= until:
            until = tick + hand.randint(3, 150)
            console.request(
                TakePosture(hand.choice(POSTURES))
            ) if hand.random() < 0.5 else console.request(Halt())
            if hand.random() < 0.5:
                console.order(
                    Command(
                        hand.uniform(-3.0, 3.0),
                        hand.choice((0.05, 0.1)),
                        hand.choice((0.0, 0.0, 0.1)),
                    )
                )
        run(console, 1)
        low = low or console.mode is Mode.SIT
        assert console.mode is not Mode.BLOCKED, console.reason
    assert low and console.refused == "" and console.walk.steps_begun > 5


# when it cannot


def without_ground(edit: str) -> Simulation:
    """A machine that wants to walk where there is nothing to step on but where it stands."""
    console = walking(1)
    ground, feet = console.perception.ground, console.plant.feet
    rows, columns, _ = disc(ground, 0.0, 0.0, 1.6)
    cells = [(int(row), int(column)) for row, column in zip(rows, columns, strict=True)]
    far = [
        cell
        for cell in cells
        if all(math.dist(ground.centre(*cell), foot[:2]) > 0.1 for foot in feet)
    ]
    console.request(Edit(edit, tuple(far)))
    console.order(WALK)
    for _ in range(30 * SECOND):
        console.step()
    assert console.mode is Mode.BLOCKED and console.refused == ""
    return console


def test_blocked_it_still_sits_down_and_stands_up():
    console = without_ground("forbid")
    ask(console, "sit")
    assert console.mode is Mode.SIT
    ask(console, "stand")
    assert console.mode is Mode.STAND


def test_with_a_foot_in_the_air_over_nothing_it_refuses_and_says_why():
    console = without_ground("dig")
    assert console.walk.activity is Activity.HOVER
    ask(console, "sit")
    assert console.mode is Mode.BLOCKED and "a foot is in the air" in console.refused


def test_a_fallen_machine_refuses_and_says_why():
    console = walking(5)
    console.order(HOLD)
    console.request(Push(0.0, 3000.0, 60))
    for _ in range(200):
        console.step()
    console.request(TakePosture("stand"))
    console.step()
    assert console.refused == "the machine has fallen over" and not console.walk.posing


def test_an_unknown_posture_is_refused_and_changes_nothing():
    console = walking(60)
    console.request(TakePosture("lie"))
    console.step()
    assert "unknown posture 'lie'; there are: sit, stand, standard" in console.refused
    assert console.command == WALK


def test_a_hole_nobody_knew_of_under_a_foot_on_its_way_is_felt_and_the_feet_still_come_into_order():
    console = walking(130, 'sensing="none"')
    console.request(TakePosture("standard"))
    while not (console.mode is Mode.REGROUP and console.walk.plan.swing):
        run(console, 1)
    landing = console.walk.plan.landing
    row, column = console.perception.ground.cell_at(landing[0], landing[1])
    reach = math.ceil(0.05 / console.perception.ground.cell)
    console.request(
        Edit(
            "dig",
            tuple(
                (row + k, column + m)
                for k in range(-reach, reach + 1)
                for m in range(-reach, reach + 1)
            ),
        )
    )
    for _ in range(40 * SECOND):
        run(console, 1)
        if not console.walk.posing:
            break
    assert console.walk.contacts.counts.get("no ground", 0) >= 1
    assert console.mode is Mode.STAND and all(console.plant.soles), console.reason
    off_place = [math.dist(foot[:2], landing[:2]) for foot in console.plant.feet]
    assert min(off_place) > 0.04, "no foot stands in the hole"


def test_pushed_aside_while_its_feet_are_put_in_order_it_begins_again_from_there():
    console = walking(130)
    console.request(TakePosture("standard"))
    run(console, 100)
    console.request(Push(900.0, 0.0, 8))
    for _ in range(20 * SECOND):
        console.step()
        assert console.mode is not Mode.FALLEN
        if not console.walk.posing:
            break
    assert console.mode is Mode.STAND and off(console) < 0.05


# from scripts


def test_a_timeline_that_moves_in_a_posture_is_refused_in_one_line():
    for entry in ({"posture": "sit", "speed": 0.1}, {"posture": "stand", "turn_rate_deg_s": 5.0}):
        with pytest.raises(ScenarioError, match=r"drive\.0: posture = .* needs speed = 0"):
            scenario_from({"drive": [entry]}, None)
    with pytest.raises(
        ScenarioError, match=r"drive\.0\.posture should be 'sit', 'stand' or 'standard', got 'lie'"
    ):
        scenario_from({"drive": [{"posture": "lie"}]}, None)


def test_a_timeline_that_holds_in_the_middle_of_a_posture_stops_it_and_replays(tmp_path):
    drive = (
        'drive=[{t=0.0, speed=0.1}, {t=2.6, posture="standard"}, {t=4.0},'
        ' {t=5.0, posture="sit"}, {t=5.5}, {t=7.0, speed=0.1},'
        '{t=12.0, posture="stand"}]'
    )
    walk = walked(tmp_path, "flat", drive, "end={time=14.0}", "expect={}")
    assert_always_true(walk)
    inputs = [json.loads(line) for line in (tmp_path / "inputs.jsonl").read_text().splitlines()]
    assert [entry["input"] for entry in inputs if entry["input"] != "command"] == [
        "pose",
        "halt",
        "pose",
        "halt",
        "pose",
    ]
    heights = walk.log["body"][:, 2]
    assert 0.6 < heights[round(6.8 * SECOND)] < 0.84 and heights[-1] == pytest.approx(0.85)
    assert replay(tmp_path)["equal"]
