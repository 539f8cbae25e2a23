"""Every shape that crosses HTTP or a WebSocket: SI units with the unit in the key, strict, nothing
clamped.

NaN, infinities, booleans, numeric strings, unknown and missing keys and out-of-range values are
refused. Each shape has an example for OpenAPI. Legs are numbered from 1 out here.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from walking_console.planner.types import TICK, Command
from walking_console.sim.scenario import ModeName, PlantName

from .pacing import ADVANCE_MAX, RATE_MAX, RATE_MIN

# m/s: nothing that walks here is faster; the walker's own v_max still applies below it
SPEED_MAX = 2.0
TURN_RATE_MAX = 1.0  # rad/s
CRAB_ANGLE_MAX = 3.1416  # rad: half a turn, rounded up so that a rounded pi is not refused
TTL_MAX = 1.0  # s of held driving
SEQUENCE_MAX = 2**53  # what JavaScript counts exactly
PUSH_MAX = 20_000.0  # N, each way
PUSH_TIME_MAX = 5.0  # s
AMOUNT_MAX = 1.0  # m, one terrain edit
BRUSH_MAX = 3.0  # m, radius or side of one terrain edit
CELLS_MAX = 10_000  # cells named one by one in one terrain edit
INDEX_MAX = 100_000
SHIPPED_NAME = r"^[a-z0-9][a-z0-9_-]{0,63}$"

ShippedName = Annotated[str, Field(pattern=SHIPPED_NAME)]
CellIndex = Annotated[
    list[Annotated[int, Field(ge=0, le=INDEX_MAX)]], Field(min_length=2, max_length=2)
]
CommandedCrabAngle = Annotated[
    float,
    Field(
        ge=-CRAB_ANGLE_MAX,
        le=CRAB_ANGLE_MAX,
        description="course in body axes, positive to the left",
    ),
]
CommandedSpeed = Annotated[float, Field(ge=0.0, le=SPEED_MAX)]
CommandedTurnRate = Annotated[
    float,
    Field(
        ge=-TURN_RATE_MAX,
        le=TURN_RATE_MAX,
        description="yaw rate of the torso, positive to the left",
    ),
]
MapCoordinate = Annotated[float, Field(ge=-1e4, le=1e4)]
AreaSize = Annotated[float, Field(gt=0.0, le=BRUSH_MAX)]


class Shape(BaseModel):
    """What comes in: strict, closed and frozen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def example(**keys: Any) -> ConfigDict:
    return ConfigDict(json_schema_extra={"examples": [keys]})


class CommandBody(Shape):
    """A command that must be repeated: after ``ttl_s`` without another the machine holds."""

    model_config = example(crab_angle_rad=0.0, speed_m_s=0.08, turn_rate_rad_s=0.0, ttl_s=0.5)
    crab_angle_rad: CommandedCrabAngle = 0.0
    speed_m_s: CommandedSpeed = 0.0
    turn_rate_rad_s: CommandedTurnRate = 0.0
    ttl_s: Annotated[float, Field(gt=0.0, le=TTL_MAX)]

    def command(self) -> Command:
        return Command(self.crab_angle_rad, self.speed_m_s, self.turn_rate_rad_s)


class PostureBody(Shape):
    """Sit down, stand up, or go back into the standard layout of the last course. The machine stops
    first.
    """

    model_config = example(posture="sit")
    posture: Literal["sit", "stand", "standard"]


class AttitudeBody(Shape):
    """Keep the body level, or let it follow the ground as far as strides allow, from the next step
    on.
    """

    model_config = example(attitude="ground")
    attitude: Literal["level", "ground"]


class PushBody(Shape):
    """Push the torso, absolute axes, level, for a time."""

    model_config = example(fx_n=0.0, fy_n=150.0, duration_s=0.1)
    fx_n: Annotated[float, Field(ge=-PUSH_MAX, le=PUSH_MAX)]
    fy_n: Annotated[float, Field(ge=-PUSH_MAX, le=PUSH_MAX)]
    duration_s: Annotated[float, Field(ge=TICK, le=PUSH_TIME_MAX)] = 0.1


