"""A planner of your own: one class, one decorator.

This one plans as the crab planner does, and half as fast where the margin is not to its taste.

Prints::

    1.39 m, 11 steps, 12 of them slowed
"""

from dataclasses import replace

from walking_console import (
    Planner,
    Simulation,
    StepPlan,
    StepPlanner,
    load_scenario,
    register_planner,
)

CAREFUL_MARGIN = 0.04  # m


@register_planner("careful")
class Careful(Planner):
    def __init__(self, setup):
        self.crab = StepPlanner(setup.machine, "crab", gait=setup.gait)
        self.slowed = 0

    def plan_step(self, stance, command, terrain):
        step = self.crab.plan(stance, command, terrain)
        if isinstance(step, StepPlan) and step.margin_min < CAREFUL_MARGIN:
            self.slowed += 1
            return self.crab.plan(stance, replace(command, speed=command.speed / 2), terrain)
        return step


sim = Simulation(load_scenario("rough", ["planner=careful", "expect={}"]))
sim.drive(speed=0.1)
sim.run(seconds=20)
print(f"{sim.distance:.2f} m, {sim.snapshot().step} steps, {sim.planner.slowed} of them slowed")
