"""What every planner must do, ours and one that is not: the contract of ``Planner``, run."""

import inspect
import math

import numpy as np
import pytest

from walking_console.planner import registry
from walking_console.planner.initial_stance import Placement
from walking_console.planner.protocols import (
    HeightMap,
    Planner,
    PlannerError,
    PlannerSetup,
    run_to_completion,
    without_pause,
)
from walking_console.planner.robot.model import load_machine
from walking_console.planner.terrain.map import TerrainMap
from walking_console.planner.types import Blocked, Command, Gait, Stance, StepPlan
from walking_console.sim.kinematic.plant import KinematicPlant
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation, prepare

CHOICES = [
    ("crab", "predictive", "titan3"),
    ("crab", "paper", "titan3"),
    ("crab", "naive", "titan3"),
    ("trace", "", "hexapod"),
    ("toy", "", "hexapod"),
]
ON = Command(0.0, 0.05)
TICKS = 500


def level(forbidden_everywhere=False):
    forbidden = np.full((240, 240), forbidden_everywhere)
    heights = np.where(forbidden, np.nan, 0.0)
    return TerrainMap(heights, forbidden, 0.05, (-6.0, -6.0))


@pytest.fixture(params=CHOICES, ids=lambda choice: " ".join(choice[:2]).strip())
def choice(request, toy):
    name, mode, robot = request.param
    machine = load_machine(robot)
    gait = Gait(machine.duty_factor, machine.lift_up, machine.lift_down, machine.height)
    place = Placement((0.0, 0.0, 0.0), lambda x, y: 0.0)
    stance = registry.initial_stance(name, mode, machine, gait, place)
    return name, stance, PlannerSetup(machine, gait, mode)


def made(choice) -> tuple[Planner, Stance]:
    name, stance, setup = choice
    return registry.make_planner(name, setup), stance


def walked(planner: Planner, stance: Stance, terrain: TerrainMap, steps: int) -> list[StepPlan]:
    plans = []
    for _ in range(steps):
        plan = run_to_completion(planner.plan(stance, planner.heed(ON), terrain))
        assert isinstance(plan, StepPlan), plan
        plans.append(plan)
        stance = plan.end
    return plans


def test_a_job_is_a_generator_that_ends_with_a_step(choice):
    planner, stance = made(choice)
    job = planner.plan(stance, ON, level())
    assert inspect.isgenerator(job)
    plan = run_to_completion(job)
    assert isinstance(plan, StepPlan)
    assert plan.times[0] == 0.0 and np.all(np.diff(plan.times) >= 0.0)
    assert plan.body.shape == (plan.times.size, 4)
    assert plan.feet.shape == (plan.times.size, len(stance.feet), 3)
    assert len(plan.phases) == plan.times.size - 1


def test_a_step_begins_where_the_last_one_ended_and_cannot_be_written_to(choice):
    planner, stance = made(choice)
    plans = walked(planner, stance, level(), 6)
    ends = [stance, *(plan.end for plan in plans)]
    for plan, before in zip(plans, ends, strict=False):
        assert tuple(plan.body[0]) == pytest.approx(before.body, abs=1e-9)
        assert not plan.body.flags.writeable and not plan.feet.flags.writeable
    assert plans[-1].end.body[0] > 0.05


def test_legs_that_do_not_swing_do_not_move(choice):
    planner, stance = made(choice)
    for plan in walked(planner, stance, level(), 4):
        for leg in set(range(len(stance.feet))) - set(plan.swing):
            assert np.ptp(plan.feet[:, leg], axis=0).max() == 0.0


def test_the_same_history_gives_the_same_steps_bit_for_bit(choice):
    one, two = (walked(*made(choice), level(), 4) for _ in range(2))
    for a, b in zip(one, two, strict=True):
        assert a.end == b.end and np.array_equal(a.times, b.times)
        assert np.array_equal(a.body, b.body) and np.array_equal(a.feet, b.feet)


def test_ground_without_a_foothold_is_an_answer_and_not_an_error(choice):
    planner, stance = made(choice)
    nowhere = level(forbidden_everywhere=True)
    answer = run_to_completion(planner.plan(stance, ON, nowhere))
    if isinstance(answer, StepPlan):  # the body may still be shifted over the feet as they stand
        assert answer.swing == ()
        answer = run_to_completion(planner.plan(answer.end, ON, nowhere))
    assert isinstance(answer, Blocked) and answer.text


