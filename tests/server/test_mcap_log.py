"""A run as log viewers read it."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from tests.server.command_line import called
from walking_console.planner.geometry.transforms import rotation
from walking_console.server.mcap_log import orientation, step_message
from walking_console.server.mcap_schemas import SCHEMAS, Schema

PLAIN = {"number", "integer", "string", "boolean"}


@pytest.fixture(scope="module", params=["crab", "trace"])
def logged(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short walk of four or of six legs, as MCAP."""
    folder = tmp_path_factory.mktemp("mcap")
    machine = {"crab": "titan3", "trace": "hexapod"}[request.param]
    keys = (f"robot={machine}", f"planner={request.param}", "end={time=4.0}", "expect={}")
    words = [word for key in keys for word in ("--set", key)]
    run = called("run", "flat", "--out", folder / "run", "--trace-decisions", *words)
    assert run.exit_code == 0, run.output
    assert called("export", folder / "run", "--to", "mcap").exit_code == 0
    return folder / "run" / "run.mcap"


def messages(path: Path) -> Iterator[tuple[str, Schema, Any]]:
    """Topic, schema and content of every message."""

    def number_it_is(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None and schema.encoding == "jsonschema"
            content = json.loads(message.data, parse_constant=number_it_is)
            yield channel.topic, json.loads(schema.data), content


def undescribed(schema: Schema, content: Any, where: str = "") -> Iterator[str]:
    """Places of a message that its schema does not describe, or describes otherwise."""
    kind = schema.get("type")
    if kind == "object":
        missing = set(schema["required"]) - set(content)
        yield from (f"{where}.{key} lacks" for key in missing)
        for key, value in content.items():
            if key not in schema["properties"]:
                yield f"{where}.{key}"
            else:
                yield from undescribed(schema["properties"][key], value, f"{where}.{key}")
    elif kind == "array":
        for value in content:
            yield from undescribed(schema["items"], value, f"{where}[]")
    else:
        python = {"number": (int, float), "integer": int, "string": str, "boolean": bool}[kind]
        if not isinstance(content, python) or (kind != "boolean" and isinstance(content, bool)):
            yield f"{where} is no {kind}"


def test_every_key_of_every_message_stands_in_its_schema_with_its_type(logged: Path) -> None:
    topics = set()
    for topic, schema, content in messages(logged):
        topics.add(topic)
        assert list(undescribed(schema, content, topic)) == []
    assert topics == set(SCHEMAS)


def parts(schema: Schema) -> Iterator[Schema]:
    yield schema
    for inner in (*schema.get("properties", {}).values(), *filter(None, [schema.get("items")])):
        yield from parts(inner)


@pytest.mark.parametrize("topic", SCHEMAS)
def test_viewers_find_no_nested_array_no_union_and_no_null(topic: str) -> None:
    for part in parts(SCHEMAS[topic]):
        assert part["type"] in PLAIN | {"object", "array"}
        if part["type"] == "array":
            assert part["items"]["type"] in PLAIN | {"object"}
        if part["type"] == "object":
            assert part["properties"]
    assert SCHEMAS[topic]["title"]


def test_the_times_and_places_are_those_of_the_log(logged: Path) -> None:
    with np.load(logged.parent / "ticks.npz", allow_pickle=False) as log:
        feet, body = log["feet"], log["body"]
    ticks = [content for topic, _, content in messages(logged) if topic == "/tick"]
    assert len(ticks) == len(feet) == 200
    assert list(ticks[-1]["feet"][1].values()) == feet[-1][1].tolist()
    frames = [content for topic, _, content in messages(logged) if topic == "/tf"]
    last = frames[-1]["transforms"]
    assert [frame["child_frame_id"] for frame in last][:2] == ["body", "foot1"]
    assert list(last[0]["translation"].values()) == body[198][:3].tolist()


def test_the_ground_is_the_one_of_the_run(logged: Path) -> None:
    grid = next(content for topic, _, content in messages(logged) if topic == "/ground")
    heights = np.frombuffer(base64.b64decode(grid["data"]), "<f4")
    with np.load(logged.parent / "terrain.npz", allow_pickle=False) as terrain:
        assert heights.tolist() == terrain["heights"].ravel().tolist()
        assert grid["row_stride"] == 4 * terrain["heights"].shape[1]


def test_a_step_leaves_out_what_it_lacks_and_says_its_decision_as_text() -> None:
    step = {"index": 0, "landing": None, "search_start": [1, 2, 3], "decision": {"a": [[1]]}}
    assert step_message(step) == {
        "index": 0,
        "search_start": {"x": 1.0, "y": 2.0, "z": 3.0},
        "decision": '{"a": [[1]]}',
    }


def test_a_quaternion_turns_like_the_angles() -> None:
    angles = (0.3, -0.4, 1.2)
    q = orientation(*angles)
    x, y, z, w = q["x"], q["y"], q["z"], q["w"]
    assert math.hypot(x, y, z, w) == pytest.approx(1.0)
    turned = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    assert turned == pytest.approx([row[0] for row in rotation(*angles)])
