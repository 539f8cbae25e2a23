"""A viser recording that is written while it is made: messages are packed as they come, so that an
hour takes no more memory than a minute.

The player, and so the layout of what it reads, is viser's own (``StateSerializer``); what is leaned
on beyond its public names is in this file alone, and ``tests/server/test_viser_recording.py`` holds
the two against each other.
"""

from __future__ import annotations

import base64
import hashlib
import tempfile
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import IO, Any, Self

import msgspec.msgpack
import viser
import zstandard
from viser.infra._infra import _remap_binary_placeholder_indices

# a recorded length or angle is a multiple of 1 / GRID: 0.06 mm, and far fewer bits to pack
GRID = 2.0**14
ALIGNMENT = 8  # bytes
CHUNK = 3 * 2**18  # bytes; a multiple of 3 is whole letters of base64
LEVEL = 9  # of zstandard
MESSAGES = b"\xdd"  # msgpack: an array with a length of 4 bytes
HEADER = b"\x84"  # msgpack: a map of four entries


class _Buffers:
    """What stands in for viser's list of arrays: each different one is kept once, on disk."""

    def __init__(self) -> None:
        self.file = tempfile.TemporaryFile()
        self.lengths: list[int] = []
        self.places: list[int] = []  # of every array that came: which of the kept ones it is
        self._known: dict[bytes, int] = {}

    def __len__(self) -> int:
        return len(self.places)

    def append(self, buffer: memoryview) -> None:
        data = bytes(buffer)
        digest = hashlib.blake2b(data, digest_size=16).digest()
        if digest not in self._known:
            self._known[digest] = len(self.lengths)
            self.lengths.append(len(data))
            self.file.write(data + b"\0" * (-len(data) % ALIGNMENT))
        self.places.append(self._known[digest])


class _Messages:
    """What stands in for viser's list of messages: each is packed and put on disk."""

    def __init__(self, buffers: _Buffers) -> None:
        self.file = tempfile.TemporaryFile()
        self.count = 0
        self._buffers = buffers
        self._pack = msgspec.msgpack.Encoder().encode

    def append(self, message: tuple[float, dict[str, Any]]) -> None:
        time, told = message
        _remap_binary_placeholder_indices(told, self._buffers.places)
        self.file.write(self._pack((time, on_grid(told) if time else told)))
        self.count += 1


def on_grid(value: Any) -> Any:
    """A message with every number that is not whole on the grid of ``GRID``."""
    if isinstance(value, float):
        return round(value * GRID) / GRID if abs(value) < GRID else value
    if isinstance(value, dict):
        return {key: on_grid(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [on_grid(item) for item in value]
    return value


class StreamedRecording:
    """Records what is drawn on a viser server from now on, until ``write_html`` or the end of the
    block it was made for.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._buffers = _Buffers()
        self._messages = _Messages(self._buffers)
        self._serializer = _untyped(server.get_scene_serializer())
        # what there is already was kept as objects: it comes first
        first: list[tuple[float, dict[str, Any]]] = self._serializer._messages
        arrays: list[memoryview] = self._serializer._binary_buffers
        self._serializer._binary_buffers = self._buffers  # viser calls len and append, no more
        self._serializer._messages = self._messages
        for array in arrays:
            self._buffers.append(array)
        for message in first:
            self._messages.append(message)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *why: object) -> None:
        self._stop()
        self._messages.file.close()
        self._buffers.file.close()

    def wait(self, seconds: float) -> None:
        """What is drawn next is seen so much later."""
        self._serializer.insert_sleep(seconds)

    def write_html(self, path: Path, title: str = "", panel: str = "") -> None:
        """One page that needs no other file, with a title and HTML over the scene. Raises
        ``OSError``.
        """
        self._stop()
        client = Path(viser.__file__).parent / "client" / "build" / "index.html"
        page = client.read_text("utf-8")
        if title:
            page = page.replace("<title>Viser</title>", f"<title>{escape(title)}</title>", 1)
        head_end = page.index("</head>")
        body_end = page.rindex("</body>")
        with path.open("w", encoding="utf-8") as file:
            file.write(page[:head_end])
            file.write('<script>window.__VISER_EMBED_DATA__="')
            for chunk in _whole_chunks(self._packed()):
                file.write(base64.b64encode(chunk).decode("ascii"))
            file.write('";window.__VISER_EMBED_CONFIG__={darkMode:true};</script>')
            file.write(page[head_end:body_end] + panel + page[body_end:])

    def _stop(self) -> None:
        handler = self._serializer._handler
        with handler._record_lock:
            if self._serializer in handler._record_handles:
                handler._record_handles.remove(self._serializer)

    def _packed(self) -> Iterator[bytes]:
        """The recording as the player reads it: the length, and everything packed."""
        head = self._head()
        messages = self._messages.file
        told = len(head) + messages.tell()
        padding = b"\0" * (-(8 + told) % ALIGNMENT) if self._buffers.lengths else b""
        tail = self._buffers.lengths[-1] % ALIGNMENT if self._buffers.lengths else 0
        spare = -tail % ALIGNMENT  # the last array is followed by nothing
        arrays = self._buffers.file.tell() - spare
        size = 8 + told + len(padding) + arrays
        packer = zstandard.ZstdCompressor(level=LEVEL).compressobj(size=size)
        yield size.to_bytes(8, "little")
        yield packer.compress(told.to_bytes(8, "little") + head)
        yield from map(packer.compress, _read(messages, messages.tell()))
        yield packer.compress(padding)
        yield from map(packer.compress, _read(self._buffers.file, arrays))
        yield packer.flush()

    def _head(self) -> bytes:
        pack = msgspec.msgpack.encode
        entries = {
            "durationSeconds": self._serializer._time,
            "viserVersion": viser.__version__,
            "binaryBufferLengths": self._buffers.lengths,
        }
        packed = b"".join(pack(key) + pack(value) for key, value in entries.items())
        count = MESSAGES + self._messages.count.to_bytes(4, "big")
        return HEADER + packed + pack("messages") + count


def _untyped(value: Any) -> Any:
    return value


def _read(file: IO[bytes], size: int) -> Iterator[bytes]:
    file.seek(0)
    while size > 0:
        chunk = file.read(min(CHUNK, size))
        size -= len(chunk)
        yield chunk


def _whole_chunks(parts: Iterator[bytes]) -> Iterator[bytes]:
    """The same bytes in pieces whose length is a multiple of three, but the last."""
    waiting = b""
    for part in parts:
        waiting += part
        whole = len(waiting) - len(waiting) % 3
        yield waiting[:whole]
        waiting = waiting[whole:]
    yield waiting
