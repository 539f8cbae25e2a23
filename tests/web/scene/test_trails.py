"""Trails: only what grew is sent, the oldest goes, and another run begins with none."""

from dataclasses import replace

import pytest
import viser

from tests.web.scene.snapshots import level, standing
from walking_console.sim.snapshot import Snapshot
from walking_console.web.scene.palette import LEGS, for_scene
from walking_console.web.scene.terrain_tiles import TerrainTiles
from walking_console.web.scene.trails import Trail, Trails

RED = (255, 0, 0)


@pytest.fixture
def terrain(server: viser.ViserServer) -> TerrainTiles:
    tiles = TerrainTiles(server)
    tiles.draw(level())
    return tiles


def moved(x: float, time: float) -> Snapshot:
    """Standing x farther on."""
    snapshot = standing()
    feet = tuple((a + x, b, c) for a, b, c in snapshot.feet)
    return replace(snapshot, time=time, body=(x, 0.0, 0.85, 0.0, 0.0, 0.0), feet=feet)


def piece(k: int) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    return (float(k), 0.0, 0.0), (float(k + 1), 0.0, 0.0)


def test_only_the_chunk_being_filled_is_sent_again(server: viser.ViserServer) -> None:
    trail = Trail(server.scene, "/trail", size=2, chunks=3, thickness=0.01)
    trail.changes()
    for k in range(3):
        trail.add(*piece(k), RED)
    assert {handle.name for handle, _, _ in trail.changes()} == {"/trail_0", "/trail_1"}
    trail.add(*piece(3), RED)
    assert {handle.name for handle, _, _ in trail.changes()} == {"/trail_1"}


def test_the_oldest_chunk_is_taken_for_reuse(server: viser.ViserServer) -> None:
    trail = Trail(server.scene, "/trail", size=2, chunks=3, thickness=0.01)
    for k in range(7):
        trail.add(*piece(k), RED)
    starts = sorted(start[0] for chunk in trail.pieces for start, _ in chunk)
    assert starts == [2.0, 3.0, 4.0, 5.0, 6.0]


def test_every_foot_leaves_its_own_colour(server: viser.ViserServer, terrain: TerrainTiles) -> None:
    trails = Trails(server, standing().machine)
    trails.changes(moved(0.0, 0.0), terrain)
    trails.changes(moved(0.1, 1.0), terrain)
    assert trails.feet.colours[0] == [for_scene(colour) for colour in LEGS[:4]]
    assert len(trails.body.pieces[0]) == 1


def test_trails_are_sent_a_few_times_a_second(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    trails = Trails(server, standing().machine)
    sent = [bool(trails.changes(moved(0.1 * k, 0.05 * k), terrain)) for k in range(9)]
    assert sent == [True, False, False, False, True, False, False, False, True]


def test_another_run_begins_without_trails(
    server: viser.ViserServer, terrain: TerrainTiles
) -> None:
    trails = Trails(server, standing().machine)
    for k in range(5):
        trails.changes(moved(0.1 * k, 1.0 * k), terrain)
    trails.forget()
    changes = trails.changes(moved(0.0, 0.0), terrain)
    assert all(value is False for _, name, value in changes if name == "visible")
    assert {name for _, name, _ in changes} == {"visible"}
