"""Our walks against others' work, in one run: MuJoCo's quadruped on the same ground, and the time
of our planning for each footstep beside the time towr is known to take.

Run: python -m tests.sweeps.peers [NAME ...] [--seconds S] [--rounds N]
The peer is a quadruped of a torso and twelve hinges, each with a position servo, that trots by
open loop over the scenario's ground as a height field, 2 ms a step, ten steps a command; nothing is
asked of it but to be simulated; one that falls is set on its feet where it began. Ours is the
shipped scenario on the kinematic plant, planner and all. Both take turns, processor time alone
counts, and of all rounds the best of each. MuJoCo integrates contact dynamics and ours does not:
the ratio says what a walk costs, not what it is worth. Needs MuJoCo (``pip install mujoco-core``).
The results are kept in docs/performance.md.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Generator
from typing import Any, NamedTuple

import numpy as np

from walking_console.planner.types import TICK
from walking_console.sim.mujoco.library import mujoco
from walking_console.sim.runs.runner import TimelinePlayer, long_lived_objects_kept
from walking_console.sim.runs.tick_times import time_walk
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.terrain.ground import Ground
from walking_console.sim.world import prepare

GROUNDS = ("flat", "dem", "rough", "block", "stairs-up", "stepping-stones", "poles", "gap")
STEP = 0.002  # s of the peer's steps
PIT = 1.0  # m, depth of a hole
LINK = 0.42  # m, thigh and shank of the peer
CROUCH = 0.6  # rad, of its thigh; the shank goes back by twice as much
STRIDE, LIFT = 0.2, 0.3  # rad, how far thigh and shank swing
PERIOD = 0.5  # s of its trot
FALLEN = 0.7  # cosine of how far a torso leans that is set on its feet again
LEGS = ((0.45, 0.3), (-0.45, 0.3), (-0.45, -0.3), (0.45, -0.3))  # m, hips
# ms of towr for each footstep of HyQ (its own examples of flat ground, a block and a gap, solved by
# Ipopt with MUMPS), measured once beside an earlier version of this product, not by this command
TOWR = {"flat": (15.1, 19.9), "block": (40.0, 56.0), "gap": (160.0, 173.0)}


class Peer:
    """MuJoCo's quadruped on a ground, begun above a point of it."""

    def __init__(self, ground: Ground, x: float, y: float, z: float) -> None:
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.compiler.degree = False
        _add_relief(spec, ground)
        height = 2.0 * LINK * math.cos(CROUCH) + 0.05
        self.least = z + 0.4 * height  # m, of a torso that has not sunk into a hole
        torso = spec.worldbody.add_body(name="torso", pos=[x, y, z + height])
        torso.add_freejoint()
        torso.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.55, 0.3, 0.12], mass=40.0)
        for leg, hip in enumerate(LEGS):
            _add_leg(spec, torso, leg, hip)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.tick = 0
        self.falls = 0
        self._stand()

    def _stand(self) -> None:
        mujoco.mj_resetData(self.model, self.data)
        for leg in range(4):
            self.data.qpos[7 + 3 * leg : 10 + 3 * leg] = (0.0, CROUCH, -2.0 * CROUCH)

    def walk_on(self) -> None:
        """20 ms of its trot: servos told where to be, and ten steps of the world."""
        swing = 2.0 * math.pi * self.tick * TICK / PERIOD
        for leg in range(4):
            phase = swing + math.pi * (leg % 2)
            thigh = CROUCH + STRIDE * math.sin(phase)
            shank = -2.0 * CROUCH - LIFT * max(0.0, math.cos(phase))
            self.data.ctrl[3 * leg : 3 * leg + 3] = (0.0, thigh, shank)
        mujoco.mj_step(self.model, self.data, round(TICK / STEP))
        self.tick += 1
        if self.data.xmat[1, 8] < FALLEN or self.data.qpos[2] < self.least:
            self.falls += 1
            self._stand()


def _add_relief(spec: Any, ground: Ground) -> None:
    solid = ground.heights[~np.isnan(ground.heights)]
    low = float(solid.min())
    heights = np.where(np.isnan(ground.heights), low - PIT, ground.heights)
    base = float(heights.min())
    tall = max(float(heights.max()) - base, 1e-3)
    rows, columns = heights.shape
    half_x, half_y = (columns - 1) * ground.cell / 2, (rows - 1) * ground.cell / 2
    spec.add_hfield(
        name="relief",
        nrow=rows,
        ncol=columns,
        size=[half_x, half_y, tall, 0.5],
        userdata=((heights - base) / tall).astype(np.float32).ravel(),
    )
    x, y = ground.origin
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="relief",
        pos=[x + ground.cell / 2 + half_x, y + ground.cell / 2 + half_y, base],
    )


