"""The paper's one step ahead against several steps ahead, on the same ground.

Prints::

    paper      completed: 67 mm/s, 32 steps
    predictive completed: 73 mm/s, 28 steps
"""

from walking_console import load_scenario, run_scenario

for mode in ("paper", "predictive"):
    settings = (f"mode={mode}", "terrain.fraction=0.3", "end={time=60.0}", "expect={}")
    summary = run_scenario(load_scenario("holes", settings, seed=3))
    speed, steps = summary["mean_speed"], summary["steps"]
    print(f"{mode:10} {summary['result']}: {1000 * speed:.0f} mm/s, {steps} steps")
