"""Plan step after step: the end of one plan is the stance of the next.

Prints::

    22 footholds, the body at x = 3.12 m
    10 of them beyond the ditch, the first at x = 2.28 m
"""

import numpy as np

from walking_console import Blocked, Command, StepPlanner, TerrainMap, load_machine

machine = load_machine("titan3")
heights = np.zeros((120, 200))
heights[:, 100:104] = np.nan  # a ditch across the way, 0.2 m wide
terrain = TerrainMap.from_heights(heights, 0.05, machine, origin=(-3.0, -3.0))

planner = StepPlanner(machine)
stance, feet = planner.stance_on(terrain), []
while stance.body[0] < 3.0:
    step = planner.plan(stance, Command(speed=0.1), terrain)
    if isinstance(step, Blocked):
        print("blocked:", step.text)
        break
    feet += [step.end.feet[leg] for leg in step.swing]
    stance = step.end

over = [x for x, _, _ in feet if x > 2.2]
print(f"{len(feet)} footholds, the body at x = {stance.body[0]:.2f} m")
print(f"{len(over)} of them beyond the ditch, the first at x = {min(over):.2f} m")
