"""Meshes seen from above: the upper surface, without holes at risers."""

import struct
from pathlib import Path

import numpy as np
import pytest

from tests.sim.terrain.readers.files import ground, of_fixture


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
    made = ground(tmp_path / "m.stl", scale=0.001)
    assert made.bounds == pytest.approx((-2.0, 2.0, -2.0, 2.0)) and made.level == 0.0
