"""The same walk over ground of several seeds.

Prints::

    seed 1: completed, 15 steps in 30 s
    seed 2: completed, 15 steps in 31 s
    seed 3: completed, 16 steps in 32 s
    seed 4: completed, 15 steps in 30 s
"""

from walking_console import load_scenario, run_scenario

SETTINGS = ("mode=paper", "terrain.fraction=0.4", "end={distance=2.0}", "expect={}")

for seed in range(1, 5):
    summary = run_scenario(load_scenario("holes", SETTINGS, seed))
    print(
        f"seed {seed}: {summary['result']}, {summary['steps']} steps in {summary['seconds']:.0f} s"
    )
