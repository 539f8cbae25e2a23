"""The snapshot's frame is made from the snapshot's own fields: one list, seen everywhere."""

import dataclasses
import json
import math
from typing import Annotated, Any

import pytest
from fastapi.testclient import TestClient
from pydantic import TypeAdapter

from walking_console.planner.types import Command
from walking_console.server.frames import (
    SNAPSHOT_FIELDS,
    SnapshotFrame,
    form_of,
    frame_model,
    legs_in_the_air,
    snapshot_frame,
    wire_fields,
)
from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.snapshot import INSIDE, Sent, Snapshot
from walking_console.sim.world import World, prepare

# What pages and scripts have been promised: a key may be added, never changed.
PROMISED = """type tick time_s mode posture reason scenario robot planner planner_mode attitude body
feet contact support crab_angle_rad speed_m_s walked_m_s speed_max_m_s turn_rate_rad_s margin_m
polygon_margin_m energy_margin_m step swing distance_m course_m flags paused rate late_s stopped
fault""".split()


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class LargerSnapshot(Snapshot):
    """What somebody adds to the snapshot tomorrow, at one place."""

    feeler_margin: Annotated[float, Sent("feeler_margin_m", "to what is felt", 0.07)] = 0.07
    wheels: int = 0
    secret: Annotated[int, INSIDE] = 0


def walking(world: World) -> Simulation:
    simulation = Simulation(world)
    simulation.order(Command(0.2, 0.08, 0.01))
    for _ in range(60):
        simulation.step()
    return simulation


def test_no_promised_key_is_missing(flat: World) -> None:
    frame = snapshot_frame(Simulation(flat).snapshot(), stopped=False)
    assert set(PROMISED) <= set(frame)


@pytest.mark.parametrize("name", ["flat", "k-curve"])
def test_every_frame_fits_the_shape_that_openapi_shows(name: str) -> None:
    frame = snapshot_frame(walking(prepare(load_scenario(name))).snapshot(), stopped=True)
    assert SnapshotFrame.model_validate(frame, strict=True).model_dump() == frame
    json.dumps(frame, allow_nan=False)


def test_a_field_added_to_the_snapshot_shows_in_frame_shape_and_example(flat: World) -> None:
    now = Simulation(flat).snapshot()
    values = {f.name: getattr(now, f.name) for f in dataclasses.fields(now)}
    fields = wire_fields(LargerSnapshot)
    larger = LargerSnapshot(**values, feeler_margin=0.12345678, wheels=3)
    frame = {field.key: field.read(larger) for field in fields}
    assert frame["feeler_margin_m"] == 0.12346 and frame["wheels"] == 3
    shape = frame_model("Larger", "", fields, {}).model_json_schema()
    assert shape["properties"]["feeler_margin_m"]["description"] == "to what is felt"
    assert shape["examples"][0]["feeler_margin_m"] == 0.07 and "wheels" in shape["required"]
    assert "secret" not in frame and set(frame) == set(shape["properties"])


def test_every_field_of_the_snapshot_goes_out_or_says_that_it_stays_inside() -> None:
    outside = {field.key for field in SNAPSHOT_FIELDS}
    assert {"plan_time", "ready", "terrain", "whiskers", "ahead", "decision"}.isdisjoint(outside)
    assert len(outside) == len(SNAPSHOT_FIELDS), "two fields with one key"


def test_the_served_example_and_snapshot_have_the_same_keys(client: TestClient) -> None:
    shape = client.get("/openapi.json").json()["components"]["schemas"]["SnapshotFrame"]
    assert set(client.get("/api/v1/console").json()) == set(shape["examples"][0])
    SnapshotFrame.model_validate(shape["examples"][0])


def test_legs_are_numbered_from_one_outside(flat: World) -> None:
    plan = walking(flat).snapshot().plan
    assert plan is not None and legs_in_the_air(plan) == [leg + 1 for leg in plan.swing]
    assert legs_in_the_air(None) == []


def test_what_is_not_finite_goes_out_as_null(flat: World) -> None:
    snapshot = dataclasses.replace(Simulation(flat).snapshot(), margin=math.inf)
    assert snapshot_frame(snapshot, stopped=False)["margin_m"] is None


@pytest.mark.parametrize("annotation", [complex, dict[str, Any], tuple[object, ...]])
def test_a_type_nobody_has_told_how_to_send_is_refused_at_once(annotation: Any) -> None:
    with pytest.raises(TypeError, match="no form on the wire"):
        form_of(annotation)


def test_tuples_of_tuples_go_out_as_lists_of_lists() -> None:
    form = form_of(tuple[tuple[float, float], ...])
    out = form.convert(((0.1, 0.2), (1 / 3, math.inf)))
    assert out == [[0.1, 0.2], [0.33333, None]]
    assert TypeAdapter(form.kind).json_schema()["items"]["type"] == "array"


def test_only_the_last_line_of_a_failure_goes_out(flat: World) -> None:
    frame = snapshot_frame(
        Simulation(flat).snapshot(), stopped=False, fault="Traceback\n  file\nValueError: no\n"
    )
    assert frame["fault"] == "ValueError: no"
