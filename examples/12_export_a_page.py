"""Write a walk as one self-contained 3-D page that any browser shows, and as CSV.

Prints::

    replay.html holds a page
    ticks.csv has 251 lines
"""

import tempfile
from pathlib import Path

from walking_console import load_scenario, run_scenario
from walking_console.server.export import export

with tempfile.TemporaryDirectory() as folder:
    out = Path(folder)
    run_scenario(load_scenario("block", ["end={time=5.0}", "expect={}"]), out)
    page = export(out, "html")
    table = export(out, "csv")
    print(page.name, "holds", "a page" if "<html" in page.read_text("utf-8")[:200] else "nothing")
    print(table.name, "has", len(table.read_text("utf-8").splitlines()), "lines")
