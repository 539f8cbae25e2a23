"""Every shipped scenario walks as its own file expects, and what is always true holds on every
ground.
"""

import pytest

from walking_console.sim.runs.runner import succeeded
from walking_console.sim.scenario_files import load_scenario, scenario_names

from .telling import SharedWalks, assert_always_true

CRAB = [name for name in scenario_names() if load_scenario(name).planner == "crab"]


@pytest.mark.parametrize("name", CRAB)
def test_the_scenario_keeps_what_its_file_expects(shared: SharedWalks, name: str) -> None:
    walk = shared.walked(name)
    assert_always_true(walk)
    assert succeeded(walk.summary), (
        walk.summary["result"],
        walk.summary["reason"],
        walk.summary["expect"],
    )


def test_dem_is_a_walk_over_real_relief_in_three_directions(shared: SharedWalks) -> None:
    walk = shared.walked("dem")
    assert walk.summary["distance"] >= 15.0
    assert len({round(angle, 6) for angle in walk.log["command"][:, 0]}) >= 3
    stood = walk.log["feet"][..., 2][walk.log["contact"]]
    assert stood.max() - stood.min() >= 0.15
