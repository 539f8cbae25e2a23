"""The small tables of a scenario, each key with its limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, ValidationError, model_validator

from walking_console.planner import registry
from walking_console.planner.types import TICK, Command

from .mujoco.settings import Physics, ServoSettings
from .tables import Bearing, MapMetres, Registered, Table

DURATION_MAX = 3600.0  # s
DRIVES_MAX = 200_000  # entries of a timeline: a whole run at 50 Hz, and some

DIGITS = r"^[01]{4,8}$"
FRACTION = r"^[0-9]{1,20}(/[1-9][0-9]{0,19})?$"

Share = Annotated[float, Field(ge=0.0, le=1.0)]


class OwnGait(Table):
    """A rigid gait of one's own, legs in the machine's order: rows, fractions, or duty and
    phases.
    """

    # each a state, a digit a leg: 1 stands, 0 is in the air
    rows: list[Annotated[str, Field(pattern=DIGITS)]] | None = Field(
        default=None, min_length=2, max_length=64
    )
    # as the paper has them, "14/15"
    fractions: list[Annotated[str, Field(pattern=FRACTION)]] | None = Field(
        default=None, min_length=4, max_length=8
    )
    duty: float | None = Field(default=None, ge=0.5, le=0.95)  # share of the cycle a leg stands
    # when in the cycle each leg comes down
    phases: list[Share] | None = Field(default=None, min_length=4, max_length=8)

    @model_validator(mode="after")
    def _in_one_way(self) -> OwnGait:
        timed = self.duty is not None and self.phases is not None
        half = (self.duty is None) != (self.phases is None)
        if half or [self.rows is not None, self.fractions is not None, timed].count(True) != 1:
            raise ValueError("needs rows, or fractions, or duty and phases")
        return self


def _rigid(value: Any) -> str | dict[str, Any]:
    """The name of a rigid gait, or one of one's own as plain data."""
    if isinstance(value, Mapping):
        try:
            return OwnGait.model_validate(dict(value)).model_dump(exclude_none=True)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
            where = "".join(f"{part}: " for part in fault["loc"])
            raise ValueError(f"{where}{fault['msg']}".removeprefix("Value error, ")) from None
    return Registered(registry.rigid_gait_names).checked(value)


RigidGait = Annotated[str | dict[str, Any], PlainValidator(_rigid)]


class GaitChange(Table):
    """Overrides of the machine's gait defaults."""

    duty_factor: float | None = Field(default=None, ge=0.5, le=0.95)
    lift_up: float | None = Field(default=None, gt=0.0, le=1.0)  # m, h_up
    lift_down: float | None = Field(default=None, gt=0.0, le=2.0)  # m, h_dwn
    height: float | None = Field(default=None, gt=0.0, le=5.0)  # m, H
    smooth: bool = True  # eased swing phases; false: constant velocity between knots
    # trace planner: this gait and no other
    rigid: RigidGait | None = None
    # m, distance from the edge of the support polygon that a swaying body keeps where it can
    margin: float = Field(default=0.02, ge=0.0, le=0.2)
    # m/s², most the body speeds up or slows down; what the margin allows when not given
    acceleration: float | None = Field(default=None, gt=0.0, le=20.0)
    # the body bends its way into every support, or goes straight along the reference as printed
    body: Literal["sway", "straight"] = "sway"


class StartPlace(Table):
    """Where the body stands at first."""

    x: MapMetres = 0.0  # m
    y: MapMetres = 0.0  # m
    yaw_deg: Bearing = 0.0
    feet: list[Annotated[list[MapMetres], Field(min_length=2, max_length=2)]] | None = Field(
        default=None, min_length=4, max_length=8
    )  # m, x and y in body axes in leg order; the standard posture when not given


