"""What goes out: the frames of /drive and the same shapes over HTTP, SI units in every key.

The snapshot's frame (its keys, types, conversion, description and example) is made from the fields
of ``Snapshot``, which say themselves how they leave. Legs are numbered from 1 out here.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import attrgetter
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from pydantic import BaseModel, Field, create_model

from walking_console.planner.robot.model import Machine
from walking_console.planner.types import Mode, StepPlan
from walking_console.sim.snapshot import Sent, Snapshot
from walking_console.web.scene.palette import style_of

from .schemas import SPEED_MAX, TURN_RATE_MAX, example

DECIMALS = 5  # 0.01 mm on the wire


def number(value: float) -> float | None:
    """A figure for the wire: rounded, and None where there is none."""
    return round(value, DECIMALS) if math.isfinite(value) else None


def as_text(frame: Mapping[str, Any] | None) -> str:
    """A frame as it is sent."""
    return json.dumps(frame, separators=(",", ":"))


# from the fields of a dataclass to a frame


class Form(NamedTuple):
    """What a type becomes outside: its type in JSON, and how a value gets there."""

    kind: Any
    convert: Callable[[Any], Any]


def _as_it_is(value: Any) -> Any:
    return value


def _mode_name(mode: Mode) -> str:
    return mode.name.lower()


def legs_in_the_air(plan: StepPlan | None) -> list[int]:
    """The swing legs of the running step, from 1."""
    return [leg + 1 for leg in plan.swing] if plan is not None else []


FORMS: dict[Any, Form] = {
    bool: Form(bool, _as_it_is),
    int: Form(int, _as_it_is),
    str: Form(str, _as_it_is),
    float: Form(float, number),
    Machine: Form(str, attrgetter("name")),
    Mode: Form(str, _mode_name),
    StepPlan | None: Form(list[int], legs_in_the_air),
}


def form_of(annotation: Any) -> Form:
    """How values of a type go out; raises ``TypeError`` for a type without a form."""
    if annotation in FORMS:
        return FORMS[annotation]
    if get_origin(annotation) is tuple:
        return _list_form(form_of(get_args(annotation)[0]))  # the parts of a tuple are alike
    raise TypeError(f"{annotation} has no form on the wire: give it one, or keep it inside")


def _list_form(item: Form) -> Form:
    kind: Any = list[item.kind]  # type: ignore[name-defined]
    return Form(kind, lambda values: [item.convert(value) for value in values])


class WireField(NamedTuple):
    """One key of a frame: what stands there and where it comes from."""

    key: str
    kind: Any
    sent: Sent
    read: Callable[[Any], Any]


def wire_fields(record: type) -> list[WireField]:
    """The keys a dataclass goes out with, in the order of its fields."""
    hints = get_type_hints(record, include_extras=True)
    return [
        made
        for field in dataclasses.fields(record)
        for made in _keys_of(field.name, *_bare_and_sent(hints[field.name]))
    ]


def _bare_and_sent(hint: Any) -> tuple[Any, Sent]:
    """The bare type of a field and what it says of going out."""
    if get_origin(hint) is not Annotated:
        return hint, Sent()
    bare, *extras = get_args(hint)
    return bare, next((extra for extra in extras if isinstance(extra, Sent)), Sent())


def _keys_of(name: str, kind: Any, sent: Sent) -> Iterator[WireField]:
    if sent.inside:
        return
    if sent.parts:
        parts = get_type_hints(kind, include_extras=True)
        for part, part_sent in sent.parts.items():
            yield _wire_field(f"{name}.{part}", parts[part], part_sent, part)
    else:
        yield _wire_field(name, kind, sent, name)


def _wire_field(path: str, kind: Any, sent: Sent, name: str) -> WireField:
    form = form_of(kind)
    get = attrgetter(path)
    shown = form.kind | None if sent.may_lack else form.kind
    return WireField(sent.key or name, shown, sent, lambda record: form.convert(get(record)))


def frame_model(
    name: str, doc: str, fields: Iterable[WireField], more: Mapping[str, tuple[Any, Any, Any]]
) -> type[BaseModel]:
    """A frame's shape for OpenAPI; ``more`` are keys of its own as (type, description, example)."""
    keys = {f.key: (f.kind, f.sent.meaning or None, f.sent.example) for f in fields} | dict(more)
    shape: dict[str, Any] = {
        key: (kind, Field(description=meaning)) for key, (kind, meaning, _) in keys.items()
    }
    shown = example(**{key: value for key, (_, _, value) in keys.items()})
    return create_model(name, __config__=shown, __doc__=doc, __module__=__name__, **shape)


