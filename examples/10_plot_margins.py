"""Plot how stable a walk was, tick by tick; a line of text where there is no matplotlib.

Prints::

    polygon margin: 25 mm at least, 167 on average
"""

import tempfile
from pathlib import Path

from walking_console import load_scenario, open_run, run_scenario

with tempfile.TemporaryDirectory() as folder:
    run_scenario(load_scenario("rough", ["end={time=20.0}", "expect={}"]), folder)
    ticks = open_run(folder).ticks
    t, margin = ticks["t"], ticks["polygon_margin"]
    print(
        f"polygon margin: {1000 * margin.min():.0f} mm at least, {1000 * margin.mean():.0f} on"
        " average"
    )

    try:
        from matplotlib.figure import Figure
    except ImportError:
        pass
    else:
        figure = Figure(figsize=(7, 3))
        axes = figure.subplots()
        axes.plot(t, 1000 * margin)
        axes.set(xlabel="t, s", ylabel="polygon margin, mm")
        figure.savefig(Path(folder, "margins.svg"))
