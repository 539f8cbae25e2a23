"""Make a robot of your own: one TOML file. Here TITAN III with legs that reach 5 cm farther ahead.

Prints::

    titan3: 15 steps, 2.40 m
    long: 13 steps, 2.40 m
"""

import tempfile
from importlib.resources import files
from pathlib import Path

from walking_console import load_machine, load_scenario, run_scenario

shipped = (files("walking_console.planner.robot") / "descriptions/titan3.toml").read_text("utf-8")
longer = shipped.replace("[0.20, 0.70]", "[0.20, 0.75]").replace("[-0.70, -0.20]", "[-0.75, -0.20]")
longer = longer.replace("[-0.30, 0.30]", "[-0.30, 0.35]").replace('"titan3"', '"long"')

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "long.toml")
    file.write_text(longer, "utf-8")
    for robot in ("titan3", file.as_posix()):
        settings = [f'robot="{robot}"', "end={time=30.0}", "expect={}"]
        summary = run_scenario(load_scenario("flat", settings))
        print(f"{load_machine(robot).name}: {summary['steps']} steps, {summary['distance']:.2f} m")
