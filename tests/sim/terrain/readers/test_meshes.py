"""Meshes seen from above: the upper surface, without holes at risers."""

import struct
from pathlib import Path

import numpy as np
import pytest

from tests.sim.terrain.readers.files import ground, of_fixture
from walking_console import load_scenario
from walking_console.sim.terrain.generators import GroundError
from walking_console.sim.world import prepare


def box(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
    import trimesh

    made = trimesh.creation.box(bounds=[low, high])
    return np.asarray(made.triangles)


def test_a_staircase_from_a_mesh_has_no_hole_at_its_risers_and_its_true_heights() -> None:
    made = of_fixture("stairs-as-stl")
    assert not np.isnan(made.heights).any()
    levels = sorted({round(float(z), 6) for z in made.heights.ravel()})
    assert levels == [0.0, 0.1, 0.2, 0.3]


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
def test_the_upper_surface_of_a_mesh_is_the_ground(tmp_path: Path, suffix: str) -> None:
    import trimesh

    floor = trimesh.creation.box(bounds=[[-2, -2, -0.1], [2, 2, 0.0]])
    step = trimesh.creation.box(bounds=[[0.5, -2, 0.0], [1.0, 2, 0.15]])
    trimesh.util.concatenate([floor, step]).export(tmp_path / f"m.{suffix}")
    made = ground(tmp_path / f"m.{suffix}")
    assert made.cell == 0.025 and made.bounds == pytest.approx((-2.0, 2.0, -2.0, 2.0))
    assert made.height_at(0.2, 0.3) == pytest.approx(0.0, abs=1e-6)
    assert made.height_at(0.7, 0.3) == pytest.approx(0.15, abs=1e-6)


def test_a_mesh_in_millimetres_is_brought_to_metres_by_scale(tmp_path: Path) -> None:
    triangles = box((-2000.0, -2000.0, -50.0), (2000.0, 2000.0, 0.0))
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles)
    (tmp_path / "m.stl").write_bytes(b" " * 80 + struct.pack("<I", len(triangles)) + facets)
    with pytest.raises(GroundError, match="set scale = 0.001 if it is in millimetres"):
        ground(tmp_path / "m.stl")
    made = ground(tmp_path / "m.stl", scale=0.001)
    assert made.bounds == pytest.approx((-2.0, 2.0, -2.0, 2.0)) and made.level == 0.0


@pytest.mark.parametrize("kind", ["stl_ascii", "stl", "ply", "obj"])
def test_a_mesh_that_is_inside_out_has_the_same_upper_surface(tmp_path: Path, kind: str) -> None:
    import trimesh

    mesh = trimesh.creation.box(bounds=[[-2, -2, 0.0], [2, 2, 0.3]])
    mesh.invert()
    name = f"m.{kind.removesuffix('_ascii')}"
    mesh.export(tmp_path / name, file_type=kind)
    assert ground(tmp_path / name).heights == pytest.approx(0.3, abs=1e-6)


def test_groups_materials_and_corners_counted_backwards_make_no_difference(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(
        "mtllib none.mtl\no ground\nv -2 -2 0\nv 0 -2 0\nv 0 2 0\nv -2 2 0\nusemtl red\n"
        "f 1 2 3 4\no step\ng a b\nv 0 -2 .1\nv 2 -2 .1\nv 2 2 .1\nv 0 2 .1\nvn 0 0 1\n"
        "f 5//1 6//1 7//1\nf -4//1 -2//1 -1//1\n"
    )
    made = ground(tmp_path / "m.obj")
    assert made.height_at(-1.0, 0.5) == 0.0 and made.height_at(1.0, 0.5) == pytest.approx(0.1)


STAIRS = [((k, -1.0, 0.0), (k + 1, 1.0, 0.1 * (k + 1))) for k in range(3)]


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
def test_a_mesh_with_y_up_asks_which_axis_is_and_is_turned(tmp_path: Path, suffix: str) -> None:
    import trimesh

    corners = np.concatenate([box(*step) for step in STAIRS]).reshape(-1, 3)
    lying = corners[:, [0, 2, 1]] * (1.0, 1.0, -1.0)
    made = trimesh.Trimesh(lying, np.arange(len(lying)).reshape(-1, 3), process=False)
    made.export(tmp_path / f"m.{suffix}")
    with pytest.raises(GroundError, match='faces y than z .* set up = "y", or up = "z"'):
        ground(tmp_path / f"m.{suffix}")
    turned = ground(tmp_path / f"m.{suffix}", up="y")
    rows = np.repeat([0.1, 0.2, 0.3], 40)
    np.testing.assert_allclose(turned.heights, np.tile(rows, (80, 1)), atol=1e-6)
    kept = ground(tmp_path / f"m.{suffix}", up="z")
    assert kept.bounds[3] - kept.bounds[2] == pytest.approx(0.3, abs=0.03)


def test_a_binary_stl_that_ends_too_early_says_so(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_bytes(b" " * 80 + struct.pack("<I", 3) + b"\0" * 100)
    with pytest.raises(GroundError, match="STL of 3 triangles has 234 bytes, it has 184"):
        ground(tmp_path / "m.stl")


def test_polygons_of_any_shape_are_filled_as_they_are_drawn(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(
        "v 0 -1 .1\nv 3 -1 .1\nv 3 1 .1\nv 0 1 .1\nf 1 2 3 4\nv 3 -1 .2\nv 3 1 .2\nv 2 1 .2\n"
        "v 2 0 .2\nv 0 0 .2\nv 0 -1 .2\nf 5 6 7 8 9 10\n"
    )
    heights = ground(tmp_path / "m.obj").heights
    wanted = np.full((80, 120), 0.1)
    wanted[:40], wanted[:, 80:] = 0.2, 0.2
    np.testing.assert_allclose(heights, wanted, atol=1e-6)


def test_points_without_triangles_are_refused(tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 3\n"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    (tmp_path / "m.ply").write_text(head + axes + "end_header\n0 0 0\n1 0 0\n0 1 0\n")
    with pytest.raises(GroundError, match="no triangles"):
        ground(tmp_path / "m.ply")


def test_a_mesh_that_begins_at_its_own_origin_is_walked_from_its_middle(tmp_path: Path) -> None:
    import trimesh

    corners = [[0, 0, 0], [6, 0, 0.18], [6, 5, 0.18], [0, 5, 0]]
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False).export(tmp_path / "h.stl")
    (tmp_path / "s.toml").write_text('[terrain]\nkind = "file"\nfile = "h.stl"\n', "utf-8")
    made = prepare(load_scenario(str(tmp_path / "s.toml"))).ground
    assert made.bounds == pytest.approx((-3.0, 3.0, -2.5, 2.5))
    kept = prepare(load_scenario(str(tmp_path / "s.toml"), ("start={x=3.0,y=2.5}",))).ground
    assert kept.bounds == pytest.approx((0.0, 6.0, 0.0, 5.0))