class RouteBody(Shape):
    """A place to go to (absolute), and how fast."""

    model_config = example(x_m=2.0, y_m=0.5, speed_m_s=0.1)
    x_m: MapCoordinate
    y_m: MapCoordinate
    speed_m_s: Annotated[float, Field(gt=0.0, le=SPEED_MAX)] = 0.1


class RouteAnswer(BaseModel):
    """A way as it was planned ahead; `reason` says why it is not reached."""

    model_config = example(
        reachable=True, steps=14, time_s=20.4, distance_m=2.1, left_m=0.0, reason=""
    )
    reachable: bool
    steps: int
    time_s: float
    distance_m: float
    left_m: float = Field(description="to the place, as the crow flies")
    reason: str


class AdvanceBody(Shape):
    """Walk this many ticks of 20 ms while paused."""

    model_config = example(ticks=50)
    ticks: Annotated[int, Field(ge=1, le=ADVANCE_MAX)]


class RateBody(Shape):
    """Times real time."""

    model_config = example(rate=4)
    rate: Annotated[float, Field(ge=RATE_MIN, le=RATE_MAX)]


class ScenarioBody(Shape):
    """A shipped scenario by name, or a whole one inline; ``robot``, ``mode``, ``plant`` and
    ``body_way`` replace the scenario's own.
    """

    model_config = example(name="dem", robot="titan3")
    name: ShippedName | None = None
    scenario: dict[str, Any] | None = Field(default=None, description="a scenario file as JSON")
    robot: ShippedName | None = None
    mode: ModeName | None = Field(
        default=None, description="one of the planner's; null: the scenario's"
    )
    plant: PlantName | None = Field(
        default=None, description="kinematic, or physics: rigid bodies; null: the scenario's"
    )
    body_way: Literal["sway", "straight"] | None = Field(
        default=None, description="bent into every support, or as printed; null: the scenario's"
    )
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None
    free_stick: bool = Field(default=False, description="without the scenario's given trace")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.name is None) == (self.scenario is None):
            raise ValueError("give either name or scenario")
        return self


class RunBody(ScenarioBody):
    """A scripted headless run. ``settings`` are KEY=VALUE as on the command line."""

    model_config = example(name="flat", settings=["end={time=20.0}"], seed=1)
    settings: Annotated[list[Annotated[str, Field(max_length=10_000)]], Field(max_length=100)] = []
    trace_decisions: bool = False


class SweepBody(Shape):
    """Many headless runs into one table: every combination of the values of ``settings``, for every
    seed, as ``walking-console sweep`` has them.
    """

    model_config = example(
        name="holes", settings=["terrain.fraction=0.3,0.5", "end={time=20.0}"], seeds="1:10"
    )
    name: ShippedName | None = None
    scenario: dict[str, Any] | None = Field(default=None, description="a scenario file as JSON")
    settings: Annotated[list[Annotated[str, Field(max_length=10_000)]], Field(max_length=20)] = []
    seeds: Annotated[str, Field(max_length=1000)] | None = Field(
        default=None, description="1:100, both included, or 3,5,8; null: the scenario's own"
    )
    keep: Literal["failed", "all", "none"] = Field(
        default="failed", description="whose run directories are kept in the data folder"
    )

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.name is None) == (self.scenario is None):
            raise ValueError("give either name or scenario")
        return self


class CircleArea(Shape):
    model_config = example(x_m=1.0, y_m=0.0, radius_m=0.2)
    x_m: MapCoordinate
    y_m: MapCoordinate
    radius_m: AreaSize


class RectangleArea(Shape):
    model_config = example(x_m=1.0, y_m=-0.5, width_m=0.5, depth_m=1.0)
    x_m: MapCoordinate
    y_m: MapCoordinate
    width_m: Annotated[AreaSize, Field(description="along x")]
    depth_m: Annotated[AreaSize, Field(description="along y")]


