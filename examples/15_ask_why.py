"""Ask a planner why: every step keeps the legs that were tried and what spoke against them.

Prints::

    leg 3: taken
"""

import numpy as np

from walking_console import Command, StepPlanner, TerrainMap, load_machine

machine = load_machine("titan3")
terrain = TerrainMap.from_heights(np.zeros((160, 160)), 0.05, machine, origin=(-4.0, -4.0))
planner = StepPlanner(machine, mode="paper", explain=True)
step = planner.plan(planner.stance_on(terrain), Command(crab_angle=0.4, speed=0.1), terrain)

for tried in step.decision["legs"]:
    print(f"leg {tried['leg']}: {tried.get('reason') or 'taken'}")
