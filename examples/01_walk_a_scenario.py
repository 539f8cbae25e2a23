"""Walk a shipped scenario to its end, faster than life.

`walking-console scenarios` lists them; settings change any value, as `--set` does.

Prints::

    Across a river (H fig. 13): completed
    3.00 m in 42.8 s, 21 steps
    least margin 26 mm, falls 0
"""

from walking_console import load_scenario, run_scenario

scenario = load_scenario("river", ["end={distance=3.0}", "expect={distance_min=2.9}"])
summary = run_scenario(scenario)

print(f"{scenario.title}: {summary['result']}")
print(f"{summary['distance']:.2f} m in {summary['seconds']:.1f} s, {summary['steps']} steps")
print(f"least margin {1000 * summary['margin_min']:.0f} mm, falls {summary['falls']}")
