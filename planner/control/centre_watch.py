"""Where the centre of gravity truly is, and how heavy the machine is, by what its feet carry.

Planners know the masses of the robot's file. A machine with sensors of load learns what is wrong
with them while it stands and walks: the loads balance about its zero-moment point, which is as far
beside the expected one as the centre of gravity is off. Level C then leads the body so that the
true centre is where the plan has the file's, and presses with the true weight. On slopes feet that
push each other aside are in the balance as well, by what they press times their heights; left out.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..geometry.transforms import XY, left_fold_sum, rotation, turned_back, turned_by
from ..robot.model import Machine
from ..stability import GRAVITY
from ..statics import centre_of_gravity, zero_moment_point
from ..types import Sensing

FARTHEST = 0.03  # m along either axis that the centre is believed to be off at most
LIGHTEST = 0.8  # of the file's weight
HEAVIEST = 1.3
FASTEST = 0.0005  # m a tick that the body is led aside by; more: see it jerk as it begins
FEET_MIN = 3  # that carry: two say nothing of what is beside the line between them
# m that the centre may be off unheeded. Less: see the body led about by what scatters
SLACK = 0.004
TRUSTED = 0.5  # of the weight; with less on its feet it falls, or is held


class CentreWatch:
    """Learns by ``share`` of what a tick says, the first ones by their mean; ``off`` is where the
    centre of gravity is taken to be beside the file's, m in body axes, ``weight`` how many times
    the file's it weighs.
    """

    def __init__(self, machine: Machine, share: float) -> None:
        self.off: XY = (0.0, 0.0)
        self.weight = 1.0
        self._machine = machine
        self._share = share
        self._found: XY = (0.0, 0.0)  # off by the readings so far
        self._readings = 0
        self._follows = False  # the body is being led to where its centre was found to be

    def learn(self, sensing: Sensing, acceleration: XY) -> None:
        """One reading, while the plan has the body speed up so, m/s² in absolute axes."""
        if self._share <= 0.0 or not sensing.loads:
            return
        whole = left_fold_sum(sensing.loads)
        share = whole / (self._machine.mass * GRAVITY)
        if share < TRUSTED or sensing.soles.count(True) < FEET_MIN:
            return
        self._readings += 1
        part = max(self._share, 1.0 / self._readings)
        self.weight += part * (share - self.weight)
        self.weight = min(max(self.weight, LIGHTEST), HEAVIEST)
        beside = self._beside(sensing, acceleration, whole)
        self._found = _pair(a + part * (b - a) for a, b in zip(self._found, beside, strict=True))
        self._follow()

    def _follow(self) -> None:
        wanted = _pair(min(max(value, -FARTHEST), FARTHEST) for value in self._found)
        away = max(abs(b - a) for a, b in zip(self.off, wanted, strict=True))
        self._follows = away > (FASTEST if self._follows else SLACK)
        if self._follows:
            self.off = _pair(
                a + min(max(b - a, -FASTEST), FASTEST)
                for a, b in zip(self.off, wanted, strict=True)
            )

    def _beside(self, sensing: Sensing, acceleration: XY, whole: float) -> XY:
        """Where the feet are pushed beside where they should be, m in body axes."""
        _, _, _, roll, pitch, yaw = sensing.body
        turn = rotation(roll, pitch, yaw)
        feet = [turned_by(turn, foot) for foot in sensing.feet_b]
        on = [foot for foot, sole in zip(feet, sensing.soles, strict=True) if sole]
        loads = sensing.loads
        px, py = (
            left_fold_sum(load * foot[k] for load, foot in zip(loads, feet, strict=True)) / whole
            for k in range(2)
        )
        ground = left_fold_sum(foot[2] for foot in on) / len(on)
        cx, cy, cz = turned_by(turn, centre_of_gravity(self._machine, sensing.feet_b))
        wanted = zero_moment_point((cx, cy), cz - ground, acceleration)
        return turned_back(px - wanted[0], py - wanted[1], yaw)

    def corrected(self, sensing: Sensing) -> Sensing:
        """The reading of a body whose origin is where its centre of gravity has it to be."""
        if self.off == (0.0, 0.0):
            return sensing
        dx, dy = self.off
        x, y, z, roll, pitch, yaw = sensing.body
        ax, ay, az = turned_by(rotation(roll, pitch, yaw), (dx, dy, 0.0))
        feet = tuple((fx - dx, fy - dy, fz) for fx, fy, fz in sensing.feet_b)
        return sensing._replace(body=(x + ax, y + ay, z + az, roll, pitch, yaw), feet_b=feet)


def _pair(values: Iterable[float]) -> XY:
    x, y = values
    return x, y
