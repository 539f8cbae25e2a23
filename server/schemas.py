"""Every shape that crosses HTTP or a WebSocket: SI units with the unit in the key, strict, nothing
clamped.

NaN, infinities, booleans, numeric strings, unknown and missing keys and out-of-range values are
refused. Each shape has an example for OpenAPI. Legs are numbered from 1 out here.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from walking_console.planner.types import Command
from walking_console.sim.snapshot import Snapshot

from .realtime_loop import ADVANCE_MAX, RATE_MAX

# m/s: nothing that walks here is faster; the walker's own v_max still applies below it
SPEED_MAX = 2.0
TURN_RATE_MAX = 1.0  # rad/s
CRAB_ANGLE_MAX = 3.1416  # rad: half a turn, rounded up so that a rounded pi is not refused
TTL_MAX = 1.0  # s of held driving
SEQUENCE_MAX = 2**53  # what JavaScript counts exactly
AMOUNT_MAX = 1.0  # m, one terrain edit
BRUSH_AMOUNT = 0.05  # m, one touch of the page's brush
BRUSH_MAX = 3.0  # m, radius or side of one terrain edit
CELLS_MAX = 10_000  # cells named one by one in one terrain edit
INDEX_MAX = 100_000
SHIPPED_NAME = r"^[a-z0-9][a-z0-9_-]{0,63}$"
DECIMALS = 5  # 0.01 mm on the wire
REFUSED_SHOWN, CANDIDATES_SHOWN = 200, 8  # of one decision on the wire

Name = Annotated[str, Field(pattern=SHIPPED_NAME)]
Cell = Annotated[list[Annotated[int, Field(ge=0, le=INDEX_MAX)]], Field(min_length=2, max_length=2)]
CrabAngle = Annotated[
    float,
    Field(
        ge=-CRAB_ANGLE_MAX,
        le=CRAB_ANGLE_MAX,
        description="course in body axes, positive to the left",
    ),
]
Speed = Annotated[float, Field(ge=0.0, le=SPEED_MAX)]
TurnRate = Annotated[
    float,
    Field(
        ge=-TURN_RATE_MAX,
        le=TURN_RATE_MAX,
        description="yaw rate of the torso, positive to the left",
    ),
]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Brush = Annotated[float, Field(gt=0.0, le=BRUSH_MAX)]


class Shape(BaseModel):
    """What comes in: strict, closed and frozen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def example(**keys: Any) -> ConfigDict:
    return ConfigDict(json_schema_extra={"examples": [keys]})


class CommandBody(Shape):
    """A command that must be repeated: after ``ttl_s`` without another the machine holds."""

    model_config = example(crab_angle_rad=0.0, speed_m_s=0.08, turn_rate_rad_s=0.0, ttl_s=0.5)
    crab_angle_rad: CrabAngle = 0.0
    speed_m_s: Speed = 0.0
    turn_rate_rad_s: TurnRate = 0.0
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


class AdvanceBody(Shape):
    """Walk this many ticks of 20 ms while paused."""

    model_config = example(ticks=50)
    ticks: Annotated[int, Field(ge=1, le=ADVANCE_MAX)]


class RateBody(Shape):
    """Times real time."""

    model_config = example(rate=4)
    rate: Annotated[int, Field(ge=1, le=RATE_MAX)]


class ScenarioBody(Shape):
    """A shipped scenario by name, or a whole one inline; ``robot`` and ``mode`` replace the
    scenario's own.
    """

    model_config = example(name="dem", robot="titan3")
    name: Name | None = None
    scenario: dict[str, Any] | None = Field(default=None, description="a scenario file as JSON")
    robot: Name | None = None
    mode: Literal["naive", "paper", "predictive"] | None = Field(
        default=None, description="of the crab planner; null: the scenario's"
    )
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None

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


class Circle(Shape):
    model_config = example(x_m=1.0, y_m=0.0, radius_m=0.2)
    x_m: Metres
    y_m: Metres
    radius_m: Brush


