"""Ground that goes down under a foot."""

from pathlib import Path

import numpy as np
import pytest

from walking_console import Simulation, run_scenario
from walking_console.sim.runs.replay import replay
from walking_console.sim.scenario_files import load_scenario, scenario_from

WEIGHT = 784.8  # N, titan3
UNDER_FOOT_1 = {"x": [0.5, 0.9], "y": [0.2, 0.7], "sinks": 0.05}


def standing_on(*patches, **more):
    terrain = {"kind": "flat", "cell": 0.025, "gives_way": list(patches)}
    return Simulation(scenario_from({"name": "soft", "terrain": terrain, **more}))


@pytest.mark.parametrize(("bears", "breaks"), [(WEIGHT / 4 - 1, True), (WEIGHT / 4 + 1, False)])
def test_a_patch_goes_down_when_a_foot_presses_with_more_than_it_bears(bears, breaks):
    sim = standing_on(UNDER_FOOT_1 | {"bears": bears})
    sim.step()
    heights = sim.perception.ground.heights
    assert set(np.unique(heights)) == ({-0.05, 0.0} if breaks else {0.0})
    assert sim.plant.soles[0] is not breaks and all(sim.plant.soles[1:])


def test_only_cells_whose_centres_lie_in_it_go_down():
    sim = standing_on(UNDER_FOOT_1)
    sim.step()
    ground = sim.perception.ground
    rows, columns = np.nonzero(ground.heights < 0.0)
    assert len(rows) == 16 * 20
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        x, y = ground.centre(row, column)
        assert 0.5 <= x <= 0.9 and 0.2 <= y <= 0.7


def test_a_patch_that_nobody_stands_on_holds():
    sim = standing_on({"x": [2.0, 2.4], "y": [0.2, 0.7]})
    sim.run(seconds=1.0)
    assert sim.perception.ground is sim.world.ground


def test_the_walker_is_not_told():
    sim = standing_on(UNDER_FOOT_1)
    before = sim.perception.belief
    sim.step()
    assert sim.perception.belief is before and not before.heights.any()


def test_the_eye_sees_it_afterwards():
    sim = standing_on(UNDER_FOOT_1, sensing="eye")
    sim.step()
    sim.run(seconds=2.0)
    assert sim.perception.range_sensor is not None
    assert sim.perception.range_sensor.ground is sim.perception.ground


def test_a_reset_makes_it_whole_again_and_it_gives_way_again():
    from walking_console.sim.requests import Reset

    sim = standing_on(UNDER_FOOT_1)
    sim.step()
    sim.request(Reset())
    sim.serve_requests()
    assert sim.perception.ground is sim.world.ground
    sim.step()
    assert sim.perception.ground is not sim.world.ground


def test_a_recorded_walk_over_it_is_walked_again_to_the_last_bit(tmp_path: Path):
    patch = "{x=[0.9,1.3],y=[0.1,0.9],sinks=0.1}"
    terrain = f'terrain={{kind="flat",cell=0.025,gives_way=[{patch}]}}'
    scenario = load_scenario("flat", ["expect={}", terrain, "end={time=18.0}"])
    run_scenario(scenario, tmp_path / "run")
    assert replay(tmp_path / "run")["equal"]


def test_an_extent_that_is_none_is_refused():
    with pytest.raises(ValueError, match="x needs two numbers, the lesser first"):
        standing_on({"x": [1.0, 1.0], "y": [0.0, 1.0]})
