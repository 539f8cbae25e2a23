"""Whole walks along traces, on paper: every step of them keeps every promise."""

import math

import numpy as np
import pytest

from tests.planner.trace.rollout import faults_of, field_of, gait_of, walk
from walking_console.planner.initial_stance import Placement, square_stance
from walking_console.planner.protocols import run_to_completion
from walking_console.planner.robot.model import load_machine, machine_from
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.periodic_gaits import GAITS
from walking_console.planner.trace.planner import TraceWalk, plan_step
from walking_console.planner.types import Blocked, Command, Phase, Reason, Stance, StepPlan

HEXAPOD = load_machine("hexapod")
EVERYWHERE = field_of(1.0, 0, HEXAPOD, (-8, 8, -8, 8))
SPARSE = field_of(0.10, 0, HEXAPOD, (-8, 8, -8, 8))
WALKING = Command(speed=0.3)


@pytest.mark.parametrize("seed", range(4))
def test_eight_metres_of_the_sine_trace_on_four_percent(seed: int) -> None:
    walked = walk(
        HEXAPOD,
        field_of(0.04, seed, HEXAPOD),
        WALKING,
        trace_for({"kind": "sine"}, HEXAPOD),
        until=8.0,
    )
    assert walked.faults == []
    assert walked.stance.course >= 8.0


@pytest.mark.parametrize("terrain", [EVERYWHERE, SPARSE], ids=["open", "10 %"])
@pytest.mark.parametrize(
    "spec",
    [
        {"kind": "turn"},
        {"kind": "turn", "angle_deg": -360},
        {"kind": "sideways"},
        {"kind": "sideways", "direction_deg": -90},
        {"kind": "line", "direction_deg": 180},
        {"kind": "circle"},
        {"kind": "spiral", "angle_deg": 270},
        {"kind": "waypoints", "waypoints": [[0, 0, 0], [2, 1, 45], [3, 3, 90]], "yaw": "fixed"},
        {"kind": "sine", "yaw": "tangent", "distance": 5},
    ],
    ids=lambda spec: "-".join(str(value) for value in spec.values())[:24],
)
def test_every_kind_of_trace_is_walked_to_its_end(
    spec: dict[str, object], terrain: TerrainMap
) -> None:
    trace = trace_for(spec, HEXAPOD)
    walked = walk(HEXAPOD, terrain, WALKING, trace)
    assert walked.faults == []
    assert walked.arrived
    x, y, yaw = trace.pose(math.inf)
    assert walked.stance.body[:2] == pytest.approx((x, y), abs=0.03)
    assert walked.stance.body[3] == pytest.approx(yaw, abs=0.03)


def test_turning_on_the_spot_the_centre_of_gravity_stays_within_5_cm() -> None:
    for terrain in (EVERYWHERE, SPARSE):
        walked = walk(HEXAPOD, terrain, WALKING, trace_for({"kind": "turn"}, HEXAPOD))
        assert max(np.hypot(plan.body[:, 0], plan.body[:, 1]).max() for plan in walked.steps) < 0.05


@pytest.mark.parametrize("crab_deg", [0, 45, 90, 135, 180, -135, -90, -45])
def test_the_joystick_drives_any_way(crab_deg: int) -> None:
    command = Command(math.radians(crab_deg), 0.2)
    walked = walk(HEXAPOD, EVERYWHERE, command, until=3.0)
    assert walked.faults == [] and walked.blocked is None
    x, y = walked.stance.body[:2]
    assert math.atan2(y, x) == pytest.approx(
        math.atan2(math.sin(command.crab_angle), math.cos(command.crab_angle)), abs=0.01
    ) or (abs(crab_deg) == 180 and x < -2.9)


def test_the_joystick_may_change_its_mind_at_every_step() -> None:
    rng = np.random.default_rng(7)
    think, now = (
        TraceWalk(HEXAPOD, gait_of(HEXAPOD)),
        square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0)),
    )
    for _ in range(40):
        command = Command(
            float(rng.uniform(-math.pi, math.pi)),
            float(rng.uniform(0.05, 0.4)),
            float(rng.uniform(-0.4, 0.4)),
        )
        answer = finished(think, now, command, SPARSE)
        assert isinstance(answer, StepPlan), answer
        assert faults_of(answer, now, HEXAPOD, SPARSE) == []
        now = answer.end


