"""The ground of a wide map beyond the window: bounded, and without gaps."""

import numpy as np
import pytest
import viser

from walking_console.sim.scenario_files import load_scenario
from walking_console.sim.simulation import Simulation
from walking_console.sim.terrain.wide_map import WideMap
from walking_console.web.scene.far_terrain import QUADS, look_over, mesh_of, sheets_around
from walking_console.web.scene.terrain import EDGE_SHADE, TerrainMesh, Window
from walking_console.web.scene.terrain_texture import height_colours
from walking_console.web.scene.terrain_tiles import TerrainTiles

SHAPE = (8000, 8000)
WINDOW = (3680, 4288), (3680, 4288)


@pytest.mark.parametrize(
    "window", [WINDOW, ((0, 320), (0, 320)), ((7680, 8000), (4000, 4608)), ((0, 608), (0, 8000))]
)
def test_sheets_and_window_cover_every_cell_of_the_map_once(window) -> None:
    covered = np.zeros(SHAPE, dtype=np.int8)
    (r0, r1), (c0, c1) = window
    covered[r0:r1, c0:c1] = 1
    for sheet in sheets_around(window, SHAPE):
        covered[slice(*sheet.rows), slice(*sheet.columns)] += 1
    assert (covered == 1).all()


def test_however_large_the_map_the_sheets_are_few_and_their_quads_bounded() -> None:
    sheets = list(sheets_around(WINDOW, SHAPE))
    assert len(sheets) <= 24
    for sheet in sheets:
        for first, last in (sheet.rows, sheet.columns):
            assert (last - first) / sheet.step <= 3 * QUADS


def test_a_sheet_is_as_high_as_the_ground_in_its_middle_and_holes_are_hollows() -> None:
    heights = np.add.outer(np.arange(800.0), np.zeros(800))
    heights[:, 400] = np.nan
    whole = WideMap((800, 800), 0.1, (0.0, 0.0), lambda rows, columns: heights[rows, columns])
    sheet = next(sheets_around(((320, 480), (320, 480)), whole.shape))
    mesh = mesh_of(sheet, whole, 0.1, (-2.0, 800.0))
    assert mesh.cell == pytest.approx(0.1 * sheet.step) and not mesh.stepped
    assert mesh.heights[0, 0] == sheet.rows[0] + sheet.step // 2
    assert np.isfinite(mesh.heights).all()
    assert look_over(whole).shape == (115, 115)


def test_parts_have_sides_in_the_colours_of_their_ground_and_no_lines_where_cells_are_large() -> (
    None
):
    level, nothing = np.zeros((20, 20)), np.zeros((20, 20), dtype=bool)
    extent = Window(0, 20, 0, 20)
    for cell, lined in ((0.05, True), (0.4, False)):
        part = TerrainMesh(
            level, nothing, cell, (0.3, 0.3), (-0.2, 0.2), stepped=False, is_part=True
        )
        shades = part._rim(extent).shades
        assert shades is not None
        colour = EDGE_SHADE * height_colours(np.zeros(len(shades)), -0.2, 0.2)
        np.testing.assert_allclose(shades[:, :3], colour)
        assert (np.ptp(part.picture(extent)) > np.ptp(part.picture(extent)[0, 0]) + 1e-9) == lined


def test_when_the_window_moves_only_what_comes_into_it_and_lies_beside_it_is_sent(
    server: viser.ViserServer,
) -> None:
    terrain = "terrain={kind='rough', map_size=[200.0, 200.0]}"
    simulation = Simulation(load_scenario("rough", (terrain, "expect={}")))
    tiles = TerrainTiles(server)
    tiles.draw(simulation.snapshot().terrain)
    before = {name: tile.key for name, (tile, _) in tiles.tiles.items()}
    relief = tiles._relief
    simulation.drive(0.0, 0.15)
    corner = simulation.perception.ground.corner
    while simulation.perception.ground.corner == corner:
        simulation.step()
    tiles.draw(simulation.snapshot().terrain)
    after = {name: tile.key for name, (tile, _) in tiles.tiles.items()}
    same = [name for name in after if before.get(name) == after[name]]
    assert len(same) > len(after) / 3 and any(name.startswith("far_1") for name in same)
    assert tiles._relief == relief
    assert len(after) < 100
