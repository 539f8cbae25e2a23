"""A run as an MCAP file of JSON messages: what a log viewer plots, and what it draws."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walking_console.planner.geometry.transforms import quaternion
from walking_console.planner.types import TICK
from walking_console.sim.runs.run_files import (
    GROUND_DIMENSIONS,
    RunError,
    read_arrays,
    read_log,
    read_steps,
)

from .mcap_schemas import OTHERS, SCHEMAS

NANOSECONDS = 10**9  # in a second
SUMMARY = ("version", "result", "reason", "state_hash")
BODY = ("x", "y", "z", "roll", "pitch", "yaw")
COMMAND = ("crab_angle_rad", "speed_m_s", "turn_rate_rad_s")
POINTS = ("search_start", "landing", "planned_landing")
SCENE_EVERY = 3  # ticks between drawn moments
FLOAT32 = 7  # foxglove.NumericType
LOOP = 1  # foxglove.LinePrimitive
FOOT = 0.06  # m, diameter of a drawn foot at least
WORLD = "world"
TORSO = "body"
AMBER = {"r": 0.95, "g": 0.65, "b": 0.2, "a": 1.0}
GREEN = {"r": 0.3, "g": 0.8, "b": 0.5, "a": 1.0}
GREY = {"r": 0.55, "g": 0.6, "b": 0.65, "a": 0.9}

Message = dict[str, Any]
Log = Mapping[str, np.ndarray[Any, Any]]


class Stamped(NamedTuple):
    """A message, its topic and its time."""

    topic: str
    at: int  # ns
    message: Message


def write_mcap(
    directory: Path, summary: dict[str, Any], path: Path, modes: Mapping[int, str]
) -> None:
    """Topics /tick and /step (numbers), /tf, /scene and /ground (well-known shapes)."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise RunError(
            "writing mcap needs the extra: pip install 'walking-console[mcap]'"
        ) from None
    log = read_log(directory)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="walking-console")
        channels = {topic: _channel(writer, topic) for topic in SCHEMAS}
        for topic, at, message in _messages(directory, summary, log, modes):
            text = json.dumps(message, allow_nan=False)
            writer.add_message(channels[topic], at, text.encode(), at)
        writer.add_metadata("run", {key: str(summary[key]) for key in SUMMARY})
        writer.finish()  # type: ignore[no-untyped-call]


def _channel(writer: Any, topic: str) -> int:
    schema = SCHEMAS[topic]
    registered = writer.register_schema(
        name=schema["title"], encoding="jsonschema", data=json.dumps(schema).encode()
    )
    return int(writer.register_channel(topic=topic, message_encoding="json", schema_id=registered))


def _messages(
    directory: Path, summary: Mapping[str, Any], log: Log, modes: Mapping[int, str]
) -> Iterator[Stamped]:
    ground = read_arrays(directory / "terrain.npz", GROUND_DIMENSIONS)
    yield Stamped("/ground", 0, grid_message(ground))
    torso = [float(side) for side in summary["robot"]["torso"]]
    for row in range(len(log["t"])):
        at = round(float(log["t"][row]) * NANOSECONDS)
        yield Stamped("/tick", at, tick_message(log, row, modes))
        if row % SCENE_EVERY == 0:
            yield Stamped("/tf", at, transforms_message(log, row, at))
            yield Stamped("/scene", at, scene_message(log, row, at, torso))
    for step in read_steps(directory):
        yield Stamped("/step", round(step["tick"] * TICK * NANOSECONDS), step_message(step))


def tick_message(log: Log, row: int, modes: Mapping[int, str]) -> Message:
    """One row of the log; a margin that there is not is left out."""
    margins = {key: float(log[key][row]) for key in ("margin", "polygon_margin")}
    return {
        "t": float(log["t"][row]),
        "body": dict(zip(BODY, log["body"][row].tolist(), strict=True)),
        "feet": [_point(foot) for foot in log["feet"][row].tolist()],
        "contact": [bool(flag) for flag in log["contact"][row]],
        "support": [bool(flag) for flag in log["support"][row]],
        **{key: value for key, value in margins.items() if math.isfinite(value)},
        "command": dict(zip(COMMAND, log["command"][row].tolist(), strict=True)),
        "step": int(log["step"][row]),
        "mode": modes.get(int(log["mode"][row]), "?"),
    }


