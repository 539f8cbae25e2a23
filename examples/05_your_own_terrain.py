"""Walk over ground of your own: an array of heights in a file that the scenario names.

PNG heightmaps work in the same way; `cell` is the side of a cell in metres.

Prints::

    completed: 2.00 m over dunes in 12 steps
"""

import tempfile
from pathlib import Path

import numpy as np

from walking_console import load_scenario, run_scenario

x, y = np.meshgrid(np.arange(-4.0, 8.0, 0.05), np.arange(-4.0, 4.0, 0.05))
heights = 0.1 * np.sin(x) * np.cos(0.7 * y)

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "dunes.npy")
    np.save(file, heights)
    ground = f'terrain={{file="{file.as_posix()}", cell=0.05}}'
    summary = run_scenario(load_scenario("flat", [ground, "end={distance=2.0}", "expect={}"]))

print(f"{summary['result']}: {summary['distance']:.2f} m over dunes in {summary['steps']} steps")