def finished(
    think: TraceWalk, stance: Stance, command: Command, terrain: TerrainMap
) -> StepPlan | Blocked:
    return run_to_completion(think(stance, command, terrain))


@pytest.mark.parametrize("name", GAITS)
def test_rigid_gaits_walk_open_ground_in_their_order(name: str) -> None:
    walked = walk(
        HEXAPOD,
        EVERYWHERE,
        WALKING,
        trace_for({"kind": "line", "length": 4}, HEXAPOD),
        rigid=GAITS[name],
    )
    assert walked.faults == [] and walked.arrived
    groups = [frozenset(group) for group in GAITS[name].groups]
    moved = [frozenset(plan.swing) for plan in walked.steps if plan.swing]
    first = groups.index(moved[0])
    assert moved == [groups[(first + n) % len(groups)] for n in range(len(moved))]


def test_where_the_rigid_tripod_is_stuck_the_free_gait_walks_on() -> None:
    terrain, trace = field_of(0.03, 1, HEXAPOD), trace_for({"kind": "sine"}, HEXAPOD)
    rigid = walk(HEXAPOD, terrain, WALKING, trace, until=8.0, rigid=GAITS["tripod"])
    free = walk(HEXAPOD, terrain, WALKING, trace, until=8.0)
    assert rigid.blocked is not None and rigid.stance.course < 8.0
    assert free.stance.course >= 8.0


@pytest.mark.parametrize("robot", ["phantomx", "titan3"])
def test_other_machines_walk_traces_too(robot: str) -> None:
    machine = load_machine(robot)
    terrain = TerrainMap(
        np.zeros((480, 480)),
        np.zeros((480, 480), dtype=bool),
        0.025,
        (-6.0, -6.0),
        machine.foot_radius,
    )
    for spec in ({"kind": "line", "length": 2}, {"kind": "turn", "angle_deg": 180}):
        walked = walk(machine, terrain, Command(speed=0.1), trace_for(spec, machine))
        assert walked.faults == [] and walked.arrived


def test_an_eight_legged_machine_walks_too() -> None:
    legs = [
        {
            "name": f"leg {n}",
            "x": [x - 0.2, x + 0.2],
            "y": sorted((side * 0.3, side * 0.7)),
            "z": [-0.7, -0.3],
        }
        for n, (x, side) in enumerate(
            [(0.6, 1), (0.2, 1), (-0.2, 1), (-0.6, 1), (-0.6, -1), (-0.2, -1), (0.2, -1), (0.6, -1)]
        )
    ]
    machine = machine_from(
        {
            "name": "octopod",
            "title": "eight legs",
            "source": "a test",
            "mass": 60.0,
            "torso": [1.6, 0.5, 0.2],
            "height": 0.5,
            "foot_radius": 0.03,
            "friction": 0.8,
            "yaw_length": 0.7,
            "duty_factor": 0.75,
            "lift_up": 0.1,
            "lift_down": 0.2,
            "speed": [1.0, 1.0, 0.8],
            "overreach": [0.05, 0.05, 0.15],
            "legs": legs,
        }
    )
    walked = walk(
        machine,
        field_of(0.3, 0, machine, (-3, 7, -3, 3)),
        Command(speed=0.2),
        trace_for({"kind": "line", "length": 3}, machine),
    )
    assert walked.faults == [] and walked.arrived


def test_the_walker_is_slower_where_footholds_are_far_apart() -> None:
    trace = trace_for({"kind": "line", "length": 6}, HEXAPOD)
    commanded = Command(speed=0.15)
    easy = walk(HEXAPOD, field_of(1.0, 0, HEXAPOD), commanded, trace)
    hard = walk(HEXAPOD, field_of(0.03, 4, HEXAPOD), commanded, trace)
    assert easy.arrived and hard.arrived
    assert hard.seconds > easy.seconds


def test_a_slower_command_makes_a_slower_step_over_the_same_ground() -> None:
    stance = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    trace = trace_for({"kind": "line"}, HEXAPOD)
    fast, slow = (
        plan_step(stance, Command(speed=v), EVERYWHERE, HEXAPOD, gait_of(HEXAPOD), trace=trace)
        for v in (0.4, 0.02)
    )
    assert isinstance(fast, StepPlan) and isinstance(slow, StepPlan)
    assert fast.end == slow.end or np.allclose(fast.end.feet, slow.end.feet)
    assert slow.speed == pytest.approx(0.02, rel=1e-6) and fast.speed > slow.speed
    assert slow.speed_max == pytest.approx(fast.speed_max)


