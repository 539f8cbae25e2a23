"""Terrain edits as they come in."""

import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from walking_console.server.api.terrain_edits import EDITS_A_TICK, painted
from walking_console.server.realtime_loop import RealtimeLoop


@pytest.mark.parametrize(
    ("place", "cells"),
    [
        ({"circle": {"x_m": 2.0, "y_m": 1.0, "radius_m": 0.3}}, None),
        ({"cells": [[5, 7], [6, 7]]}, 2),
    ],
)
def test_ground_is_dug_under_a_circle_and_by_cells(
    client: TestClient, loop: RealtimeLoop, place: dict[str, Any], cells: int | None
) -> None:
    before = np.isnan(loop.newest.terrain.heights).sum()
    answer = client.patch("/api/v1/console/terrain", json={"action": "dig", **place}).json()
    loop.tick()
    assert (
        np.isnan(loop.newest.terrain.heights).sum() - before
        == answer["cells"]
        == (cells or answer["cells"])
    )


def test_ground_is_raised_forbidden_and_cleared(client: TestClient, loop: RealtimeLoop) -> None:
    square = {"rectangle": {"x_m": 2.0, "y_m": 1.0, "width_m": 0.4, "depth_m": 0.4}}
    client.patch("/api/v1/console/terrain", json={"action": "raise", "amount_m": 0.1, **square})
    loop.tick()
    terrain = loop.newest.terrain
    assert np.nanmax(terrain.heights) == pytest.approx(0.1)
    client.patch("/api/v1/console/terrain", json={"action": "forbid", **square})
    loop.tick()
    marked = int(loop.newest.terrain.forbidden.sum())
    client.patch("/api/v1/console/terrain", json={"action": "clear", **square})
    loop.tick()
    assert int(loop.newest.terrain.forbidden.sum()) < marked


def test_a_touch_of_a_brush_is_a_terrain_edit() -> None:
    lowered = painted("lower", 1.0, 2.0, 0.12)
    assert lowered.action == "raise" and lowered.amount_m is not None and lowered.amount_m < 0.0
    assert painted("dig", 1.0, 2.0, 0.12).amount_m is None


def test_edits_that_come_faster_than_ticks_wait_for_one(
    client: TestClient, loop: RealtimeLoop
) -> None:
    waiting = []
    for column in range(10, 10 + 3 * EDITS_A_TICK):
        body = {"action": "dig", "cells": [[10, column]]}
        assert client.patch("/api/v1/console/terrain", json=body).status_code == 200
        waiting.append(loop.requests_waiting)
    assert max(waiting) == EDITS_A_TICK
    loop.tick()
    assert np.isnan(loop.newest.terrain.heights[10, 10 : 10 + 3 * EDITS_A_TICK]).all()


def test_of_a_wide_map_any_cell_is_changed_and_the_window_says_where_it_lies(
    client: TestClient, loop: RealtimeLoop
) -> None:
    wide = {"terrain": {"kind": "rough", "map_size": [200.0, 200.0]}, "robot": "titan3"}
    answer = client.put("/api/v1/console/scenario", json={"scenario": wide})
    assert answer.status_code == 200, answer.text
    circle = {"x_m": 80.0, "y_m": -80.0, "radius_m": 0.3}
    answer = client.patch("/api/v1/console/terrain", json={"action": "dig", "circle": circle})
    loop.tick()
    whole = loop.newest.terrain.whole
    assert whole is not None and answer.json()["cells"] > 300
    around = whole.read(slice(780, 820), slice(7180, 7220))
    assert np.isnan(around).sum() == answer.json()["cells"]
    outside = {"action": "dig", "cells": [[8000, 0]]}
    assert client.patch("/api/v1/console/terrain", json=outside).status_code == 422
    packed = np.load(io.BytesIO(client.get("/api/v1/console/terrain.npz").content))
    row, column, rows, columns = packed["place"].tolist()
    assert (rows, columns) == (8000, 8000)
    assert packed["origin"].tolist() == pytest.approx([column * 0.025 - 100, row * 0.025 - 100])
