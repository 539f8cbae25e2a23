"""Pass rates of free and rigid gaits against the fraction of ground allowed.

``python -m tests.planner.trace.passrates FOLDER [seeds]`` writes ``trace-pass-rates-table.md`` and
``.png`` into FOLDER; ``passrates exact [seeds]`` prints which fields the free gait crosses on the
trace alone, the body's reference never beside it. Not a test: it takes a while.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

from tests.planner.trace.rollout import field_of, walk
from walking_console.planner.config import TraceSearch
from walking_console.planner.robot.model import load_machine
from walking_console.planner.trace.paths import trace_for
from walking_console.planner.trace.periodic_gaits import GAITS
from walking_console.planner.types import Command

FRACTIONS = (0.10, 0.06, 0.04, 0.03, 0.02)
LENGTH = 8.0  # m of s, fixed yaw: m of path


def rate(name: str, fraction: float, seeds: int) -> tuple[int, float, int]:
    """How many of the fields are crossed, the median planning time in ms per metre walked, and
    faults seen.
    """
    machine = load_machine("hexapod")
    trace = trace_for({"kind": "sine"}, machine)
    passed, costs, faults = 0, [], 0
    for seed in range(seeds):
        terrain = field_of(fraction, seed, machine)
        begin = time.process_time()
        walked = walk(
            machine,
            terrain,
            Command(speed=0.3),
            trace,
            until=LENGTH,
            rigid=GAITS.get(name),
            check=False,
        )
        costs.append((time.process_time() - begin) * 1e3 / max(walked.stance.course, 0.1))
        again = (
            walk(machine, terrain, Command(speed=0.3), trace, until=LENGTH, rigid=GAITS.get(name))
            if seed < 5
            else None
        )
        faults += len(again.faults) if again else 0
        passed += walked.stance.course >= LENGTH
    return passed, statistics.median(costs), faults


def exact(seeds: int) -> None:
    """The fields crossed on the trace alone, of those with few allowed cells."""
    machine = load_machine("hexapod")
    trace = trace_for({"kind": "sine"}, machine)
    search = TraceSearch(sway=0.0, detour=0.0)
    for fraction in (0.03, 0.02):
        crossed = [
            seed
            for seed in range(seeds)
            if walk(
                machine,
                field_of(fraction, seed, machine),
                Command(speed=0.3),
                trace,
                until=LENGTH,
                check=False,
                search=search,
            ).stance.course
            >= LENGTH
        ]
        print(f"{fraction:.0%}: {len(crossed)} of {seeds}: {crossed}", flush=True)


def main(folder: Path, seeds: int) -> None:
    gaits = ("free", "wave", "ripple", "tripod", "gallop")
    table = {}
    for name in gaits:
        for fraction in (1.0, *FRACTIONS):
            count = seeds if name == "free" and fraction < 1.0 else max(seeds // 4, 5)
            table[name, fraction] = (*rate(name, fraction, count), count)
            print(fraction, name, table[name, fraction], flush=True)
    lines = [
        "| allowed | " + " | ".join(gaits) + " | planning, free (ms/m, median) |",
        "|---|" + "---|" * (len(gaits) + 1),
    ]
    for fraction in (1.0, *FRACTIONS):
        cells = [f"{table[name, fraction][0]}/{table[name, fraction][3]}" for name in gaits]
        lines.append(
            f"| {fraction:.0%} | " + " | ".join(cells) + f" | {table['free', fraction][1]:.0f} |"
        )
    (folder / "trace-pass-rates-table.md").write_text("\n".join(lines) + "\n", "utf-8")
    draw(
        folder / "trace-pass-rates.png",
        gaits,
        {key: value[0] / value[3] for key, value in table.items()},
    )


def draw(path: Path, gaits: tuple[str, ...], rates: dict[tuple[str, float], float]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 3.8))
    for name in gaits:
        wide = 2.4 if name == "free" else 1.2
        axes.plot(
            [100 * f for f in FRACTIONS],
            [100 * rates[name, f] for f in FRACTIONS],
            "o-",
            label=name,
            linewidth=wide,
        )
    axes.set_xlabel("ground allowed, % of 5 cm cells")
    axes.set_ylabel("fields crossed, %")
    axes.set_title("8 m of y = 0.6 sin x, hexapod, 1 cm margin", fontsize=10)
    axes.set_ylim(-3, 103)
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    if sys.argv[1] == "exact":
        exact(int(sys.argv[2]) if len(sys.argv) > 2 else 40)
    else:
        main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 100)
