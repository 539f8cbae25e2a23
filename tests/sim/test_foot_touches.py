"""When the map is told where feet stand."""

from walking_console.planner.types import Blocked, Reason
from walking_console.sim.foot_touches import FootTouches, touch
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation


def by_touch() -> Simulation:
    return Simulation(load_scenario("flat", ("sensing=none", "expect={}")))


def test_the_map_is_told_as_a_step_begins_and_not_again_in_it() -> None:
    simulation = by_touch()
    touches = FootTouches()
    simulation.drive(speed=0.05)
    told = []
    for _ in range(200):
        simulation.step()
        if touches.count_now(simulation.walk, simulation.plant.sense()):
            told.append(simulation.walk.steps_begun)
    assert told == list(range(1, simulation.walk.steps_begun + 1)) and len(told) > 1


def test_the_map_is_told_once_where_a_walker_stands_without_a_step_to_go_on_with() -> None:
    simulation = by_touch()
    walk, touches = simulation.walk, FootTouches()
    sensing = simulation.plant.sense()
    assert touches.count_now(walk, sensing) and not touches.count_now(walk, sensing)
    walk.state.blocked = Blocked(Reason.NO_PLACE, 0)
    hangs = sensing._replace(soles=(False, *sensing.soles[1:]))
    assert not touches.count_now(walk, hangs)
    assert touches.count_now(walk, sensing) and not touches.count_now(walk, sensing)


def test_feet_say_how_high_the_ground_is_under_and_around_them() -> None:
    simulation = by_touch()
    mapper = simulation.perception.mapper
    assert mapper is not None
    sensing = simulation.plant.sense()
    x, y, z, roll, pitch, yaw = sensing.body
    touch(mapper, sensing._replace(body=(x, y, z + 0.2, roll, pitch, yaw)))
    ground = mapper.publish()
    foot_x, foot_y, _ = simulation.walk.stance.feet[0]
    assert abs(ground.height_at(foot_x, foot_y) - 0.2) < 1e-9
    assert abs(ground.height_at(foot_x + 0.3, foot_y) - 0.2) < 1e-9
