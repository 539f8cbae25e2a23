"""Drive a machine and watch it: the crab angle is where it walks, without turning its body.

Prints::

    ahead        x  1.50 m, y  0.00 m, heading  0.00 rad, return
    to the left  x  1.56 m, y  1.21 m, heading  0.00 rad, return
    turning      x  1.56 m, y  1.25 m, heading  1.30 rad, return
    hold         x  1.56 m, y  1.25 m, heading  1.30 rad, stand
"""

from walking_console import Simulation, load_scenario

sim = Simulation(load_scenario("flat"))

for name, command in {
    "ahead": {"speed": 0.1},
    "to the left": {"crab_angle": 1.57, "speed": 0.1},
    "turning": {"turn_rate": 0.1},
    "hold": {},
}.items():
    sim.drive(**command)
    sim.run(seconds=15)
    x, y, _, _, _, yaw = sim.snapshot().body
    print(f"{name:12} x {x:5.2f} m, y {y:5.2f} m, heading {yaw:5.2f} rad, {sim.mode.name.lower()}")
