"""Whatever fits the document is answered as the document says, and whatever does not is refused:
every operation of OpenAPI, with bodies and parts of paths made from its own schemas.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.server.problem_json import problem_of
from walking_console.server.api.app import create_app
from walking_console.server.api.state import AppSettings
from walking_console.server.realtime_loop import RealtimeLoop

HERE = "http://127.0.0.1:8000"
METHODS = ("get", "put", "post", "patch", "delete")
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=6,
)
Schema = Mapping[str, Any]


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    from walking_console.sim.scenario_files import load_scenario
    from walking_console.sim.simulation import Simulation
    from walking_console.sim.world import prepare

    loop = RealtimeLoop(Simulation(prepare(load_scenario("flat"))))
    found: dict[str, Any] = create_app(loop, AppSettings(tmp_path_factory.mktemp("d"))).openapi()
    return found


@pytest.fixture
def api(loop: RealtimeLoop, tmp_path: Path) -> Iterator[TestClient]:
    app = create_app(loop, AppSettings(data=tmp_path))
    with TestClient(app, base_url=HERE, raise_server_exceptions=False) as client:
        yield client


def operations(document: Schema) -> list[tuple[str, str, Schema]]:
    return [
        (method, path, entry[method])
        for path, entry in document["paths"].items()
        for method in METHODS
        if method in entry
    ]


def without_children(document: Schema) -> list[tuple[str, str, Schema]]:
    """Those that begin no process: walks and drawings."""
    begin = {("post", "/api/v1/runs"), ("post", "/api/v1/sweeps")}
    drawn = ("get", "/api/v1/console/recording/replay.html")
    return [one for one in operations(document) if one[:2] not in {*begin, drawn}]


def resolved(schema: Schema, document: Schema) -> Schema:
    while "$ref" in schema:
        schema = document["components"]["schemas"][schema["$ref"].rsplit("/", 1)[1]]
    return schema


def values(schema: Schema, document: Schema) -> st.SearchStrategy[Any]:
    """Values that fit a schema."""
    schema = resolved(schema, document)
    if "const" in schema or "enum" in schema:
        return st.sampled_from(schema.get("enum", [schema.get("const")]))
    if "anyOf" in schema:
        return st.one_of([values(each, document) for each in schema["anyOf"]])
    match schema.get("type"):
        case "object":
            return objects(schema, document)
        case "array":
            least, most = schema.get("minItems", 0), schema.get("maxItems", 5)
            item = values(schema.get("items", {}), document)
            return st.lists(item, min_size=least, max_size=max(least, min(most, 5)))
        case "integer":
            return st.integers(schema.get("minimum"), schema.get("maximum"))
        case "number":
            return numbers(schema)
        case "string":
            return texts(schema)
        case "boolean":
            return st.booleans()
        case "null":
            return st.none()
    return ANYTHING


def objects(schema: Schema, document: Schema) -> st.SearchStrategy[Any]:
    keys = {key: values(each, document) for key, each in schema.get("properties", {}).items()}
    needed = {key: keys[key] for key in schema.get("required", ())}
    others = {key: each for key, each in keys.items() if key not in needed}
    return st.fixed_dictionaries(needed, optional=others)


def numbers(schema: Schema) -> st.SearchStrategy[Any]:
    least = schema.get("minimum", schema.get("exclusiveMinimum"))
    most = schema.get("maximum", schema.get("exclusiveMaximum"))
    return st.floats(
        least,
        most,
        exclude_min="exclusiveMinimum" in schema,
        exclude_max="exclusiveMaximum" in schema,
        allow_nan=False,
        allow_infinity=False,
    )


def texts(schema: Schema) -> st.SearchStrategy[str]:
    if "pattern" in schema:
        return st.from_regex(schema["pattern"], fullmatch=True)
    return st.text(max_size=min(30, schema.get("maxLength", 30)))


def fits(value: Any, schema: Schema, document: Schema) -> bool:
    """Whether an answer is what the document says."""
    schema = resolved(schema, document)
    if "anyOf" in schema:
        return any(fits(value, each, document) for each in schema["anyOf"])
    if "enum" in schema or "const" in schema:
        return value in schema.get("enum", [schema.get("const")])
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}
    kind = schema.get("type")
    if kind in ("number", "integer"):
        wanted = int if kind == "integer" else (int, float)
        return isinstance(value, wanted) and not isinstance(value, bool)
    if kind is not None and not isinstance(value, kinds[kind]):
        return False
    if kind == "array":
        return all(fits(each, schema.get("items", {}), document) for each in value)
    parts = schema.get("properties", {}) if kind == "object" else {}
    has_all = all(key in value for key in schema.get("required", ()))
    return has_all and all(
        fits(value[key], each, document) for key, each in parts.items() if key in value
    )


def body_schema(operation: Schema) -> Schema | None:
    content = operation.get("requestBody", {}).get("content", {})
    found: Schema | None = content.get("application/json", {}).get("schema")
    return found


def asked(data: st.DataObject, method: str, path: str, operation: Schema, document: Schema) -> Any:
    """A request that fits the document, or nearly."""
    query: dict[str, Any] = {}
    for one in operation.get("parameters", ()):
        value = data.draw(values(one.get("schema", {}), document))
        if one["in"] == "path":
            path = path.replace(f"{{{one['name']}}}", quote(str(value), safe="") or "a")
        elif one["in"] == "query" and value is not None:
            query[one["name"]] = value
    schema = body_schema(operation)
    body = None
    if schema is not None:
        body = data.draw(values(schema, document) if data.draw(st.booleans()) else ANYTHING)
    return {"method": method.upper(), "url": path, "params": query, "json": body}


@given(data=st.data())
@settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
def test_every_operation_answers_as_its_document_says(
    api: TestClient, document: dict[str, Any], data: st.DataObject
) -> None:
    method, path, operation = data.draw(st.sampled_from(without_children(document)))
    answer = api.request(**asked(data, method, path, operation, document))
    if answer.status_code >= 400:
        assert answer.status_code < 500 or answer.status_code in (503, 507)
        assert fits(problem_of(answer, answer.status_code), problem_schema(document), document)
        return
    responses = operation["responses"]
    assert str(answer.status_code) in responses
    content = responses[str(answer.status_code)].get("content", {})
    if answer.headers["content-type"] == "application/json" and "application/json" in content:
        assert fits(answer.json(), content["application/json"].get("schema", {}), document)


def problem_schema(document: Schema) -> Schema:
    found: Schema = document["components"]["schemas"]["Problem"]
    return found


def test_a_method_that_is_not_documented_is_answered_with_those_that_are(
    api: TestClient, document: dict[str, Any]
) -> None:
    for path, entry in document["paths"].items():
        documented = {method.upper() for method in METHODS if method in entry}
        for method in METHODS:
            if method in entry:
                continue
            url = path.replace("{run_id}", "a").replace("{sweep_id}", "a").replace("{name}", "b")
            answer = api.request(method.upper(), url)
            problem_of(answer, 405)
            assert documented <= set(answer.headers["allow"].split(", ")), (method, path)


def test_what_does_not_fit_is_seen() -> None:
    shape = {"type": "object", "properties": {"a": {"type": "integer"}}, "required": ["a"]}
    assert fits({"a": 1}, shape, {}) and not fits({}, shape, {})
    assert not fits({"a": True}, shape, {}) and not fits({"a": "1"}, shape, {})
    assert not fits([1, "2"], {"type": "array", "items": {"type": "number"}}, {})
    assert fits(None, {"anyOf": [{"type": "string"}, {"type": "null"}]}, {})