def test_at_the_end_of_the_trace_it_says_so() -> None:
    walked = walk(HEXAPOD, EVERYWHERE, WALKING, trace_for({"kind": "line", "length": 1}, HEXAPOD))
    assert walked.blocked is not None and walked.blocked.reason is Reason.ARRIVED


def test_on_an_island_it_stops_at_the_edge_and_says_why() -> None:
    forbidden = EVERYWHERE.forbidden.copy()
    forbidden[:, round((2.5 + 8) / 0.05) :] = True
    island = TerrainMap(np.where(forbidden, np.nan, 0.0), forbidden, 0.05, EVERYWHERE.origin)
    walked = walk(HEXAPOD, island, WALKING, trace_for({"kind": "line"}, HEXAPOD))
    assert walked.faults == []
    assert walked.blocked is not None and "beyond s =" in walked.blocked.text
    assert walked.stance.lifted == () and max(foot[0] for foot in walked.stance.feet) < 2.5
    # it slows down towards the end of what it knows
    assert walked.steps[-1].speed <= walked.steps[0].speed


def test_when_the_map_grows_it_walks_on() -> None:
    """K's dialogue with the eye: the horizon ends where the map does."""
    forbidden = EVERYWHERE.forbidden.copy()
    forbidden[:, round((2.0 + 8) / 0.05) :] = True
    seen = TerrainMap(np.where(forbidden, np.nan, 0.0), forbidden, 0.05, EVERYWHERE.origin)
    trace = trace_for({"kind": "line"}, HEXAPOD)
    think = TraceWalk(HEXAPOD, gait_of(HEXAPOD), trace)
    now = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    for terrain in (seen, EVERYWHERE):
        while isinstance(answer := finished(think, now, WALKING, terrain), StepPlan):
            now = answer.end
    assert answer.reason is Reason.ARRIVED


def test_it_leaves_a_posture_that_is_not_its_own() -> None:
    """Feet set down anywhere by a stop in mid-step are footholds like any other."""
    stance = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    moved = Stance((0.07, -0.03, stance.body[2], 0.02), stance.feet, course=0.05)
    answer = plan_step(
        moved,
        WALKING,
        SPARSE,
        HEXAPOD,
        gait_of(HEXAPOD),
        trace=trace_for({"kind": "line"}, HEXAPOD),
    )
    assert isinstance(answer, StepPlan)
    assert faults_of(answer, moved, HEXAPOD, SPARSE) == []


def test_feet_set_down_beyond_their_rectangles_are_walked_away_from() -> None:
    """A stop in mid-step may use the mechanical reach: such a foot stays until it is lifted, and
    gets no farther out.
    """
    stance = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    # fore feet 3 cm behind, hind feet 3 cm beyond
    astray = Stance((0.33, 0.02, stance.body[2], 0.0), stance.feet, course=0.33)
    walked = walk(
        HEXAPOD, SPARSE, WALKING, trace_for({"kind": "line"}, HEXAPOD), stance=astray, until=2.0
    )
    assert walked.blocked is None and walked.stance.course >= 2.0
    assert all("out of reach" in fault for fault in walked.faults)
    # every foot has stepped by then
    assert max(int(fault.split()[1].rstrip(":")) for fault in walked.faults) <= 6
    for plan in walked.steps:
        for leg in set(range(6)) - set(plan.swing):
            seen = plan.feet[:, leg, 0] - plan.body[:, 0]
            assert (
                HEXAPOD.legs[leg].x[0] - 0.031 <= seen.min()
                and seen.max() <= HEXAPOD.legs[leg].x[1] + 1e-6
            )


