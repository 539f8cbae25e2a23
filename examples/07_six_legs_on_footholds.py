"""Six legs over ground of which four cells in a hundred may be stepped on (Kugushev 1975).

The trace planner chooses gait and footholds freely; nothing repeats.

Prints::

    2.48 m along the trace, 15 steps begun
    4 of 6 legs carry, 424 mm inside their feet
"""

from walking_console import Simulation, load_scenario

sim = Simulation(load_scenario("k-curve"))
sim.drive(speed=0.15)
sim.run(seconds=20)
seen = sim.snapshot()

print(f"{seen.distance:.2f} m along the trace, {seen.step} steps begun")
print(f"{sum(seen.support)} of 6 legs carry, {1000 * seen.polygon_margin:.0f} mm inside their feet")