def test_no_command_is_made_faster_by_the_planner(choice):
    planner, _ = made(choice)
    for command in (Command(), ON, Command(1.0, 0.2), Command(0.0, 0.0, 0.1)):
        heeded = planner.heed(command)
        assert heeded.speed <= command.speed and heeded.holds == command.holds


def test_it_does_what_it_declares(choice):
    planner, stance = made(choice)
    declared = planner.capabilities
    assert declared is registry.capabilities(choice[0], choice[2].mode)
    assert not declared.leg_counts or len(stance.feet) in declared.leg_counts
    walked(planner, stance, level(), 1)
    assert (planner.preview(stance, None) is not None) == declared.gives_preview
    if declared.may_lean:
        planner.take_attitude("ground")
        assert planner.attitude == "ground"
    else:
        with pytest.raises(PlannerError):
            planner.take_attitude("ground")
    planner.take_attitude("level")
    assert planner.attitude == "level"
    with pytest.raises(PlannerError, match="there are: level, ground"):
        planner.take_attitude("askew")


def test_it_walks_in_a_simulation(choice):
    name, _, setup = choice
    settings = [f"robot={setup.machine.name}", f"planner={name}"]
    scenario = load_scenario("flat", settings + [f"mode={setup.mode}"] * bool(setup.mode))
    simulation = Simulation(prepare(scenario))
    simulation.order(ON)
    for _ in range(TICKS):
        simulation.step()
    assert simulation.reason == "" and simulation.plant.state == "standing"
    gone = simulation.plant.body[0] - simulation.world.stance.body[0]
    assert 0.5 * ON.speed * TICKS * 0.02 < gone <= 1.1 * ON.speed * TICKS * 0.02
    assert simulation.walk.steps_begun >= 2


def test_a_planner_of_one_module_needs_no_more_than_two_methods(toy):
    own = [name for name in vars(toy.ToyPlanner) if not name.startswith("_")]
    assert own == ["capabilities", "plan"]


def test_a_planner_that_plans_nothing_is_refused_where_it_is_written():
    with pytest.raises(TypeError, match="Nothing must define plan_step or plan"):

        class Nothing(Planner):
            pass


def test_a_planner_may_be_a_plain_call_or_a_job_and_is_both():
    class Call(Planner):
        def plan_step(self, stance, command, terrain):
            return Blocked.saying("called")

    class Job(Planner):
        def plan(self, stance, command, terrain):
            yield
            return Blocked.saying("done")

    asked = (Stance((0.0, 0.0, 0.7, 0.0), ()), ON, level())
    assert (
        run_to_completion(Call().plan(*asked))
        == Call().plan_step(*asked)
        == Blocked.saying("called")
    )
    assert (
        run_to_completion(Job().plan(*asked)) == Job().plan_step(*asked) == Blocked.saying("done")
    )


def test_the_ground_and_what_is_believed_of_it_are_both_height_maps():
    world = prepare(load_scenario("holes"))
    maps: list[HeightMap] = [world.ground, world.belief]
    for height_map in maps:
        x, y = height_map.origin
        assert height_map.cell_at(x + height_map.cell / 2, y + height_map.cell / 2) == (0, 0)
        assert height_map.cell_at(x - 1.0, y) is None
        assert math.isnan(height_map.height_at(x - 1.0, y))
        row, column = np.argwhere(np.isfinite(height_map.heights))[0]
        at = (x + (column + 0.5) * height_map.cell, y + (row + 0.5) * height_map.cell)
        assert height_map.height_at(*at) == height_map.heights[row, column]


def test_the_kinematic_plant_says_how_exact_it_is():
    world = prepare(load_scenario("flat"))
    plant = KinematicPlant(world.machine, world.ground, world.stance)
    assert plant.tolerances.held_back == 0.01 and plant.tolerances.same_place == 1e-6


def test_what_answers_at_once_is_a_job_that_does_not_pause():
    assert run_to_completion(without_pause(max)(3, 5, key=abs)) == 5
    assert list(without_pause(max)(3, 5)) == []
