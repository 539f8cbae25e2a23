"""Binary glTF, as little of it as the canvas needs: coloured, lit, unlit or textured triangles.

Written by hand because the ground wants unlit textures and the machine wants plain metal, and both
in a handful of bytes.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# glTF component types: float32, uint8, uint32
FLOAT = 5126
BYTE = 5121
INDEX = 5125
# glTF buffer targets
VERTICES = 34962
ELEMENTS = 34963
# glTF sampler words
LINEAR = 9729
NEAREST = 9728
MIPMAPS = 9987
CLAMP = 33071


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one material. Without ``normals`` they are shaded flat; ``unlit`` shows the
    colour as it is.
    """

    vertices: NDArray[np.floating[Any]]  # (V, 3)
    faces: NDArray[np.integer[Any]]  # (F, 3)
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)  # sRGB, 0-1
    opacity: float = 1.0
    metallic: float = 0.0
    roughness: float = 1.0
    glow: float = 0.0  # emitted share of the colour
    unlit: bool = False
    normals: NDArray[np.floating[Any]] | None = None  # (V, 3)
    shades: NDArray[np.floating[Any]] | None = None  # (V, 4) sRGB and opacity per vertex, 0-1
    uv: NDArray[np.floating[Any]] | None = None  # (V, 2), v down the image
    image: bytes | None = None  # PNG or JPEG
    crisp: bool = False  # enlarge the image without smoothing
    double: bool = False


def linear(srgb: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """sRGB 0-1 to linear light: glTF colours are linear, and look washed out when they are not."""
    colour = np.asarray(srgb, dtype=np.float64)
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def glb(parts: Sequence[Part]) -> bytes:
    """The parts as one binary glTF file with one node."""
    file = _File()
    primitives = [file.primitive(part) for part in parts if len(part.faces)]
    return file.bytes(primitives)


class _File:
    """Buffers and tables of one file while it is being written."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.tables: dict[str, list[dict[str, Any]]] = {
            name: []
            for name in ("bufferViews", "accessors", "materials", "images", "textures", "samplers")
        }

    def add(self, table: str, entry: dict[str, Any]) -> int:
        self.tables[table].append(entry)
        return len(self.tables[table]) - 1

    def view(self, content: bytes, target: int | None = None) -> int:
        entry: dict[str, Any] = {
            "buffer": 0,
            "byteOffset": len(self.data),
            "byteLength": len(content),
        }
        if target is not None:
            entry["target"] = target
        self.data += content + bytes(-len(content) % 4)
        return self.add("bufferViews", entry)

    def accessor(
        self, array: NDArray[Any], component: int, kind: str, target: int, **extra: Any
    ) -> int:
        entry = {
            "bufferView": self.view(array.tobytes(), target),
            "componentType": component,
            "count": len(array),
            "type": kind,
        }
        return self.add("accessors", {**entry, **extra})

    def primitive(self, part: Part) -> dict[str, Any]:
        points = np.ascontiguousarray(part.vertices, np.float32)
        bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        attributes = {"POSITION": self.accessor(points, FLOAT, "VEC3", VERTICES, **bounds)}
        if part.normals is not None:
            attributes["NORMAL"] = self.accessor(
                np.ascontiguousarray(part.normals, np.float32), FLOAT, "VEC3", VERTICES
            )
        if part.uv is not None:
            attributes["TEXCOORD_0"] = self.accessor(
                np.ascontiguousarray(part.uv, np.float32), FLOAT, "VEC2", VERTICES
            )
        if part.shades is not None:
            shades = np.array(part.shades, dtype=np.float64)
            shades[:, :3] = linear(shades[:, :3])
            packed = np.ascontiguousarray(np.clip(np.rint(shades * 255), 0, 255), np.uint8)
            attributes["COLOR_0"] = self.accessor(packed, BYTE, "VEC4", VERTICES, normalized=True)
        faces = self.accessor(
            np.ascontiguousarray(part.faces, np.uint32).reshape(-1), INDEX, "SCALAR", ELEMENTS
        )
        return {"attributes": attributes, "indices": faces, "material": self.material(part)}

    def material(self, part: Part) -> int:
        colour = linear(np.array(part.colour)).tolist()
        surface: dict[str, Any] = {
            "baseColorFactor": [*colour, part.opacity],
            "metallicFactor": part.metallic,
            "roughnessFactor": part.roughness,
        }
        if part.image is not None:
            surface["baseColorTexture"] = {"index": self.texture(part.image, part.crisp)}
        entry: dict[str, Any] = {"pbrMetallicRoughness": surface, "doubleSided": part.double}
        if part.opacity < 1.0 or (
            part.shades is not None and bool(np.any(part.shades[:, 3] < 1.0))
        ):
            entry["alphaMode"] = "BLEND"
        if part.glow:
            entry["emissiveFactor"] = [channel * part.glow for channel in colour]
        if part.unlit:
            entry["extensions"] = {"KHR_materials_unlit": {}}
        return self.add("materials", entry)

    def texture(self, image: bytes, crisp: bool) -> int:
        mime = "image/png" if image.startswith(b"\x89PNG") else "image/jpeg"
        source = self.add("images", {"bufferView": self.view(image), "mimeType": mime})
        filters = {
            "magFilter": NEAREST if crisp else LINEAR,
            "minFilter": MIPMAPS,
            "wrapS": CLAMP,
            "wrapT": CLAMP,
        }
        return self.add("textures", {"source": source, "sampler": self.add("samplers", filters)})

    def bytes(self, primitives: list[dict[str, Any]]) -> bytes:
        scene: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
        }
        if not primitives:
            scene.update(nodes=[{}])
        else:
            scene.update(
                meshes=[{"primitives": primitives}], buffers=[{"byteLength": len(self.data)}]
            )
            scene.update({name: rows for name, rows in self.tables.items() if rows})
            scene["extensionsUsed"] = ["KHR_materials_unlit"]
        text = json.dumps(scene, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self.data:
            chunks += struct.pack("<I4s", len(self.data), b"BIN\0") + bytes(self.data)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
