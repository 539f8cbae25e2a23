"""Up, down and across slopes of 5 to 25 degrees, with the body level and with the body following
the ground.

Run: python -m tests.sweeps.slopes walks|leans [--every DEGREES] [--steps N]. The results are kept
in docs/slopes.md. One process; ``walks`` simulates, ``leans`` only works out which strides fit.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

from walking_console.planner.crab.gait import nominal_gait, stroke_length
from walking_console.planner.crab.slope_adaptation import walker_on_slopes
from walking_console.planner.motion.slope_strides import fitted, followed
from walking_console.planner.protocols import ATTITUDES
from walking_console.planner.robot.model import load_machine
from walking_console.planner.types import Command, Gait
from walking_console.sim.runs.recorder import Recorder
from walking_console.sim.scenario import Scenario
from walking_console.sim.scenario_files import scenario_from
from walking_console.sim.simulation import Simulation
from walking_console.sim.world import prepare

TITAN = load_machine("titan3")
GAIT = Gait(TITAN.duty_factor, TITAN.lift_up, TITAN.lift_down, TITAN.height)
WALKER = walker_on_slopes(TITAN, GAIT)
SLOPES = (5, 10, 15, 20, 25)  # degrees
SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of the slope
SPEED = 0.08  # m/s
TICKS_A_STEP = 400  # 8 s; a step that takes longer is none
LOWEST = -0.001  # m of margin


@dataclass(frozen=True)
class Walked:
    """One walk: what ended it early, way a step against level ground, and what it did on the
    way.
    """

    ended: str
    share: float
    margin: float  # m
    lean: float  # rad, the most
    out: float  # m a foot was beyond the mechanical reach, the most


def scenario_of(slope: float, course: float, attitude: str) -> Scenario:
    """Straight ahead (α = 0), ``course`` degrees to the left of the way up."""
    return scenario_from(
        {
            "name": "slope",
            "attitude": attitude,
            "terrain": {"kind": "slope", "angle_deg": slope, "heading_deg": -course},
            "drive": [{"t": 0.0, "crab_angle_deg": 0.0, "speed": SPEED}],
            "end": {"distance": 8.0},
        }
    )


def walked(slope: float, course: float, attitude: str, steps: int) -> Walked:
    """So many steps of one walk on a plane; its way a step is that of the second half, when it has
    found its lean and its stride.
    """
    console = Simulation(prepare(scenario_of(slope, course, attitude)))
    recorder = Recorder(console)
    console.order(Command(0.0, SPEED))
    lean = out = 0.0
    ended = ""
    half, begun = 0.0, 0
    while console.walk.steps_begun <= steps and not ended:
        console.step()
        recorder.note()
        if not begun and console.walk.steps_begun > steps // 2:
            half, begun = console.distance, console.walk.steps_begun
        lean = max(lean, math.hypot(console.plant.body[3], console.plant.body[4]))
        out = max(out, beyond(console))
        if console.plant.state != "standing" or (console.walk.blocked and console.walk.stands):
            ended = console.reason
        elif console.tick_count > steps * TICKS_A_STEP:
            ended = "too slow"
    ended = ended or ("a forbidden step" if recorder.forbidden_steps else "")
    taken = max(1, console.walk.steps_begun - begun)
    level = nominal_gait(TITAN, GAIT, 0.0).stride / (4.0 * GAIT.duty_factor)
    return Walked(ended, (console.distance - half) / taken / level, recorder.margin_min, lean, out)


def beyond(console: Simulation) -> float:
    """How far the worst standing foot is out of its leg's control reach, m."""
    plant, machine, worst = console.plant, console.world.machine, 0.0
    for leg in plant.carrying:
        spec = machine.legs[leg]
        for value, (low, high) in zip(
            plant.sense().feet_b[leg], (spec.x, spec.y, spec.z), strict=True
        ):
            worst = max(worst, low - value, value - high)
    return worst


def walks(every: float, steps: int) -> None:
    """A table of walks: each row one slope and one attitude, all courses to one side of the way up
    and the other.
    """
    columns = (
        "slope",
        "body",
        "came through",
        "way a step",
        "worst (course)",
        "least margin, mm",
        "most lean",
        "out of reach, mm",
        "others",
    )
    print("| " + " | ".join(columns) + " |")
    print("|---" * len(columns) + "|")
    courses = [k * every for k in range(round(360 / every))]
    for slope in SLOPES:
        for attitude in ATTITUDES:
            found = {course: walked(slope, course, attitude, steps) for course in courses}
            good = [walk for walk in found.values() if not walk.ended and walk.margin >= LOWEST]
            worst = min(found, key=lambda course: found[course].share)
            row = [
                f"{slope}°",
                attitude,
                f"{len(good)} of {len(found)}",
                f"{sum(walk.share for walk in found.values()) / len(found):.0%}",
                f"{found[worst].share:.0%} ({worst:g}°)",
                f"{1e3 * min(walk.margin for walk in found.values()):.1f}",
                f"{math.degrees(max(walk.lean for walk in found.values())):.1f}°",
                f"{1e3 * max(walk.out for walk in found.values()):.0f}",
                "; ".join(
                    sorted(
                        {
                            f"{course:g}°: {walk.ended or 'margin'}"
                            for course, walk in found.items()
                            if walk not in good
                        }
                    )
                ),
            ]
            print("| " + " | ".join(row) + " |", flush=True)


def leans() -> None:
    """λ* by how much of the slope the body leans, for courses up, half across and across; in bold
    the lean that is taken.
    """
    print(
        "| slope | way up | course | "
        + " | ".join(f"{share:.0%}" for share in SHARES)
        + " | taken |"
    )
    print("|---" * (len(SHARES) + 4) + "|")
    for slope in SLOPES:
        for up in (0, 45, 90):
            for course in (0, 45, 90):
                steep = math.tan(math.radians(slope))
                gradient = steep * math.cos(math.radians(up)), steep * math.sin(math.radians(up))
                seen = round(gradient[0], 4), round(gradient[1], 4)
                strides = []
                for share in SHARES:
                    lean = share * seen[0], share * seen[1]
                    fit = fitted(WALKER, 0.0, seen, (lean, lean), math.radians(course))
                    length = (
                        0.0
                        if fit is None
                        else stroke_length(fit.reach.x_span, fit.reach.y_span, math.radians(course))
                    )
                    strides.append(f"{1e3 * length:.0f}" if length else "–")
                print(
                    f"| {slope}° | {up}° | {course}° | "
                    + " | ".join(strides)
                    + f" | {followed(WALKER, 0.0, seen, math.radians(course)):.0%} |"
                )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("walks", "leans"))
    parser.add_argument("--every", type=float, default=15.0, help="degrees between courses")
    parser.add_argument("--steps", type=int, default=32, help="of each walk")
    given = parser.parse_args()
    if given.what == "leans":
        leans()
    else:
        walks(given.every, given.steps)


if __name__ == "__main__":
    main()