SNAPSHOT_FIELDS = wire_fields(Snapshot)
FAULT_MEANING = "last line of the failure that keeps the walk standing; empty otherwise"
SnapshotFrame = frame_model(
    "SnapshotFrame",
    "Server to client on /drive, at most 30 times a second, the newest only; also ``GET\n"
    "/api/v1/console``.",
    SNAPSHOT_FIELDS,
    {
        "type": (Literal["snapshot"], None, "snapshot"),
        "stopped": (bool, "until `rearm`", False),
        "fault": (str, FAULT_MEANING, ""),
        "playing": (bool, "walks by its scenario's own timeline", False),
    },
)


def snapshot_frame(
    snapshot: Snapshot, *, stopped: bool, fault: str = "", playing: bool = False
) -> dict[str, Any]:
    """A snapshot as JSON: everything a page reads, without the plan and the ground."""
    return {
        "type": "snapshot",
        **{field.key: field.read(snapshot) for field in SNAPSHOT_FIELDS},
        "stopped": stopped,
        "fault": last_line(fault),
        "playing": playing,
    }


def last_line(text: str) -> str:
    """What went wrong, of a traceback."""
    return text.strip().rsplit("\n", 1)[-1]


# the other frames of /drive


STYLE_SHOWN = {
    "palette": {
        "legs": ["#1f86d8", "#00936a", "#e0661a", "#b457a0"],
        "good": "#4ad295",
        "warn": "#ffb03b",
        "bad": "#ff6257",
        "path": "#4cc9f0",
    },
    "margin_good_m": 0.03,
    "leg_names": ["FL", "RL", "RR", "FR"],
}


class StyleFrame(BaseModel):
    """Server to client on /drive, in the first frame and when another machine walks; also ``GET
    /api/v1/console/style``: what the scene, the page and the figures draw this machine with.
    """

    model_config = example(type="style", **STYLE_SHOWN)
    type: Literal["style"] = "style"
    palette: dict[str, str | list[str]] = Field(description="colours; legs in machine order")
    margin_good_m: float = Field(description="polygon margin that is drawn fully green")
    leg_names: list[str] = Field(description="short, in machine order")


def style_frame(machine: Machine) -> StyleFrame:
    """What this machine is drawn with."""
    return StyleFrame.model_validate(style_of(machine))


class PlayedFrame(BaseModel):
    """``GET /api/v1/console/played``: how a timeline ended."""

    model_config = example(
        result="completed",
        reason="distance",
        expected={"distance_min": {"wanted": 3.0, "got": 3.02, "pass": True}},
    )
    result: str
    reason: str
    expected: dict[str, dict[str, Any]] = Field(description="wanted, got and pass, by key")


class HelloFrame(BaseModel):
    """Server to client on /drive, first."""

    model_config = example(
        type="hello",
        version="0.2.0",
        lease_id="k3v9",
        started="5d1c9a02",
        dead_man_s=0.5,
        tick_s=0.02,
        speed_limit_m_s=2.0,
        turn_rate_limit_rad_s=1.0,
        style={"type": "style", **STYLE_SHOWN},
    )
    type: Literal["hello"] = "hello"
    version: str
    lease_id: str
    started: str = Field(description="another one: the server was restarted, and its world is new")
    dead_man_s: float
    tick_s: float
    speed_limit_m_s: float = SPEED_MAX
    turn_rate_limit_rad_s: float = TURN_RATE_MAX
    watches: bool = Field(False, description="this link may watch and stop, and nothing else")
    style: StyleFrame


class LeaseFrame(BaseModel):
    """Server to client on /drive: whenever who may drive changes."""

    model_config = example(
        type="lease", held=True, holder="k3v9", holder_title="a phone", stopped=False
    )
    type: Literal["lease"] = "lease"
    held: bool = Field(description="by this socket")
    holder: str | None
    holder_title: str | None = Field(description="the same for people")
    stopped: bool


class PongFrame(BaseModel):
    """Server to client on /drive: answers a ``ping``, behind whatever was still to be sent."""

    model_config = example(type="pong", sent_ms=8120.5, kept_ms=12.0)
    type: Literal["pong"] = "pong"
    sent_ms: float = Field(description="what the ping said")
    kept_ms: float = Field(description="how long the server kept it; the rest is the way")


class RefusedFrame(BaseModel):
    """Server to client on /drive: why a frame had no effect."""

    model_config = example(type="refused", seq=17, code="other_drives", reason="k3v9 is driving")
    type: Literal["refused"] = "refused"
    seq: int | None
    code: str = Field(description="which reason, for programs")
    reason: str = Field(description="the same, for people")
