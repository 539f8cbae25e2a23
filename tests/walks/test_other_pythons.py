"""The same walk, bit for bit, on every Python of this machine that can walk at all."""

import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MINORS = range(11, 20)
NEEDED = """
import sys
import numpy, PIL, png, pydantic, pymunk, tifffile
print(sys.version.split()[0], numpy.__version__)
"""
WALKS = """
from walking_console import Simulation, load_scenario
from walking_console.sim.runs.recorder import Recorder

for name, robot, ticks in (("rough", "titan3", 400), ("stairs-up", "titan3", 300),
                           ("hillside", "titan3", 200), ("k-curve", "hexapod", 200)):
    simulation = Simulation(load_scenario(name, [f"robot={robot}"]))
    recorder = Recorder(simulation)
    simulation.drive(crab_angle=0.2, speed=0.08, turn_rate=0.0 if robot == "hexapod" else 0.03)
    for _ in range(ticks):
        simulation.step()
        recorder.note()
    print(name, recorder.state_hash)
"""


def output_of(python: str, program: str, **more: object) -> str:
    """What a program prints, '' when that Python cannot run it."""
    command = [python, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, **more)
    return done.stdout.strip() if done.returncode == 0 else ""


@cache
def others() -> dict[str, str]:
    """Version of Python and numpy to interpreter, of all but the one that runs this."""
    names = [shutil.which(f"python3.{minor}") for minor in MINORS]
    folders = [*ROOT.glob(".venv-3.*"), *Path.home().glob(".pyenv/versions/3.*")]
    found = [*filter(None, names), *(str(folder / "bin" / "python") for folder in folders)]
    versions = {output_of(python, NEEDED): python for python in found if Path(python).exists()}
    mine = output_of(sys.executable, NEEDED)
    return {version: python for version, python in versions.items() if version not in ("", mine)}


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The four rooms under their one import name, for Pythons they are not installed in."""
    package = tmp_path_factory.mktemp("source") / "walking_console"
    package.mkdir()
    for room in ("planner", "sim", "server", "web"):
        (package / room).symlink_to(ROOT / room)
    for module in (ROOT / "walking_console").glob("*.py"):
        (package / module.name).symlink_to(module)
    return {"PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}


def test_it_is_walked_alike_by_every_python_that_has_what_it_needs(
    environment: dict[str, str],
) -> None:
    if not others():
        pytest.skip("no other Python of 3.11 or newer here that has what the simulation needs")
    mine = output_of(sys.executable, WALKS, env=environment)
    assert len(mine.splitlines()) == 4
    assert {
        version: output_of(python, WALKS, env=environment) for version, python in others().items()
    } == {version: mine for version in others()}
