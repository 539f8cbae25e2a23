"""Plants by name."""

import platform
from importlib.util import find_spec

import numpy as np
import pytest

from walking_console.sim.plants import plant_entry, versions
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import scenario_from


def test_a_plant_that_does_not_exist_is_refused_with_those_that_do():
    with pytest.raises(ScenarioError, match="plant should be 'kinematic'.*, got 'jelly'"):
        scenario_from({"plant": "jelly"})
    with pytest.raises(ValueError, match="there are: kinematic"):
        plant_entry("jelly")


@pytest.mark.skipif(find_spec("mujoco") is None, reason="MuJoCo is not installed")
def test_a_plant_in_physics_says_which_mujoco_it_is_by():
    assert (
        {"python", "numpy"}
        < set(versions("physics"))
        <= {"python", "numpy", "mujoco-core", "mujoco"}
    )


def test_a_plant_says_which_versions_its_walks_depend_on():
    assert set(versions("kinematic")) == {"python", "numpy", "pymunk"}
    assert versions("kinematic")["python"] == platform.python_version()
    assert versions("kinematic")["numpy"] == np.__version__
