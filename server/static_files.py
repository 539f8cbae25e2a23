"""Files of the page as answers: not sent again to a browser that has them, and packed where it
unpacks.
"""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from starlette.requests import Request
from starlette.responses import Response

FILES_KEPT = 128
PACKED_SUFFIXES = frozenset(".html .js .css .svg .json .map .txt .webmanifest".split())
PACKED_MIN = 500  # bytes; less is not worth it


class StaticFile(NamedTuple):
    """A file as it is sent; ``packed`` is None where packing gains nothing."""

    body: bytes
    packed: bytes | None
    etag: str
    media_type: str


def static_file(path: Path) -> StaticFile:
    """A file, read again when it has changed on the disk. Raises ``OSError``."""
    found = path.stat()
    return _read(path, found.st_mtime_ns, found.st_size)


@lru_cache(FILES_KEPT)
def _read(path: Path, changed: int, size: int) -> StaticFile:
    body = path.read_bytes()
    packs = path.suffix in PACKED_SUFFIXES and len(body) >= PACKED_MIN
    media_type = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    etag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    # without a time of packing: the same file is the same bytes
    return StaticFile(body, gzip.compress(body, 6, mtime=0) if packs else None, etag, media_type)


def answer_with(request: Request, file: StaticFile, headers: Mapping[str, str]) -> Response:
    """304 for who has it; else the file, packed for who can unpack it."""
    told = {**headers, "etag": file.etag, "vary": "accept-encoding"}
    if file.etag in _named(request.headers.get("if-none-match", "")):
        return Response(status_code=304, headers=told)
    if file.packed is not None and "gzip" in request.headers.get("accept-encoding", ""):
        told["content-encoding"] = "gzip"
        return Response(file.packed, headers=told, media_type=file.media_type)
    return Response(file.body, headers=told, media_type=file.media_type)


def _named(tags: str) -> list[str]:
    """The entity tags of an ``If-None-Match``; a proxy that packs anew has made them weak."""
    return [tag.strip().removeprefix("W/") for tag in tags.split(",")]