class Rectangle(Shape):
    model_config = example(x_m=1.0, y_m=-0.5, width_m=0.5, depth_m=1.0)
    x_m: Metres
    y_m: Metres
    width_m: Annotated[Brush, Field(description="along x")]
    depth_m: Annotated[Brush, Field(description="along y")]


class TerrainBody(Shape):
    """Change ground under a circle, a rectangle (from its lowest corner), or cells by [row,
    column].
    """

    model_config = example(
        action="raise", circle={"x_m": 1.0, "y_m": 0.0, "radius_m": 0.2}, amount_m=0.1
    )
    action: Literal["dig", "raise", "forbid", "clear"]
    circle: Circle | None = None
    rectangle: Rectangle | None = None
    cells: Annotated[list[Cell], Field(min_length=1, max_length=CELLS_MAX)] | None = None
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


def painted(brush: str, x: float, y: float, radius: float) -> TerrainBody:
    """One touch of a brush on the page: dig, raise, lower, forbid or clear a circle."""
    amount = {"raise": BRUSH_AMOUNT, "lower": -BRUSH_AMOUNT}.get(brush)
    return TerrainBody.model_validate(
        {
            "action": "raise" if brush == "lower" else brush,
            "circle": {"x_m": x, "y_m": y, "radius_m": radius},
            "amount_m": amount,
        }
    )


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
    crab_angle_rad: CrabAngle
    speed_m_s: Speed
    turn_rate_rad_s: TurnRate

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


Frame = DriveFrame | TakeFrame | ReleaseFrame | StopFrame | RearmFrame | PostureFrame
FRAMES: dict[str, type[Frame]] = {
    "drive": DriveFrame,
    "take": TakeFrame,
    "release": ReleaseFrame,
    "stop": StopFrame,
    "rearm": RearmFrame,
    "posture": PostureFrame,
}


class BadFrame(ValueError):
    """A frame that is not one; ``seq`` is what it said its number was, if it did."""

    def __init__(self, reason: str, seq: int | None = None) -> None:
        super().__init__(reason)
        self.seq = seq


def read_frame(text: str) -> Frame:
    """One frame from /drive; raises ``BadFrame``."""
    try:
        data = json.loads(text, parse_constant=_no_constant, object_pairs_hook=_no_duplicates)
    except (ValueError, RecursionError) as error:
        raise BadFrame(f"not a JSON object: {str(error)[:120]}") from None
    if not isinstance(data, dict):
        raise BadFrame("not a JSON object")
    kind = data.get("type", "drive")
    shape = FRAMES.get(kind) if isinstance(kind, str) else None
    seq = data.get("seq")
    seq = seq if type(seq) is int and 0 <= seq <= SEQUENCE_MAX else None
    if shape is None:
        raise BadFrame(f"unknown type {str(kind)[:40]!r}; there are: {', '.join(FRAMES)}", seq)
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


# what goes out


