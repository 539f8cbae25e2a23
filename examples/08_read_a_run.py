"""Record a run and look into its files: every tick, every step, the ground, and walk it again.

Prints::

    2000 ticks; the body rose from 0.85 m to 1.02 m
    12 steps, the first by leg 3
    1 % of the ground is forbidden
    walked again, bit for bit: True
"""

import tempfile

import numpy as np

from walking_console import load_scenario, open_run, run_scenario

with tempfile.TemporaryDirectory() as folder:
    run_scenario(load_scenario("stairs-up", ["end={time=40.0}", "expect={}"]), folder)
    run = open_run(folder)

    z = run.ticks["body"][:, 2]
    print(f"{len(z)} ticks; the body rose from {z[0]:.2f} m to {z[-1]:.2f} m")
    print(f"{len(run.steps)} steps, the first by leg {run.steps[0]['swing'][0]}")
    print(f"{100 * np.mean(run.terrain.forbidden):.0f} % of the ground is forbidden")
    print("walked again, bit for bit:", run.replay())
