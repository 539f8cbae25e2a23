"""A walk on a wide map: its window goes along, and what was found out stays."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from walking_console.planner.control.touch_memory import Felt
from walking_console.planner.terrain.grid import crests_of
from walking_console.sim.requests import Edit
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.surroundings import first_window, reach_of
from walking_console.sim.terrain.ground import GroundError
from walking_console.sim.terrain.wide_map import TILE, WideMap
from walking_console.sim.world import prepare, true_forbidden

# 64 million cells
LARGE = "{kind='rough', amplitude=0.03, map_size=[200.0, 200.0]}"
SMALL = "{kind='rough', amplitude=0.03, map_size=[30.0, 30.0]}"


def walk(*settings: str, terrain: str = LARGE) -> Simulation:
    simulation = Simulation(load_scenario("rough", (f"terrain={terrain}", *settings, "expect={}")))
    simulation.drive(0.0, 0.15)
    return simulation


def moves(simulation: Simulation, seconds: float) -> Iterator[Simulation]:
    """After every move of the window."""
    before = simulation.perception.ground.corner
    for _ in range(round(seconds / 0.02)):
        simulation.step()
        if simulation.perception.ground.corner != before:
            before = simulation.perception.ground.corner
            yield simulation


@pytest.mark.parametrize("sensing", ["known", "eye", "none"])
def test_on_200_by_200_metres_it_walks_as_far_as_on_30(sensing: str) -> None:
    far = walk(f"sensing={sensing}")
    assert far.perception.ground.whole_shape == (8000, 8000)
    assert far.perception.ground.heights.size < 400_000
    near = walk(f"sensing={sensing}", terrain=SMALL)
    assert near.perception.wide is None
    far.run(20.0)
    near.run(20.0)
    assert far.distance == pytest.approx(near.distance, abs=0.05) and far.distance > 1.5
    assert far.walk.contacts.counts == near.walk.contacts.counts


def test_the_window_goes_along_and_holds_the_true_ground_about_the_machine() -> None:
    simulation = walk()
    reach = reach_of(simulation.world.scenario, simulation.world.machine)
    moved = 0
    for _ in moves(simulation, 45.0):
        moved += 1
        ground = simulation.perception.ground
        x, y = simulation.plant.body[:2]
        x_min, x_max, y_min, y_max = ground.bounds
        assert min(x - x_min, x_max - x, y - y_min, y_max - y) >= reach
        assert ground.whole is not None
        assert np.array_equal(ground.whole.read(*ground.cells), ground.heights)
        inner = slice(30, -30), slice(30, -30)
        forbidden = true_forbidden(ground, simulation.world.machine)
        truth = simulation.perception.true_forbidden
        assert np.array_equal(forbidden[inner], truth[inner])
        belief = simulation.perception.belief
        assert belief.heights is ground.heights and belief.origin == ground.origin
        again = belief.crests.copy()
        del belief.__dict__["crests"]
        assert np.array_equal(belief.crests[inner], again[inner])
    assert moved >= 2


def test_no_tile_is_left_to_be_worked_out_when_the_window_moves() -> None:
    simulation = walk()
    wide = simulation.perception.wide
    assert wide is not None
    worked_out = []
    real = wide.tiles.work_out

    def counted(place):
        worked_out.append(simulation.tick_count)
        return real(place)

    wide.tiles.work_out = counted  # type: ignore[method-assign]
    for _ in moves(simulation, 30.0):
        pass
    assert len(worked_out) > 50 and len(set(worked_out)) == len(worked_out)  # one in a tick


def test_what_feet_have_felt_and_an_operator_has_marked_is_there_when_it_comes_back() -> None:
    simulation = walk()
    perception = simulation.perception
    x, y = simulation.plant.body[:2]
    at = perception.belief.cell_at(x - 3.0, y + 2.0)
    assert at is not None
    row, column = at
    perception.learn(Felt({at}, {(row + 9, column): 0.4}))
    corner_row, corner_column = perception.ground.corner
    marked = (corner_row + row, corner_column + column + 9)
    perception.edit(Edit("forbid", (marked,)))
    home = perception.ground.cells
    wide = perception.wide
    assert wide is not None
    away = (home[0], slice(home[1].start + 16 * TILE, home[1].stop + 16 * TILE))
    perception._go_on_to(away, wide)
    assert not (perception.belief.forbidden & ~perception.true_forbidden).any()
    perception._go_on_to(home, wide)
    assert perception.belief.forbidden[row, column]
    assert not perception.true_forbidden[row, column]
    assert perception.belief.heights[row + 9, column] == 0.4 > perception.ground.heights[row + 9][0]
    assert perception.true_forbidden[row, column + 9]


def test_what_the_eye_has_seen_is_there_when_it_comes_back() -> None:
    simulation = walk("sensing=eye")
    simulation.run(3.0)
    perception = simulation.perception
    mapper = perception.mapper
    wide = perception.wide
    assert mapper is not None and wide is not None
    believed = mapper.publish()
    home = perception.ground.cells
    beside = (home[0], slice(home[1].start + 4 * TILE, home[1].stop + 4 * TILE))
    perception._go_on_to(beside, wide)
    shared = slice(0, home[1].stop - home[1].start - 4 * TILE)
    now = mapper.publish()
    assert np.array_equal(now.known[:, shared], believed.known[:, 4 * TILE :])
    assert np.array_equal(now.crests, crests_of(now.heights, 2))
    known = now.known[:, shared]
    assert np.array_equal(now.heights[:, shared][known], believed.heights[:, 4 * TILE :][known])
    assert np.array_equal(now.forbidden[:, shared], believed.forbidden[:, 4 * TILE :])
    far = (home[0], slice(home[1].start + 40 * TILE, home[1].stop + 40 * TILE))
    perception._go_on_to(far, wide)
    assert not mapper.publish().known.any()
    perception._go_on_to(home, wide)
    back = mapper.publish()
    assert np.array_equal(back.known, believed.known)
    assert np.array_equal(back.heights[back.known], believed.heights[back.known])
    assert np.array_equal(back.forbidden, believed.forbidden)


def test_an_edit_is_in_the_window_or_waits_beyond_it() -> None:
    simulation = walk()
    perception = simulation.perception
    row, column = perception.ground.corner
    near, far = (row + 40, column + 50), (7999, 7999)
    simulation.request(Edit("raise", (near, far), 0.5))
    before = perception.ground.heights[40, 50]
    revision = perception.revision
    simulation.serve_requests()
    ground = perception.ground
    assert ground.heights[40, 50] == pytest.approx(before + 0.5)
    assert perception.belief.heights[40, 50] == ground.heights[40, 50]
    assert perception.true_forbidden[40, 50] and perception.revision > revision
    assert ground.whole is not None
    assert ground.whole.read(slice(7999, 8000), slice(7999, 8000)) > 0.4
    simulation.request(Edit("dig", ((8000, 0),)))
    simulation.serve_requests()
    assert "within 8000 rows and 8000 columns" in simulation.refused


def test_ground_gives_way_beyond_the_window_too() -> None:
    patch = "gives_way=[{x=[-50.0, 50.0], y=[-50.0, 50.0], sinks=0.05}]"
    terrain = LARGE.replace("}", f", {patch}}}").replace("amplitude=0.03", "amplitude=0.0")
    simulation = walk(terrain=terrain)
    simulation.step()
    ground = simulation.perception.ground
    assert ground.whole is not None
    assert (ground.heights == np.float32(-0.05)).all()
    heights = ground.whole.read(slice(0, 8000, 100), slice(0, 8000, 100))
    assert np.count_nonzero(heights) == 40 * 40


def test_a_window_that_cannot_be_held_is_refused_in_words() -> None:
    fine = WideMap((8000, 8000), 0.005, (0.0, 0.0), lambda rows, columns: np.zeros((1, 1)))
    with pytest.raises(GroundError, match="take larger cells or a smaller map"):
        first_window(fine, 20.0, 20.0, 7.0)


def test_the_reach_grows_with_the_machine_and_what_its_eye_sees() -> None:
    scenario = load_scenario("rough", ("sensing=eye", "eye={range=15.0}"))
    assert reach_of(scenario, scenario.machine()) > 15.0
    titan = load_scenario("rough")
    assert 5.0 < reach_of(titan, titan.machine()) < 8.0


def test_a_wide_map_is_made_without_being_held() -> None:
    world = prepare(load_scenario("rough", (f"terrain={LARGE}",)))
    assert world.tiles is not None and math.isclose(world.ground.whole_bounds[0], -100.0)
    whole = world.ground.whole
    assert whole is not None and not whole.changed