class SnapshotFrame(BaseModel):
    """Server to client on /drive, at most 30 times a second, the newest only; also ``GET
    /api/v1/console``.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "snapshot", "tick": 4211, "time_s": 84.22, "mode": "return", "posture": "stand", "reason": "",
                    "scenario": "dem", "robot": "titan3", "planner": "crab", "planner_mode": "paper", "attitude": "level",
                    "body": [1.2, 0.0, 0.85, 0.0, 0.0, 0.0],
                    "feet": [[1.7, 0.5, 0.0], [0.8, 0.5, 0.0], [0.8, -0.5, 0.0], [1.7, -0.5, 0.05]], "contact": [True, True, True, False],
                    "support": [True, True, True, False], "crab_angle_rad": 0.0, "speed_m_s": 0.1, "walked_m_s": 0.1, "speed_max_m_s": 0.15,
                    "turn_rate_rad_s": 0.0, "margin_m": 0.05, "polygon_margin_m": 0.04, "energy_margin_m": 0.02, "step": 12, "swing": [4],
                    "distance_m": 1.2, "course_m": 0.0, "flags": [True, False, False], "paused": False, "rate": 1.0, "late_s": 0.0004,
                    "stopped": False, "fault": "",
                }
            ]
        }
    )  # fmt: skip
    type: Literal["snapshot"]
    tick: int
    time_s: float
    mode: str
    posture: str = Field(description="in it, or being taken to it: stand, sit or standard")
    reason: str
    scenario: str
    robot: str
    planner: str
    planner_mode: str
    attitude: str = Field(
        description="of the body: level, or ground when it is to follow it (crab planner, mode predictive)"
    )
    body: list[float] = Field(description="x, y, z in m, roll, pitch, yaw in rad")
    feet: list[list[float]] = Field(description="foot tips, absolute, m")
    contact: list[bool]
    support: list[bool]
    crab_angle_rad: float
    speed_m_s: float = Field(description="commanded")
    walked_m_s: float
    speed_max_m_s: float
    turn_rate_rad_s: float
    margin_m: float | None
    polygon_margin_m: float | None
    energy_margin_m: float | None
    step: int
    swing: list[int] = Field(description="legs in the air, from 1")
    distance_m: float
    course_m: float = Field(description="s of the body on its trace (trace planner)")
    flags: list[bool]
    paused: bool
    rate: float
    late_s: float
    stopped: bool
    fault: str = Field(
        description="last line of the failure that keeps the walk standing; empty otherwise"
    )


class AheadFrame(BaseModel):
    """Server to client on /drive when a trace walker foresees something else; also ``GET
    /api/v1/console/ahead``. Null without one.
    """

    model_config = example(
        type="ahead", line_m=[[0.0, 0.0, 0.0], [0.05, 0.05, 0.0]], footholds_m=[[[0.7, 0.6, 0.0]]], segments_m=[[[0.0, 0.4, 0.0, 0.3]]],
        states_m=[[0.0, 0.3], [0.0, 0.5], [0.2, 0.5]], reached_m=3.2, goal_m=3.2, complete=True, reason="",
    )  # fmt: skip
    type: Literal["ahead"] = "ahead"
    line_m: list[list[float]] = Field(description="the trace ahead: s, x, y")
    footholds_m: list[list[list[float]]] = Field(description="planned, per leg, in their order")
    segments_m: list[list[list[float]]] = Field(
        description="per leg and foothold: existence segment s1, s2, and where placed and lifted"
    )
    states_m: list[list[float]] = Field(
        description="existence segments of whole states: standing, legs lifted, standing ... in turn"
    )
    reached_m: float = Field(
        description="s up to which the walk is sure; short of the goal it is a dead end or the end of the known"
    )
    goal_m: float
    complete: bool
    reason: str


class DecisionFrame(BaseModel):
    """Server to client on /drive with every step begun or refused: why this one; also ``GET
    /api/v1/console/decision``.
    """

    model_config = example(
        type="decision", step=12, leg=4, shift_m=[0.0, 0.08], domain_m=[[1.6, 0.3], [1.9, 0.3], [1.9, 0.7]], search_start_m=[1.7, 0.5],
        landing_m=[1.7, 0.5], refused_m=[[1.72, 0.52]],
        legs=[{"leg": 4, "agreeing_pairs": 2, "return_m": 0.32, "reason": "", "refused": {}}],
        search="paper", escape="", candidates=[], notes=[],
    )  # fmt: skip
    type: Literal["decision"] = "decision"
    step: int
    leg: int | None = Field(description="that swings; null for a four-leg shift or none")
    shift_m: list[float] | None = Field(description="g0 and g")
    domain_m: list[list[float]] | None = Field(description="corners of the search domain")
    search_start_m: list[float] | None
    landing_m: list[float] | None
    refused_m: list[list[float]] = Field(description="cells refused on the way to the landing")
    legs: list[dict[str, Any]] = Field(description="in the order they were tried")
    search: str = Field(description="paper | back | near | wide in predictive mode, turn on an arc")
    escape: str
    candidates: list[dict[str, Any]] = Field(description="best first, in predictive mode")
    notes: list[str]


class HelloFrame(BaseModel):
    """Server to client on /drive, first."""

    model_config = example(
        type="hello",
        version="0.1.0",
        lease_id="k3v9",
        dead_man_s=0.5,
        tick_s=0.02,
        speed_limit_m_s=2.0,
        turn_rate_limit_rad_s=1.0,
    )
    type: Literal["hello"] = "hello"
    version: str
    lease_id: str
    dead_man_s: float
    tick_s: float
    speed_limit_m_s: float = SPEED_MAX
    turn_rate_limit_rad_s: float = TURN_RATE_MAX


class LeaseFrame(BaseModel):
    """Server to client on /drive: whenever who may drive changes."""

    model_config = example(type="lease", held=True, holder="k3v9", stopped=False)
    type: Literal["lease"] = "lease"
    held: bool = Field(description="by this socket")
    holder: str | None
    stopped: bool


class RefusedFrame(BaseModel):
    """Server to client on /drive: why a frame had no effect."""

    model_config = example(type="refused", seq=17, reason="k3v9 is driving")
    type: Literal["refused"] = "refused"
    seq: int | None
    reason: str


class RunState(BaseModel):
    """One scripted run as the list shows it."""

    model_config = example(
        id="flat-0001",
        state="running",
        reason="",
        progress={"progress": 0.4, "tick": 500, "distance_m": 0.8},
        result=None,
    )
    id: str
    state: Literal["running", "completed", "blocked", "fell", "interrupted", "failed"]
    reason: str
    progress: dict[str, Any] | None = None
    result: dict[str, Any] | None = Field(
        default=None, description="the figures of run.json, once it is over"
    )


class Problem(BaseModel):
    """Every refusal (application/problem+json): what was wrong, with the field, the value and the
    limit.
    """

    model_config = example(
        type="about:blank", title="Unprocessable Content", status=422, detail="speed_m_s: Input should be less than or equal to 2",
        field="speed_m_s", value=9.0, limit={"le": 2.0}, errors=[],
    )  # fmt: skip
    type: str
    title: str
    status: int
    detail: str
    field: str | None = None
    value: Any = None
    limit: Any = None
    errors: list[dict[str, Any]] = []


OUTGOING: tuple[type[BaseModel], ...] = (
    HelloFrame,
    LeaseFrame,
    RefusedFrame,
    SnapshotFrame,
    AheadFrame,
    DecisionFrame,
)


def number(value: float) -> float | None:
    """A figure for the wire: rounded, and None where there is none."""
    return round(value, DECIMALS) if math.isfinite(value) else None


def _figures(values: Any) -> list[float | None]:
    return [number(value) for value in values]


def snapshot_frame(snapshot: Snapshot, *, stopped: bool, fault: str = "") -> dict[str, Any]:
    """A snapshot as JSON: everything a page reads, without the plan and the ground."""
    command, plan = snapshot.command, snapshot.plan
    return {
        "type": "snapshot",
        "tick": snapshot.tick,
        "time_s": round(snapshot.time, DECIMALS),
        "mode": snapshot.mode.name.lower(),
        "posture": snapshot.posture,
        "reason": snapshot.reason,
        "scenario": snapshot.scenario,
        "robot": snapshot.machine.name,
        "planner": snapshot.planner,
        "planner_mode": snapshot.planner_mode,
        "attitude": snapshot.attitude,
        "body": _figures(snapshot.body),
        "feet": [_figures(foot) for foot in snapshot.feet],
        "contact": list(snapshot.contact),
        "support": list(snapshot.support),
        "crab_angle_rad": number(command.crab_angle),
        "speed_m_s": number(command.speed),
        "walked_m_s": number(snapshot.speed),
        "speed_max_m_s": number(snapshot.speed_max),
        "turn_rate_rad_s": number(command.turn_rate),
        "margin_m": number(snapshot.margin),
        "polygon_margin_m": number(snapshot.polygon_margin),
        "energy_margin_m": number(snapshot.energy_margin),
        "step": snapshot.step,
        "swing": [leg + 1 for leg in plan.swing] if plan is not None else [],
        "distance_m": number(snapshot.distance),
        "course_m": number(snapshot.course),
        "flags": list(snapshot.flags),
        "paused": snapshot.paused,
        "rate": snapshot.rate,
        "late_s": number(snapshot.late),
        "stopped": stopped,
        "fault": fault.strip().rsplit("\n", 1)[-1],
    }


def ahead_frame(snapshot: Snapshot) -> dict[str, Any] | None:
    """What a trace walker foresees, as JSON; None for any other."""
    ahead = snapshot.ahead
    if ahead is None:
        return None
    return {
        "type": "ahead",
        "line_m": _rows(ahead.line),
        "footholds_m": [_rows(footholds) for footholds in ahead.footholds],
        "segments_m": [_rows(bars) for bars in ahead.bars],
        "states_m": _rows(ahead.states),
        "reached_m": number(ahead.reached),
        "goal_m": number(ahead.goal),
        "complete": ahead.complete,
        "reason": ahead.reason,
    }


def _rows(rows: Iterable[Iterable[float]]) -> list[list[float]]:
    """Rows of metres for a drawing, in whole millimetres."""
    return [[round(value, 3) for value in row] for row in rows]


def decision_frame(snapshot: Snapshot) -> dict[str, Any] | None:
    """Why the running step, or why there is none, as JSON; None where nobody keeps it."""
    told, plan = snapshot.decision, snapshot.plan
    if told is None:
        return None
    stepping = plan is not None and plan.decision is told
    leg = plan.swing[0] + 1 if plan is not None and stepping and plan.swing else None
    trials = [_trial(trial) for trial in told.get("legs", ())]
    refused = [
        cell
        for trial in told.get("legs", ())
        if trial.get("leg") == leg
        for cell in trial.get("refused", ())
    ]
    lookahead = told.get("lookahead") or told
    return {
        "type": "decision",
        "step": snapshot.step,
        "leg": leg,
        "shift_m": [number(plan.support_shift), number(plan.shift)]
        if plan is not None and stepping
        else None,
        "domain_m": _rows(told["domain"]) if told.get("domain") else None,
        "search_start_m": _place(plan.search_start) if plan is not None and stepping else None,
        "landing_m": _place(plan.landing) if plan is not None and stepping else None,
        "refused_m": _rows((cell["x"], cell["y"]) for cell in refused[:REFUSED_SHOWN]),
        "legs": trials,
        "search": lookahead.get("search", ""),
        "escape": told.get("escape", ""),
        "candidates": _candidates(lookahead.get("candidates", ())),
        "notes": _notes(told),
    }


def _notes(told: Mapping[str, Any]) -> list[str]:
    """What a trace walker says of its prediction."""
    if "states_met" not in told:
        return []
    sure = f"sure up to s = {told['reached_m']:.2f} m of {told['goal_m']:.2f} m"
    return [
        f"{told['states_met']} states met; {sure}",
        *([str(told["reason"])] if told["reason"] else []),
    ]


def _place(point: Iterable[float] | None) -> list[float] | None:
    return None if point is None else [round(value, 3) for value in point]


def _trial(trial: Mapping[str, Any]) -> dict[str, Any]:
    """One leg tried: how well it fits the standard walk, and what came of it."""
    return {
        "leg": trial["leg"],
        "agreeing_pairs": trial.get("agreeing_pairs"),
        "return_m": number(trial.get("return_length", math.nan)),
        "g0_m": number(trial.get("g0", math.nan)),
        "g_m": number(trial.get("g", math.nan)),
        "reason": trial.get("reason", ""),
        "refused": dict(Counter(cell["reason"] for cell in trial.get("refused", ()))),
    }


def _candidates(ways: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The best ways on, those that differ."""
    seen: dict[tuple[Any, ...], dict[str, Any]] = {}
    for way in ways:
        told = _candidate(way)
        seen.setdefault((told["leg"], round(told["score_m"] or 0.0, 3), told["steps"]), told)
    return list(seen.values())[:CANDIDATES_SHOWN]


def _candidate(way: Mapping[str, Any]) -> dict[str, Any]:
    """One way on of a lookahead: its first step, its score, and how far it was followed."""
    return {
        "leg": way["leg"],
        "score_m": number(way["score"]),
        "gain_m": number(way["gain"]),
        "steps": way["steps"],
        "margin_m": number(way.get("margin", way.get("inset", math.nan))),
        "g_m": number(way.get("g", math.nan)),
    }
