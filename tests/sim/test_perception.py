"""What becomes of the truth on its way to the planner."""

import math

import numpy as np
import pytest

from walking_console.planner.control.touch_memory import Felt
from walking_console.sim.perception import SET_DOWN, Perception, disc
from walking_console.sim.requests import Edit
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare


def perception_of(*settings: str, name: str = "flat") -> Perception:
    world = prepare(load_scenario(name, (*settings, "expect={}")))
    x, y, z, yaw = world.stance.body
    return Perception(world, [x, y, z, 0.0, 0.0, yaw])


def test_known_ground_is_believed_as_it_is_without_a_map_of_its_own() -> None:
    perception = perception_of()
    assert perception.mapper is None and perception.range_sensor is None
    assert perception.belief is perception.world.belief


def test_by_touch_only_the_ground_under_the_soles_is_known_at_first() -> None:
    perception = perception_of("sensing=none")
    known = perception.belief.known
    assert perception.range_sensor is None
    for x, y, _ in perception.world.stance.feet:
        assert known[perception.belief.cell_at(x, y)]
    assert known.sum() < 500


def test_with_an_eye_all_around_the_start_is_known_at_first() -> None:
    perception = perception_of("sensing=eye", name="rough")
    x, y = perception.world.stance.body[:2]
    rows, columns, heights = disc(perception.ground, x, y, SET_DOWN)
    assert perception.belief.known[rows, columns].all()
    off = np.abs(perception.belief.heights[rows, columns] - heights)
    assert np.median(off) < 0.005


def test_a_disc_holds_the_cells_whose_centres_are_within_its_radius() -> None:
    ground = perception_of().ground
    rows, columns, heights = disc(ground, 0.3, -0.2, 0.5)
    for row, column in zip(rows, columns, strict=True):
        x, y = ground.centre(int(row), int(column))
        assert np.hypot(x - 0.3, y + 0.2) <= 0.5
    assert rows.size == pytest.approx(np.pi * 0.25 / ground.cell**2, rel=0.05)
    assert heights.size == rows.size


def test_what_a_foot_has_learnt_stays_forbidden_until_it_is_cleared() -> None:
    for sensing in ("known", "none"):
        perception = perception_of(f"sensing={sensing}")
        perception.learn(Felt({(100, 100)}))
        assert perception.belief.forbidden[100, 100]
        perception.edit(Edit("dig", ((5, 5),)))
        assert perception.belief.forbidden[100, 100]
        perception.edit(Edit("clear", ((100, 100),)))
        assert not perception.belief.forbidden[100, 100]


def test_what_a_foot_has_felt_raises_the_map_and_stays_when_other_cells_are_edited() -> None:
    for sensing in ("known", "none"):
        perception = perception_of(f"sensing={sensing}")
        perception.learn(Felt(heights={(100, 100): 0.4, (90, 90): math.nan}))
        perception.edit(Edit("forbid", ((5, 5),)))
        heights = perception.belief.heights
        assert heights[100, 100] == 0.4 and math.isnan(heights[90, 90])
        perception.learn(Felt(heights={(100, 100): 0.3}))
        assert perception.belief.heights[100, 100] == 0.4


def test_a_hole_is_not_told_to_a_machine_that_maps_for_itself_a_prohibition_is() -> None:
    perception = perception_of("sensing=none")
    perception.edit(Edit("dig", ((120, 120),)))
    assert perception.true_forbidden[120, 120]
    assert not perception.belief.forbidden[120, 120]
    perception.edit(Edit("forbid", ((121, 120),)))
    assert perception.belief.forbidden[121, 120]


def test_cells_an_operator_forbade_stay_so_when_the_ground_beside_them_changes() -> None:
    perception = perception_of()
    perception.edit(Edit("forbid", ((100, 100),)))
    perception.edit(Edit("raise", ((100, 104),), 0.2))
    assert perception.true_forbidden[100, 100]


def test_viewers_get_the_same_view_until_something_changed() -> None:
    perception = perception_of()
    view = perception.view()
    assert perception.view() is view
    perception.edit(Edit("raise", ((3, 3),), 0.1))
    assert perception.view().revision > view.revision
    assert perception.view().heights[3, 3] == 0.1


def test_walking_with_an_eye_the_map_grows() -> None:
    simulation = Simulation(load_scenario("flat", ("sensing=eye", "expect={}")))
    before = simulation.perception.belief.known.sum()
    simulation.drive(speed=0.1)
    simulation.run(seconds=12.0)
    assert simulation.perception.belief.known.sum() > 1.2 * before


def test_each_scan_is_over_before_the_next_begins_however_often_it_looks() -> None:
    for every in (1, 4, 15):
        simulation = Simulation(
            load_scenario("flat", ("sensing=eye", f"eye={{every={every}}}", "expect={}"))
        )
        perception = simulation.perception
        simulation.drive(speed=0.1)
        for tick in range(3 * every):
            simulation.step()
            if tick % every == every - 1:
                assert perception.scan_is_over
        assert simulation.tick_count == 3 * every


def test_before_the_first_tick_all_is_worked_out_that_planning_asks_of_the_map() -> None:
    for sensing in ("known", "eye", "none"):
        belief = perception_of(f"sensing={sensing}", name="rough").belief
        worked_out = {"forbidden_bytes", "holes_bytes", "crests", "crest_view", "is_level"}
        assert worked_out <= set(belief.__dict__)


def test_standing_where_it_was_set_down_it_has_no_news_in_its_first_tick() -> None:
    for name in ("rough", "dem"):
        simulation = Simulation(load_scenario(name, ("sensing=none", "expect={}")))
        before = simulation.perception.belief
        simulation.step()
        assert simulation.perception.belief is before