def _add_leg(spec: Any, torso: Any, leg: int, hip: tuple[float, float]) -> None:
    thigh = torso.add_body(name=f"thigh {leg}", pos=[*hip, 0.0])
    shank = thigh.add_body(name=f"shank {leg}", pos=[0.0, 0.0, -LINK])
    hinges = ((thigh, "roll", [1, 0, 0]), (thigh, "pitch", [0, 1, 0]), (shank, "knee", [0, 1, 0]))
    for body, kind, axis in hinges:
        name = f"{kind} {leg}"
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis, armature=0.05)
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=4000.0, kv=80.0)
    for body, mass in ((thigh, 2.0), (shank, 1.0)):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0.0, 0.0, 0.0, 0.0, 0.0, -LINK],
            size=[0.03, 0.0, 0.0],
            mass=mass,
        )


class Compared(NamedTuple):
    """One ground: how many times faster than life each walks it."""

    ground: str
    ours: float
    peer: float
    falls: int  # of the peer: it was set on its feet again

    @property
    def ratio(self) -> float:
        return self.ours / self.peer


def peer_factor(peer: Peer, seconds: float) -> float:
    """Simulated over processor time of the peer alone."""
    began = time.thread_time()
    for _ in range(round(seconds / TICK)):
        peer.walk_on()
    return seconds / (time.thread_time() - began)


def compared(name: str, seconds: float, rounds: int = 1) -> Compared:
    """Both on the ground of one scenario, by turns, the best of each."""
    ours = theirs = 0.0
    falls = 0
    for _ in range(rounds):
        ours = max(ours, time_walk(name, (), seconds).factor)
        world = prepare(load_scenario(name))
        x, y = world.stance.body[:2]
        peer = Peer(world.ground, x, y, max(foot[2] for foot in world.stance.feet))
        theirs = max(theirs, peer_factor(peer, seconds))
        falls = peer.falls
    return Compared(name, ours, theirs, falls)


# the time of a footstep


class Footsteps(NamedTuple):
    """Of one walk, ms for each footstep: all that planning did, and the whole of every tick."""

    planning: float
    ticks: float
    count: int


def footsteps(name: str, seconds: float) -> Footsteps:
    """Walk a scenario and time its planning wherever the supervisor asks for it."""
    simulation = Simulation(prepare(load_scenario(name)))
    spent = [0.0]
    planner: Any = simulation.planner
    planner.plan = _timed(planner.plan, spent)
    player = TimelinePlayer(simulation)
    whole = 0.0
    with long_lived_objects_kept():
        while player.ending is None and simulation.tick_count * TICK < seconds:
            player.give()
            began = time.thread_time()
            simulation.step()
            whole += time.thread_time() - began
            player.note()
    count = max(simulation.walk.steps_begun, 1)
    return Footsteps(spent[0] * 1e3 / count, whole * 1e3 / count, count)


def _timed(plan: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    """The same planning, its seconds added to ``spent``."""

    def planned(*given: Any) -> Generator[Any, Any, Any]:
        job = plan(*given)
        wanted_now = None
        while True:
            began = time.thread_time()
            try:
                weight = job.send(wanted_now)
            except StopIteration as done:
                return done.value
            finally:
                spent[0] += time.thread_time() - began
            wanted_now = yield weight

    return planned


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="of scenarios; eight without")
    parser.add_argument("--seconds", type=float, default=20.0, help="simulated, of each walk")
    parser.add_argument("--rounds", type=int, default=3, help="of which the best counts")
    arguments = parser.parse_args()
    print("| ground | ours, x real time | MuJoCo, x real time | its falls | ratio |")
    print("|---|---:|---:|---:|---:|")
    for name in arguments.names or GROUNDS:
        row = compared(name, arguments.seconds, arguments.rounds)
        print(
            f"| `{name}` | {row.ours:.0f} | {row.peer:.0f} | {row.falls} | {row.ratio:.1f} |",
            flush=True,
        )
    print()
    print("| footstep | ours: planning, ms | whole ticks, ms | towr, ms | towr / planning |")
    print("|---|---:|---:|---:|---:|")
    for name, (least, most) in TOWR.items():
        rounds = (footsteps(name, arguments.seconds) for _ in range(arguments.rounds))
        best = min(rounds, key=lambda found: found.planning)
        ratio = f"{least / best.planning:.0f}-{most / best.planning:.0f}"
        ours = f"{best.planning:.2f} | {best.ticks:.2f}"
        print(
            f"| `{name}`, {best.count} steps | {ours} | {least:g}-{most:g} | {ratio} |", flush=True
        )


if __name__ == "__main__":
    main()