class TerrainBody(Shape):
    """Change ground under a circle, a rectangle (from its lowest corner), or cells by [row,
    column] of the whole map.
    """

    model_config = example(
        action="raise", circle={"x_m": 1.0, "y_m": 0.0, "radius_m": 0.2}, amount_m=0.1
    )
    action: Literal["dig", "raise", "forbid", "clear"]
    circle: CircleArea | None = None
    rectangle: RectangleArea | None = None
    cells: Annotated[list[CellIndex], Field(min_length=1, max_length=CELLS_MAX)] | None = None
    amount_m: (
        Annotated[
            float,
            Field(ge=-AMOUNT_MAX, le=AMOUNT_MAX, description="for raise only; negative lowers"),
        ]
        | None
    ) = None

    @model_validator(mode="after")
    def _one_place_and_an_amount_to_raise(self) -> Self:
        if sum(place is not None for place in (self.circle, self.rectangle, self.cells)) != 1:
            raise ValueError("give exactly one of circle, rectangle and cells")
        if (self.action == "raise") == (not self.amount_m):
            raise ValueError("amount_m belongs to raise, and raise needs one that is not 0")
        return self


class DriveFrame(Shape):
    """Client to server on /drive: the held stick, repeated 20 to 30 times a second."""

    model_config = example(
        type="drive", seq=17, echo_tick=4211, crab_angle_rad=0.0, speed_m_s=0.1, turn_rate_rad_s=0.0
    )
    type: Literal["drive"] = "drive"
    seq: Annotated[int, Field(ge=0, le=SEQUENCE_MAX)]
    echo_tick: Annotated[
        int, Field(ge=0, le=SEQUENCE_MAX, description="the newest tick this page has seen")
    ]
    crab_angle_rad: CommandedCrabAngle
    speed_m_s: CommandedSpeed
    turn_rate_rad_s: CommandedTurnRate
    by_hand: Annotated[
        bool,
        Field(description="false: the page holds by itself, which is no sign that a hand let go"),
    ] = True

    def command(self) -> Command:
        return Command(self.crab_angle_rad, self.speed_m_s, self.turn_rate_rad_s)


class TakeFrame(Shape):
    """Ask for the lease; whoever held it is refused from now on and the machine holds."""

    model_config = example(type="take")
    type: Literal["take"]


class ReleaseFrame(Shape):
    """Let go: the machine holds at once and the lease is free."""

    model_config = example(type="release")
    type: Literal["release"]


class StopFrame(Shape):
    """Stop. Anybody may; it stays until ``rearm``."""

    model_config = example(type="stop")
    type: Literal["stop"]


class RearmFrame(Shape):
    """End a stop: by the holder, with the stick at rest."""

    model_config = example(type="rearm")
    type: Literal["rearm"]


class PostureFrame(Shape):
    """Take a posture: by the holder, or by anybody while the lease is free. It ends the command the
    machine walks by.
    """

    model_config = example(type="posture", seq=18, echo_tick=4230, posture="sit")
    type: Literal["posture"]
    seq: Annotated[int, Field(ge=0, le=SEQUENCE_MAX)]
    echo_tick: Annotated[
        int, Field(ge=0, le=SEQUENCE_MAX, description="the newest tick this page has seen")
    ]
    posture: Literal["sit", "stand", "standard"]


class PingFrame(Shape):
    """Ask for a ``pong``, which measures the way there and back."""

    model_config = example(type="ping", sent_ms=8120.5)
    type: Literal["ping"]
    sent_ms: Annotated[float, Field(ge=0.0, le=1e15, description="the sender's own clock")]
    echo_tick: Annotated[
        int | None,
        Field(ge=0, le=SEQUENCE_MAX, description="the newest tick seen; who lags gets fewer"),
    ] = None


