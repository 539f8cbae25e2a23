"""The API's description: routes, and the frames of /drive, for which OpenAPI has no word."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from pydantic import BaseModel

from ..explanation_frames import AheadFrame, DecisionFrame
from ..frames import HelloFrame, LeaseFrame, PongFrame, RefusedFrame, SnapshotFrame, StyleFrame
from ..schemas import CLIENT_FRAMES

DESCRIPTION = """
Drive a simulated walking machine. SI units, with the unit in every key; strict: NaN, infinities,
booleans, numeric strings, unknown keys and out-of-range values are refused with
`application/problem+json`, nothing is clamped.

`WS /drive` carries JSON text frames both ways: `DriveFrame`, `PostureFrame`, `TakeFrame`,
`ReleaseFrame`, `StopFrame`, `RearmFrame`, `PingFrame` up; `HelloFrame`, `LeaseFrame`,
`RefusedFrame`, `SnapshotFrame`, `AheadFrame`, `DecisionFrame`, `StyleFrame`, `PongFrame` down (see
Schemas). A held stick is repeated 20 to 30 times a second; without a fresh frame the machine holds
after 0.5 s and sits down after 10 s.
"""
UP: tuple[type[BaseModel], ...] = tuple(CLIENT_FRAMES.values())
DOWN: tuple[type[BaseModel], ...] = (
    HelloFrame,
    LeaseFrame,
    RefusedFrame,
    SnapshotFrame,
    AheadFrame,
    DecisionFrame,
    StyleFrame,
    PongFrame,
)


def describe_frames(app: FastAPI) -> None:
    """Put the shapes of /drive among the schemas of this app."""
    plain = app.openapi

    def described() -> dict[str, Any]:
        if app.openapi_schema is None:
            _add_frames(plain())
        return app.openapi_schema or plain()

    app.openapi = described  # type: ignore[method-assign]


def _add_frames(schema: dict[str, Any]) -> None:
    known = schema.setdefault("components", {}).setdefault("schemas", {})
    for shape in (*UP, *DOWN):
        known[shape.__name__] = shape.model_json_schema(ref_template="#/components/schemas/{model}")
    schema["x-websockets"] = {
        "/drive": {
            "client-to-server": [shape.__name__ for shape in UP],
            "server-to-client": [shape.__name__ for shape in DOWN],
        }
    }
