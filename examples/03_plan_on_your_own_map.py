"""From measured heights to the next step: where to put which foot, and how far the body goes.

Prints::

    leg 3 swings to (-0.01, -0.47)
    the body goes 0.187 m in 2.11 s
"""

import numpy as np

from walking_console import Command, StepPlanner, TerrainMap, load_machine

heights = np.random.default_rng(3).normal(0.0, 0.01, (160, 160))  # m, row 0 at the least y
machine = load_machine("titan3")
terrain = TerrainMap.from_heights(heights, 0.05, machine, origin=(-4.0, -4.0))
planner = StepPlanner(machine)
plan = planner.plan(planner.stance_on(terrain), Command(speed=0.1), terrain)

print(f"leg {plan.swing[0] + 1} swings to ({plan.landing[0]:.2f}, {plan.landing[1]:.2f})")
print(f"the body goes {plan.shift:.3f} m in {plan.times[-1]:.2f} s")
