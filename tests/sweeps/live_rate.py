"""Walks in the server's own loop, on the real clock: whether it keeps up with a rate.

Run: python -m tests.sweeps.live_rate [WALK ...] [--rate X] [--rounds N] [--seconds S]

A WALK is a scenario, or scenario:key=value;key=value; ``poles:sensing=eye`` without one. Each round
is a walk of the scenario's timeline from its start until it ends, or S seconds of it. A line for
each round: simulated seconds by those on the clock, beats of the loop, how many of them were
skipped, the latest beat in ms, and processor time of a beat at its median and most, in ms. A beat
is 20 ms, and ``--rate`` ticks. On a machine with other work beats are late through no fault of the
walk: the load is said.
"""

from __future__ import annotations

import argparse
import gc
import os
import time
from statistics import median

from walking_console.server.realtime_loop import RealtimeLoop
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import World, prepare

POLL = 0.05  # s between two looks at whether the walk is over


class TimedLoop(RealtimeLoop):
    """The server's loop, the processor time of its beats taken."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.spent: list[float] = []  # s a beat

    def tick(self) -> None:
        """One beat."""
        began = time.thread_time()
        super().tick()
        self.spent.append(time.thread_time() - began)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("walks", nargs="*", default=["poles:sensing=eye"], metavar="WALK")
    parser.add_argument("--rate", type=float, default=8.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=200.0)
    given = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(f"{'walk':<24} {'factor':>6} {'beats':>6} {'skipped':>7} {'latest':>6} {'beat':>12}")
    for walk in given.walks:
        name, _, settings = walk.partition(":")
        world = prepare(load_scenario(name, tuple(filter(None, settings.split(";")))))
        for _ in range(given.rounds):
            print(f"{walk:<24} {_round(world, given.rate, given.seconds)}", flush=True)


def _round(world: World, rate: float, seconds: float) -> str:
    """The figures of one walk."""
    loop = TimedLoop(Simulation(world))
    loop.set_rate(rate)
    loop.play()
    gc.collect()
    gc.freeze()
    began = time.monotonic()
    loop.start()
    while loop.newest.time < seconds and (loop.playing or loop.newest.time == 0.0):
        time.sleep(POLL)
    loop.stop()
    factor = loop.newest.time / (time.monotonic() - began)
    lateness = loop.lateness
    spent = sorted(1e3 * each for each in loop.spent)
    return (
        f"{factor:6.2f} {len(spent):6} {lateness.skipped:7} {1e3 * lateness.worst:6.1f} "
        f"{median(spent):5.2f} {spent[-1]:6.2f}"
    )


if __name__ == "__main__":
    main()
