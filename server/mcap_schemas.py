"""What the messages of an MCAP log hold, as JSON schemas that log viewers can read: every key with
one type, no nested arrays, no unions, no nulls.

Those that begin with ``foxglove.`` are the well-known ones (docs.foxglove.dev, "schemas"): a viewer
draws them without being told how.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Schema = dict[str, Any]


def shape(title: str = "", /, *, optional: str = "", **keys: Schema) -> Schema:
    """An object with these keys; all but the ``optional`` ones are always there."""
    named = {"title": title} if title else {}
    required = [key for key in keys if key not in optional.split()]
    return {"type": "object", **named, "properties": keys, "required": required}


def many(item: Schema) -> Schema:
    return {"type": "array", "items": item}


def number(meaning: str = "") -> Schema:
    return {"type": "number", "description": meaning} if meaning else {"type": "number"}


def whole(meaning: str = "") -> Schema:
    return {"type": "integer", "description": meaning} if meaning else {"type": "integer"}


def text(meaning: str = "") -> Schema:
    return {"type": "string", "description": meaning} if meaning else {"type": "string"}


FLAG: Schema = {"type": "boolean"}
BYTES: Schema = {"type": "string", "contentEncoding": "base64"}
POINT = shape(x=number("m"), y=number("m"), z=number("m"))

TICK_SCHEMA = shape(
    "walking_console.tick",
    optional="margin polygon_margin",
    t=number("s of simulated time"),
    body=shape(
        x=number("m"),
        y=number("m"),
        z=number("m"),
        roll=number("rad"),
        pitch=number("rad"),
        yaw=number("rad"),
    ),
    feet=many(POINT),
    contact=many(FLAG),
    support=many(FLAG),
    margin=number("longitudinal margin, m; left out where there is none"),
    polygon_margin=number("m; left out where there is none"),
    command=shape(
        crab_angle_rad=number("rad"), speed_m_s=number("m/s"), turn_rate_rad_s=number("rad/s")
    ),
    step=whole("steps begun"),
    mode=text(),
)
STEP_MAY_LACK = (
    "g0 g s0 crab_angle search_start landing planned_landing landings planned_margin_min "
    "speed speed_max off_standard decision"
)
STEP_SCHEMA = shape(
    "walking_console.step",
    optional=STEP_MAY_LACK,
    index=whole(),
    tick=whole("in which the step was over"),
    tick_begun=whole(),
    swing=many(whole("leg, from 1")),
    g0=number("m"),
    g=number("m"),
    s0=number("m"),
    crab_angle=number("rad"),
    search_start=POINT,
    landing=POINT,
    planned_landing=POINT,
    landings=many(POINT),
    planned_margin_min=number("m"),
    speed=number("m/s"),
    speed_max=number("m/s"),
    off_standard=number("m"),
    decision=text("why, as JSON"),
)

TIME = shape("time", sec=whole(), nsec=whole())
DURATION = shape("duration", sec=whole(), nsec=whole())
VECTOR = shape("foxglove.Vector3", x=number(), y=number(), z=number())
QUATERNION = shape("foxglove.Quaternion", x=number(), y=number(), z=number(), w=number())
POSE = shape("foxglove.Pose", position=VECTOR, orientation=QUATERNION)
COLOUR = shape("foxglove.Color", r=number(), g=number(), b=number(), a=number())
PAIR = shape("foxglove.KeyValuePair", key=text(), value=text())
CUBE = shape("foxglove.CubePrimitive", pose=POSE, size=VECTOR, color=COLOUR)
SPHERE = shape("foxglove.SpherePrimitive", pose=POSE, size=VECTOR, color=COLOUR)
LINE = shape(
    "foxglove.LinePrimitive",
    type=whole("0: strip, 1: loop"),
    pose=POSE,
    thickness=number("m"),
    scale_invariant=FLAG,
    points=many(shape("foxglove.Point3", x=number(), y=number(), z=number())),
    color=COLOUR,
    colors=many(COLOUR),
    indices=many(whole()),
)
OTHERS = ("arrows", "cylinders", "triangles", "texts", "models")  # primitives we draw none of

FRAME_TRANSFORM = shape(
    "foxglove.FrameTransform",
    timestamp=TIME,
    parent_frame_id=text(),
    child_frame_id=text(),
    translation=VECTOR,
    rotation=QUATERNION,
)
FRAME_TRANSFORMS = shape("foxglove.FrameTransforms", transforms=many(FRAME_TRANSFORM))
SCENE_ENTITY = shape(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=text(),
    id=text(),
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=many(PAIR),
    cubes=many(CUBE),
    spheres=many(SPHERE),
    lines=many(LINE),
    **{name: many(shape(pose=POSE)) for name in OTHERS},  # type: ignore[arg-type]
)
DELETION = shape("foxglove.SceneEntityDeletion", timestamp=TIME, type=whole(), id=text())
SCENE_UPDATE = shape("foxglove.SceneUpdate", deletions=many(DELETION), entities=many(SCENE_ENTITY))
FIELD = shape("foxglove.PackedElementField", name=text(), offset=whole(), type=whole())
GRID = shape(
    "foxglove.Grid",
    timestamp=TIME,
    frame_id=text(),
    pose=POSE,
    column_count=whole(),
    cell_size=shape("foxglove.Vector2", x=number(), y=number()),
    row_stride=whole("bytes"),
    cell_stride=whole("bytes"),
    fields=many(FIELD),
    data=BYTES,
)
# by topic
SCHEMAS: Mapping[str, Schema] = {
    "/tick": TICK_SCHEMA,
    "/step": STEP_SCHEMA,
    "/tf": FRAME_TRANSFORMS,
    "/scene": SCENE_UPDATE,
    "/ground": GRID,
}