@pytest.mark.parametrize("margin", (0.0, 0.004))
def test_a_posture_less_stable_than_the_margin_is_left_without_becoming_less_so(
    margin: float,
) -> None:
    stance = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    # the edge the body is about to cross
    (ax, ay), (bx, by) = stance.feet[4][:2], stance.feet[0][:2]
    x = (ax + bx) / 2 - margin * math.hypot(bx - ax, by - ay) / (by - ay)
    leaning = Stance((x, 0.0, stance.body[2], 0.0), stance.feet, lifted=(1, 3, 5), course=x)
    walked = walk(
        HEXAPOD, SPARSE, WALKING, trace_for({"kind": "line"}, HEXAPOD), stance=leaning, until=2.0
    )
    assert [fault for fault in walked.faults if "margin" in fault] == []
    assert walked.blocked is None and walked.stance.course >= 2.0


def test_a_machine_that_does_not_stand_has_no_step() -> None:
    stance = square_stance(HEXAPOD, gait_of(HEXAPOD), Placement((0.0, 0.0, 0.0), lambda x, y: 0.0))
    toppling = Stance((0.36, 0.0, stance.body[2], 0.0), stance.feet, lifted=(1, 3, 5), course=0.36)
    answer = plan_step(
        toppling,
        WALKING,
        SPARSE,
        HEXAPOD,
        gait_of(HEXAPOD),
        trace=trace_for({"kind": "line"}, HEXAPOD),
    )
    assert isinstance(answer, Blocked) and "stable" in answer.text


def test_over_rough_ground_the_body_follows_and_feet_clear_the_crests() -> None:
    rng = np.random.default_rng(3)
    rows = columns = 320
    heights = rng.uniform(-0.06, 0.06, (rows, columns))
    terrain = TerrainMap(heights, np.zeros((rows, columns), dtype=bool), 0.05, (-8.0, -8.0))
    walked = walk(HEXAPOD, terrain, WALKING, trace_for({"kind": "sine", "distance": 4}, HEXAPOD))
    assert walked.arrived
    assert walked.faults == []


def ground_with(things: list[tuple[float, float, float, float]], height: float) -> TerrainMap:
    """Open level ground with boxes x1, x2, y1, y2 of this height on it, which nothing may step
    on.
    """
    rows = columns = 320
    heights, forbidden = np.zeros((rows, columns)), np.zeros((rows, columns), dtype=bool)
    for x1, x2, y1, y2 in things:
        box = (
            slice(round((y1 + 8) / 0.05), round((y2 + 8) / 0.05)),
            slice(round((x1 + 8) / 0.05), round((x2 + 8) / 0.05)),
        )
        heights[box], forbidden[box] = height, True
    return TerrainMap(heights, forbidden, 0.05, (-8.0, -8.0), HEXAPOD.foot_radius)


def deepest(plan: StepPlan, terrain: TerrainMap) -> float:
    """How far a foot in the air goes below the ground under it, m (the last knot aims below on
    purpose).
    """
    most = 0.0
    for k, phase in enumerate(plan.phases):
        if phase in (Phase.UP, Phase.RETURN):
            for part in np.linspace(0.0, 1.0, 9):
                feet = plan.feet[k] + part * (plan.feet[k + 1] - plan.feet[k])
                most = max(
                    most, *(terrain.height_at(*feet[leg][:2]) - feet[leg][2] for leg in plan.swing)
                )
    return most


def test_no_foot_is_carried_through_what_is_too_tall_to_lift_it_over() -> None:
    """K's third truncation: posts of 0.6 m stand in the legs' way; feet pass beside them."""
    posts = [
        (x, x + 0.1, side * 0.5, side * 0.5 + 0.1) for x, side in ((1.3, 1), (1.9, -1), (2.4, 1))
    ]
    terrain = ground_with(posts, 0.6)
    walked = walk(HEXAPOD, terrain, WALKING, trace_for({"kind": "line", "length": 4}, HEXAPOD))
    assert walked.faults == [] and walked.arrived
    assert max(deepest(plan, terrain) for plan in walked.steps) <= 1e-9


def test_what_the_torso_would_run_into_is_the_end_of_the_way_and_it_says_so() -> None:
    walked = walk(
        HEXAPOD,
        ground_with([(3.0, 3.1, -0.1, 0.1)], 0.6),
        WALKING,
        trace_for({"kind": "line", "length": 4}, HEXAPOD),
    )
    assert walked.faults == []
    assert walked.blocked is not None and "torso" in walked.blocked.text
    assert 1.5 < walked.stance.body[0] + HEXAPOD.torso[0] / 2 <= 3.0
