"""Reading back what is written as binary glTF."""

import json
import struct

import numpy as np


def contents(data: bytes) -> tuple[dict, bytes]:
    """The description and the buffer of a file that has both chunks."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def accessor(data: bytes, index: int, kind: type, width: int) -> np.ndarray:
    """The rows of one accessor."""
    scene, binary = contents(data)
    view = scene["bufferViews"][scene["accessors"][index]["bufferView"]]
    raw = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return np.frombuffer(raw, kind).reshape(-1, width)


def triangles(data: bytes, primitive: int = 0) -> np.ndarray:
    """Corners of a primitive's triangles, (n, 3, 3)."""
    part = contents(data)[0]["meshes"][0]["primitives"][primitive]
    points = accessor(data, part["attributes"]["POSITION"], np.float32, 3)
    return points[accessor(data, part["indices"], np.uint32, 3)]