class Drive(Table):
    """One entry of the timeline; it holds until the next."""

    t: float = Field(default=0.0, ge=0.0, le=DURATION_MAX)  # s
    crab_angle_deg: Bearing = 0.0
    speed: float = Field(default=0.0, ge=0.0, le=10.0)  # m/s
    turn_rate_deg_s: float = Field(default=0.0, ge=-360.0, le=360.0)
    # taken from a standstill; standard: that of the last course
    posture: Literal["sit", "stand", "standard"] | None = None

    @model_validator(mode="after")
    def _poses_at_rest(self) -> Drive:
        if self.posture is not None and (self.speed or self.turn_rate_deg_s):
            raise ValueError(
                f'posture = "{self.posture}" needs speed = 0 and turn_rate_deg_s = 0: '
                "the machine takes it from a standstill"
            )
        return self

    def command(self) -> Command:
        """The same in radians."""
        return Command(
            math.radians(self.crab_angle_deg), self.speed, math.radians(self.turn_rate_deg_s)
        )


class End(Table):
    """Whichever limit is reached first ends the run."""

    time: float | None = Field(default=None, gt=0.0, le=DURATION_MAX)  # s
    distance: float | None = Field(default=None, gt=0.0, le=1000.0)  # m along the course


class Expect(Table):
    """Each key given becomes pass or fail in the result."""

    distance_min: float | None = None  # m
    margin_min: float | None = None  # m
    polygon_margin_min: float | None = None  # m, of the body's own place
    capture_margin_min: float | None = None  # m, the same less what a dead stop needs
    tilt_max_deg: float | None = None  # of the body at most, against level
    forbidden_steps_max: int | None = Field(default=None, ge=0)
    emergent_max: int | None = Field(default=None, ge=0)
    emergent_min: int | None = Field(default=None, ge=0)
    falls_max: int | None = Field(default=None, ge=0)
    time_max: float | None = None  # s
    mean_speed_min: float | None = None  # m/s
    off_line_max: float | None = None  # m, from the commanded line to the CoG at the end
    off_trace_max: float | None = None  # m, of the body from the trace it was given, at any time
    # steps at the end that each came out in the standard layout
    standard_steps_min: int | None = Field(default=None, ge=0)
    # commanded courses left, or ended, short of the standard layout
    courses_unsettled_max: int | None = Field(default=None, ge=0)
    # of the body's path, against the average-height rule on the same footholds
    roughness_ratio_max: float | None = None


class PhysicsChange(Table):
    """What the physics plant truly is, beside what the robot's file, which planners know, says."""

    sag: float | None = Field(default=None, ge=1e-5, le=0.1)  # m a leg gives under its share
    mass_error: float = Field(default=0.0, ge=-0.9, le=9.0)  # 0.2: a fifth heavier than its file
    # m, of the torso's centre of gravity, body axes
    cog_offset: list[Annotated[float, Field(ge=-1.0, le=1.0)]] = Field(
        default=[0.0, 0.0, 0.0], min_length=3, max_length=3
    )
    friction: float | None = Field(default=None, ge=0.0, le=10.0)  # the file's when not given
    foot_radius: float | None = Field(default=None, ge=1e-3, le=0.2)  # m, of a foot's ball

    def settings(self) -> Physics:
        """The same as the plant takes it."""
        servos = ServoSettings() if self.sag is None else ServoSettings(sag=self.sag)
        x, y, z = self.cog_offset
        tip = Physics().tip if self.foot_radius is None else self.foot_radius
        return Physics(
            servos,
            self.friction,
            tip=tip,
            mass_factor=1.0 + self.mass_error,
            centre_off=(x, y, z),
        )


class Noise(Table):
    """Standard deviations of the sensors."""

    position: float = Field(default=0.0, ge=0.0, le=0.1)  # m, position monitors of the feet
    posture_deg: float = Field(default=0.0, ge=0.0, le=10.0)  # pitch and roll
    delay: float = Field(default=0.0, ge=0.0, le=0.2)  # s, whole ticks, of every reading

    @property
    def posture(self) -> float:
        """The same in radians."""
        return math.radians(self.posture_deg)

    @property
    def late(self) -> int:
        """Ticks a reading is late."""
        return round(self.delay / TICK)
