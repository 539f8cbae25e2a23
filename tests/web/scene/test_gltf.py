"""Binary glTF: linear colours, the triangles as given, and files even of nothing."""

import numpy as np
import pytest

from tests.web.scene.glb_files import accessor, contents, triangles
from walking_console.web.scene.gltf import Part, glb, linear

CORNERS = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.5)])
FACE = np.array([(0, 1, 2)])


def test_colours_are_linear_light() -> None:
    assert linear(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 0.21404, 1.0], abs=1e-5)
    material = contents(glb([Part(CORNERS, FACE, colour=(0.5, 0.0, 1.0))]))[0]["materials"][0]
    colour = material["pbrMetallicRoughness"]["baseColorFactor"]
    assert colour == pytest.approx([0.21404, 0.0, 1.0, 1.0], abs=1e-5)


def test_colours_of_vertices_are_linear_light_too_and_their_opacity_is_kept() -> None:
    shades = np.array([(0.5, 0.0, 1.0, 0.5)] * 3)
    data = glb([Part(CORNERS, FACE, shades=shades)])
    scene, _ = contents(data)
    index = scene["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    assert accessor(data, index, np.uint8, 4)[0].tolist() == [55, 0, 255, 128]
    assert scene["materials"][0]["alphaMode"] == "BLEND"


def test_triangles_are_written_as_given() -> None:
    assert triangles(glb([Part(CORNERS, FACE)])) == pytest.approx(CORNERS[None])


def test_parts_without_triangles_leave_a_file_without_a_mesh() -> None:
    scene, _ = contents(glb([Part(np.zeros((0, 3)), np.zeros((0, 3), int))]))
    assert "meshes" not in scene


def test_a_picture_is_embedded_with_its_kind() -> None:
    png = b"\x89PNG" + bytes(8)
    uv = np.zeros((3, 2))
    scene, binary = contents(glb([Part(CORNERS, FACE, uv=uv, image=png, unlit=True)]))
    assert scene["images"][0]["mimeType"] == "image/png"
    view = scene["bufferViews"][scene["images"][0]["bufferView"]]
    assert binary[view["byteOffset"] :][: view["byteLength"]] == png
    assert "KHR_materials_unlit" in scene["materials"][0]["extensions"]
