"""The schemas of an MCAP log: every key has a type, so that viewers list every field."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from walking_console.server import mcap_schemas
from walking_console.server.mcap_schemas import SCHEMAS, many, number, shape, text, whole

# keys and types of @foxglove/schemas 2.1.0 (npm)
PUBLISHED = json.loads(
    (Path(__file__).parents[1] / "fixtures" / "foxglove-schemas" / "2.1.0.json").read_text()
)
WHOLE_MESSAGES = ("TICK_SCHEMA", "STEP_SCHEMA", "FRAME_TRANSFORMS", "SCENE_UPDATE", "GRID")


def parts(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A schema and all it is made of."""
    yield schema
    for part in schema.get("properties", {}).values():
        yield from parts(part)
    if "items" in schema:
        yield from parts(schema["items"])


@pytest.mark.parametrize("name", WHOLE_MESSAGES)
def test_every_part_of_a_message_has_one_type_and_every_object_its_keys(name: str) -> None:
    for part in parts(getattr(mcap_schemas, name)):
        assert isinstance(part["type"], str)
        assert part["type"] != "object" or part["properties"]


@pytest.mark.parametrize("name", WHOLE_MESSAGES)
def test_no_array_holds_arrays(name: str) -> None:
    for part in parts(getattr(mcap_schemas, name)):
        assert part["type"] != "array" or part["items"]["type"] != "array"


def test_an_object_requires_what_is_not_optional() -> None:
    made = shape("thing", optional="b", a=number("m"), b=text(), c=many(whole()))
    assert made["title"] == "thing" and made["required"] == ["a", "c"]
    assert made["properties"]["a"] == {"type": "number", "description": "m"}
    assert made["properties"]["c"] == {"type": "array", "items": {"type": "integer"}}


def tree(schema: dict[str, Any]) -> Any:
    """The keys of a schema down to the types of their values."""
    if schema["type"] == "object":
        return {key: tree(part) for key, part in schema["properties"].items()}
    if schema["type"] == "array":
        return [tree(schema["items"])]
    return schema.get("contentEncoding", schema["type"])


def foreign(ours: Any, theirs: Any, where: str) -> Iterator[str]:
    """Places of a tree of keys that are not in another, or of another type there."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        for key, part in ours.items():
            yield from foreign(part, theirs.get(key, "nothing"), f"{where}.{key}")
    elif isinstance(ours, list) and isinstance(theirs, list):
        yield from foreign(ours[0], theirs[0], f"{where}[]")
    elif ours != theirs:
        yield f"{where}: {ours} where Foxglove has {theirs}"


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_key_of_a_foxglove_message_is_one_that_foxglove_publishes(name: str) -> None:
    ours = tree(next(each for each in SCHEMAS.values() if each["title"] == name))
    assert not list(foreign(ours, PUBLISHED[name], name))
    assert ours.keys() == PUBLISHED[name].keys()
