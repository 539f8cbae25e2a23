"""What comes in is strict: nothing is clamped, nothing unknown passes."""

import json
from typing import Any

import pytest
from pydantic import ValidationError

from walking_console.planner.types import Command
from walking_console.server.schemas import (
    CLIENT_FRAMES,
    SEQUENCE_MAX,
    BadFrame,
    CommandBody,
    DriveFrame,
    TerrainBody,
    read_frame,
)

STICK = {"seq": 1, "echo_tick": 0, "crab_angle_rad": 0.5, "speed_m_s": 0.1, "turn_rate_rad_s": 0.0}


@pytest.mark.parametrize("kind", CLIENT_FRAMES)
def test_the_example_of_every_frame_reads_back_as_that_frame(kind: str) -> None:
    shape = CLIENT_FRAMES[kind]
    shown = shape.model_json_schema()["examples"][0]
    assert shown["type"] == kind and isinstance(read_frame(json.dumps(shown)), shape)


def test_a_frame_without_a_type_drives() -> None:
    frame = read_frame(json.dumps(STICK))
    assert isinstance(frame, DriveFrame) and frame.command() == Command(0.5, 0.1, 0.0)


@pytest.mark.parametrize(
    ("changes", "seq"),
    [({"speed_m_s": 9.0}, 1), ({"speed_m_s": 9.0, "seq": "1"}, None), ({"more": 1}, 1),
     ({"seq": SEQUENCE_MAX + 1}, None), ({"seq": True}, None), ({"type": "fly", "seq": 4}, 4)],
)  # fmt: skip
def test_what_is_no_frame_says_its_number_if_it_has_one(
    changes: dict[str, Any], seq: int | None
) -> None:
    with pytest.raises(BadFrame) as caught:
        read_frame(json.dumps(STICK | changes))
    assert caught.value.seq == seq


def test_a_shape_cannot_be_changed() -> None:
    body = CommandBody(ttl_s=0.5)
    with pytest.raises(ValidationError, match="frozen"):
        body.ttl_s = 1.0


@pytest.mark.parametrize(
    "body",
    [{"action": "dig"}, {"action": "raise", "cells": [[1, 1]]},
     {"action": "dig", "cells": [[1, 1]], "amount_m": 0.1},
     {"action": "dig", "cells": [[1, 1]], "circle": {"x_m": 0.0, "y_m": 0.0, "radius_m": 0.1}}],
)  # fmt: skip
def test_an_edit_has_one_place_and_an_amount_only_to_raise(body: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match="exactly one|amount_m"):
        TerrainBody.model_validate(body)
