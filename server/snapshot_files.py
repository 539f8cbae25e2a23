"""Snapshots in a file, for a child that draws them: plain data in msgpack, read back by the types
of the fields, so that no such file can be made to run anything.
"""

from __future__ import annotations

import typing
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from walking_console.sim.snapshot import Snapshot

# fields that hold the same object over many snapshots: written once, and one object again when read
SHARED = ("machine", "terrain", "plan", "ahead")


def put_away(snapshots: Iterable[Snapshot], path: Path) -> None:
    """Leave snapshots in a file; raises ``OSError``."""
    objects: list[tuple[str, Any]] = []
    places: dict[int, int] = {}
    rows: list[dict[str, Any]] = []
    for snapshot in snapshots:
        row = {field.name: getattr(snapshot, field.name) for field in fields(snapshot)}
        for name in SHARED:
            value = row[name]
            row[name] = places.setdefault(id(value), len(objects))
            if row[name] == len(objects):
                objects.append((name, value))
        rows.append(row)
    path.write_bytes(msgspec.msgpack.encode((objects, rows), enc_hook=_packed))


def taken_out(path: Path) -> tuple[Snapshot, ...]:
    """The snapshots of such a file; raises ``OSError``, and ``msgspec.MsgspecError`` for any other
    file.
    """
    decode = {
        name: msgspec.msgpack.Decoder(kind, dec_hook=_array).decode
        for name, kind in typing.get_type_hints(Snapshot).items()
    }
    wanted = tuple[list[tuple[str, msgspec.Raw]], list[dict[str, msgspec.Raw]]]
    objects, rows = msgspec.msgpack.decode(path.read_bytes(), type=wanted)
    shared = [decode[name](packed) for name, packed in objects]
    return tuple(
        Snapshot(
            **{
                name: shared[msgspec.msgpack.decode(packed, type=int)]
                if name in SHARED
                else decode[name](packed)
                for name, packed in row.items()
            }
        )
        for row in rows
    )


def _packed(value: Any) -> Any:
    """An array as its type, shape and bytes; a number of numpy as a number."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(f"{type(value)} is no plain data")


def _array(kind: Any, packed: Any) -> Any:
    """Such an array again, write-protected."""
    if typing.get_origin(kind) is not np.ndarray:
        raise NotImplementedError(f"{kind} is no plain data")
    dtype, shape, content = packed
    return np.frombuffer(content, dtype=dtype).reshape(shape)
