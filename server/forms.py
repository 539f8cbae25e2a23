"""The files of a multipart form: what browsers and ``curl -F`` send."""

from __future__ import annotations

from email import policy
from email.parser import BytesParser
from pathlib import PurePosixPath, PureWindowsPath
from typing import NamedTuple

FILES_MAX = 20  # of one form


class FormFault(ValueError):
    """A form that holds no file, or too many."""


class FormFile(NamedTuple):
    """A file of a form: its own plain name, without folders, and what is in it."""

    name: str
    body: bytes


def is_form(content_type: str) -> bool:
    """True of the type that browsers send files in."""
    return content_type.lower().startswith("multipart/form-data")


def files_of(content_type: str, body: bytes) -> list[FormFile]:
    """Every file of a form, in order; fields without a file name are passed over (RFC 7578).

    Raises ``FormFault``.
    """
    head = f"Content-Type: {content_type}\r\n\r\n".encode("latin-1", "replace")
    message = BytesParser(policy=policy.HTTP).parsebytes(head + body)
    files = []
    for part in message.iter_parts():
        name = part.get_filename()
        content = part.get_payload(decode=True)
        if name and isinstance(content, bytes):
            files.append(FormFile(PurePosixPath(PureWindowsPath(name).as_posix()).name, content))
    if not files:
        raise FormFault("the form holds no file: send one as `curl -F file=@ground.png` does")
    if len(files) > FILES_MAX:
        raise FormFault(f"the form holds {len(files)} files; at most {FILES_MAX} at a time")
    return files
