"""The schemas of an MCAP log: every key has a type, so that viewers list every field."""

from collections.abc import Iterator
from typing import Any

import pytest

from walking_console.server import mcap_schemas
from walking_console.server.mcap_schemas import many, number, shape, text, whole

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