def step_message(step: Mapping[str, Any]) -> Message:
    """One executed step; what it lacks is left out, and its decision is JSON in a text."""
    message = {key: value for key, value in step.items() if value is not None}
    message |= {key: _point(message[key]) for key in POINTS if key in message}
    if "landings" in message:
        message["landings"] = [_point(landing) for landing in message["landings"]]
    if "decision" in message:
        message["decision"] = json.dumps(message["decision"])
    return {key: message[key] for key in SCHEMAS["/step"]["properties"] if key in message}


def transforms_message(log: Log, row: int, at: int) -> Message:
    """Where the body and every foot are, as frames."""
    x, y, z, *angles = log["body"][row].tolist()
    frames = [_transform(at, TORSO, (x, y, z), orientation(*angles))]
    level = orientation(0.0, 0.0, 0.0)
    for leg, foot in enumerate(log["feet"][row].tolist(), 1):
        frames.append(_transform(at, f"foot{leg}", foot, level))
    return {"transforms": frames}


def _transform(at: int, name: str, place: Sequence[float], turned: Message) -> Message:
    return {
        "timestamp": _time(at),
        "parent_frame_id": WORLD,
        "child_frame_id": name,
        "translation": _point(place),
        "rotation": turned,
    }


def scene_message(log: Log, row: int, at: int, torso: Sequence[float]) -> Message:
    """The torso, the feet, and the polygon of those that carry."""
    feet = log["feet"][row].tolist()
    carrying = [foot for foot, flag in zip(feet, log["support"][row], strict=True) if flag]
    size = {"x": FOOT, "y": FOOT, "z": FOOT}
    spheres = [
        {"pose": _pose(foot), "size": size, "color": GREEN if touches else AMBER}
        for foot, touches in zip(feet, log["contact"][row], strict=True)
    ]
    cube = {"pose": _pose((0.0, 0.0, 0.0)), "size": _point(torso), "color": GREY}
    entities = [
        _entity(at, TORSO, "torso", cubes=[cube]),
        _entity(at, WORLD, "feet", spheres=spheres, lines=[_polygon(carrying)]),
    ]
    return {"deletions": [], "entities": entities}


def _polygon(corners: Sequence[Sequence[float]]) -> Message:
    return {
        "type": LOOP,
        "pose": _pose((0.0, 0.0, 0.0)),
        "thickness": 0.01,
        "scale_invariant": False,
        "points": [_point(corner) for corner in corners],
        "color": GREEN,
        "colors": [],
        "indices": [],
    }


def _entity(at: int, frame: str, name: str, **primitives: list[Message]) -> Message:
    return {
        "timestamp": _time(at),
        "frame_id": frame,
        "id": name,
        "lifetime": _time(0),
        "frame_locked": True,
        "metadata": [],
        **{kind: [] for kind in ("cubes", "spheres", "lines", *OTHERS)},
        **primitives,
    }


def grid_message(ground: Log) -> Message:
    """The ground as it was at the end: a height for each cell."""
    heights = np.ascontiguousarray(ground["heights"], dtype="<f4")
    cell = float(ground["cell"])
    x, y = (float(part) for part in ground["origin"])
    return {
        "timestamp": _time(0),
        "frame_id": WORLD,
        "pose": _pose((x, y, 0.0)),
        "column_count": heights.shape[1],
        "cell_size": {"x": cell, "y": cell},
        "row_stride": heights.strides[0],
        "cell_stride": heights.itemsize,
        "fields": [{"name": "height", "offset": 0, "type": FLOAT32}],
        "data": base64.b64encode(heights.tobytes()).decode(),
    }


def orientation(roll: float, pitch: float, yaw: float) -> Message:
    """Yaw about z, then pitch about y, then roll about x, as the log has them."""
    w, x, y, z = quaternion(roll, pitch, yaw)
    return {"x": x, "y": y, "z": z, "w": w}


def _pose(place: Sequence[float]) -> Message:
    return {"position": _point(place), "orientation": orientation(0.0, 0.0, 0.0)}


def _point(place: Sequence[float]) -> Message:
    return dict(zip("xyz", map(float, place), strict=True))


def _time(at: int) -> Message:
    return {"sec": at // NANOSECONDS, "nsec": at % NANOSECONDS}
