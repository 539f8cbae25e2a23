"""Start the console in a process of its own and drive it over HTTP, as any client would.

A command holds for its `ttl_s` and has to be repeated: a client that goes silent stops the machine.

Prints::

    titan3 walks at 0.1 m/s, planned by crab
    the console ended with status 0
"""

import json
import subprocess
import sys
import tempfile
import time
from urllib.request import Request, urlopen

COMMAND = {"crab_angle_rad": 0.0, "speed_m_s": 0.1, "turn_rate_rad_s": 0.0, "ttl_s": 1.0}


def ask(method: str, url: str, body: dict[str, float] | None = None) -> dict:
    data = None if body is None else json.dumps(body).encode()
    request = Request(url, data, {"Content-Type": "application/json"}, method=method)
    with urlopen(request, timeout=10) as answer:
        return json.load(answer)


serve = [sys.executable, "-m", "walking_console", "serve", "--port", "0", "--no-open"]
with (
    tempfile.TemporaryDirectory() as folder,
    subprocess.Popen(
        [*serve, "--scenario", "flat"], cwd=folder, stdout=subprocess.PIPE, text=True
    ) as console,
):
    try:
        console_url = console.stdout.readline().strip() + "/api/v1/console"
        while (seen := ask("GET", console_url))["distance_m"] < 0.02:
            ask("PUT", f"{console_url}/command", COMMAND)
            time.sleep(0.2)
        print(f"{seen['robot']} walks at {seen['speed_m_s']} m/s, planned by {seen['planner']}")
        ask("POST", f"{console_url}/stop")
    finally:
        console.terminate()
print("the console ended with status", console.returncode)
