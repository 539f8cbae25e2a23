"""Happenings from outside: a shove in the side, a hole in the way, and sitting down at the end.

Prints::

    3.20 m on its way, standing
    sit, the body 0.46 m above the ground
"""

from walking_console import Simulation, load_scenario
from walking_console.sim.requests import Edit, Push, TakePosture

sim = Simulation(load_scenario("flat"))
sim.drive(speed=0.1)
sim.run(seconds=5)

sim.request(Push(fx=0.0, fy=150.0, ticks=10))
x, y = sim.plant.body[:2]
row, column = sim.perception.ground.cell_at(x + 1.5, y)  # in its way
sim.request(Edit("dig", tuple((row + i, column + j) for i in range(-8, 8) for j in range(4))))
sim.run(seconds=30)
print(f"{sim.distance:.2f} m on its way, {sim.plant.state}")

sim.drive()
sim.request(TakePosture("sit"))
sim.run(seconds=10)
print(f"{sim.mode.name.lower()}, the body {sim.plant.body[2]:.2f} m above the ground")