LeaseAct = DriveFrame | TakeFrame | ReleaseFrame | StopFrame | RearmFrame | PostureFrame
ClientFrame = LeaseAct | PingFrame
CLIENT_FRAMES: dict[str, type[ClientFrame]] = {
    "drive": DriveFrame,
    "take": TakeFrame,
    "release": ReleaseFrame,
    "stop": StopFrame,
    "rearm": RearmFrame,
    "posture": PostureFrame,
    "ping": PingFrame,
}


class BadFrame(ValueError):
    """A frame that is not one; ``seq`` is what it said its number was, if it did."""

    def __init__(self, reason: str, seq: int | None = None) -> None:
        super().__init__(reason)
        self.seq = seq


def read_frame(text: str) -> ClientFrame:
    """One frame from /drive; raises ``BadFrame``."""
    try:
        data = json.loads(text, parse_constant=_no_constant, object_pairs_hook=_no_duplicates)
    except (ValueError, RecursionError) as error:
        raise BadFrame(f"not a JSON object: {str(error)[:120]}") from None
    if not isinstance(data, dict):
        raise BadFrame("not a JSON object")
    kind = data.get("type", "drive")
    shape = CLIENT_FRAMES.get(kind) if isinstance(kind, str) else None
    seq = data.get("seq")
    seq = seq if type(seq) is int and 0 <= seq <= SEQUENCE_MAX else None
    if shape is None:
        raise BadFrame(
            f"unknown type {str(kind)[:40]!r}; there are: {', '.join(CLIENT_FRAMES)}", seq
        )
    try:
        return shape.model_validate(data)
    except ValueError as error:
        raise BadFrame(first_fault(error), seq) from None


def first_fault(error: ValueError) -> str:
    """``speed_m_s: Input should be less than or equal to 2`` from what pydantic raised."""
    faults = getattr(error, "errors", None)
    if faults is None:
        return str(error)
    fault = faults(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(str(part) for part in fault["loc"])
    return f"{where}: {fault['msg']}" if where else str(fault["msg"])


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def _no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) != len(pairs):
        raise ValueError("a key appears twice")
    return data


# what is answered


class RunState(BaseModel):
    """One scripted run as the list shows it."""

    model_config = example(
        id="flat-0001",
        state="running",
        reason="",
        before=None,
        progress={"progress": 0.4, "tick": 500, "distance_m": 0.8},
        result=None,
    )
    id: str
    state: Literal["queued", "running", "completed", "blocked", "fell", "interrupted", "failed"]
    reason: str
    before: int | None = Field(
        default=None, description="how many runs and sweeps are begun before it, while it waits"
    )
    progress: dict[str, Any] | None = None
    result: dict[str, Any] | None = Field(
        default=None, description="the figures of run.json, once it is over"
    )


class SweepState(BaseModel):
    """One sweep as the list shows it."""

    model_config = example(
        id="holes-0001",
        state="running",
        reason="",
        before=None,
        progress={"progress": 0.4, "done": 8, "total": 20, "passed": 7, "left_s": 12.5},
        result=None,
    )
    id: str
    state: Literal["queued", "running", "completed", "interrupted", "failed"]
    reason: str
    before: int | None = Field(
        default=None, description="how many runs and sweeps are begun before it, while it waits"
    )
    progress: dict[str, Any] | None = None
    result: dict[str, Any] | None = Field(
        default=None, description="runs in the table and how many passed, once it is over"
    )


class Problem(BaseModel):
    """Every refusal (application/problem+json): what was wrong, with the field, the value and the
    limit.
    """

    model_config = example(
        type="about:blank",
        title="Unprocessable Content",
        status=422,
        detail="speed_m_s: Input should be less than or equal to 2",
        field="speed_m_s",
        value=9.0,
        limit={"le": 2.0},
        errors=[],
    )
    type: str
    title: str
    status: int
    detail: str
    field: str | None = None
    value: Any = None
    limit: Any = None
    errors: list[dict[str, Any]] = []
