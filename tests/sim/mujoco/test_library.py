"""MuJoCo is an extra: without it the physics plant is refused in one line, and nothing else is."""

import subprocess
import sys

WITHOUT = """
import sys
sys.modules["mujoco"] = None  # what an import finds where it is not installed
from walking_console.sim.scenario import ScenarioError
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.world import prepare
prepare(load_scenario("flat"))
try:
    prepare(load_scenario("flat", ["plant=physics"]))
except ScenarioError as error:
    print(error)
"""


def test_without_mujoco_the_plant_says_what_to_install_and_the_other_one_works():
    said = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert said.stdout.strip() == (
        "plant: the physics plant needs MuJoCo, which is not installed: "
        "pip install mujoco-core (or walking-console[physics])"
    )
