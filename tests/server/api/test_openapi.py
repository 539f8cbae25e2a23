"""The description of the API is whole: every shape has an example that fits."""

from fastapi.testclient import TestClient

from walking_console.server import explanation_frames, frames, schemas


def test_every_body_and_frame_has_an_example(client: TestClient) -> None:
    schema = client.get("/openapi.json").json()
    for name, shape in schema["components"]["schemas"].items():
        if not name.startswith(("HTTPValidation", "ValidationError")):
            assert shape.get("examples"), name
    assert set(schema["x-websockets"]["/drive"]) == {"client-to-server", "server-to-client"}


def test_every_example_is_accepted_by_its_own_shape(client: TestClient) -> None:
    for name, shape in client.get("/openapi.json").json()["components"]["schemas"].items():
        model = next(
            (getattr(m, name) for m in (schemas, frames, explanation_frames) if hasattr(m, name)),
            None,
        )
        for example in shape.get("examples", ()):
            assert model is not None and model.model_validate(example)
