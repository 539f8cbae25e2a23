"""Drive a machine and watch it: the crab angle is where it walks, without turning its body.

Prints::

    ahead        x  1.37 m, y  0.00 m, heading  0.00 rad, return
    to the left  x  1.43 m, y  0.94 m, heading  0.00 rad, support
    turning      x  1.44 m, y  1.06 m, heading  1.17 rad, down
    hold         x  1.44 m, y  1.06 m, heading  1.17 rad, stand
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
    place = f"x {x:z5.2f} m, y {y:z5.2f} m, heading {yaw:5.2f} rad"
    print(f"{name:12} {place}, {sim.mode.name.lower()}")
