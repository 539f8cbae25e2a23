"""TOML files as people's editors save them: UTF-8 with or without a byte order mark, UTF-16, any
line ends, a suffix in any case.
"""

from __future__ import annotations

import codecs
import tomllib
from pathlib import Path
from typing import Any

FILE_BYTES_MAX = 1_000_000
SUFFIX = ".toml"
MARKS = (  # a byte order mark says how the rest is written
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
BACKSLASH = (
    "; a backslash begins an escape in a double-quoted string: write 'C:\\folder\\file' in single "
    "quotes, or C:/folder/file"
)


class TomlFileError(ValueError):
    """A file that holds no TOML; the message is one clear line."""


def names_toml_file(name: str) -> bool:
    """Whether a name is that of a TOML file, in letters of any case."""
    return name.lower().endswith(SUFFIX)


def is_file(path: Path) -> bool:
    """Whether a file is there to be read; a path that no system could have names none."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long a name, a folder nobody may look into, a null
        return False


def read_toml(path: Path, what: str, bytes_max: int = FILE_BYTES_MAX) -> dict[str, Any]:
    """The tables of a TOML file; ``what`` names it in a refusal. Raises ``TomlFileError``."""
    return parse_toml(read_text(path, what, bytes_max), what)


def read_text(path: Path, what: str, bytes_max: int) -> str:
    """The text of a file, with line ends of one kind. Raises ``TomlFileError``."""
    try:
        if path.stat().st_size > bytes_max:
            raise TomlFileError(f"{what} is larger than {bytes_max} bytes")
        data = path.read_bytes()
    except OSError as error:
        raise TomlFileError(f"cannot read {what}: {error}") from None
    return _decoded(data, what)


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """The tables of a text; ``what`` names it in a refusal. Raises ``TomlFileError``."""
    try:
        return tomllib.loads(text)
    # TOMLDecodeError, and integers of thousands of digits
    except (ValueError, RecursionError) as error:
        said = str(error)
        lowered = said.lower()
        hint = BACKSLASH if "escape" in lowered or "hex value" in lowered else ""
        raise TomlFileError(f"{what} is not valid TOML: {said}{hint}") from None


def _decoded(data: bytes, what: str) -> str:
    """Text of any of the encodings that editors save by themselves."""
    mark, encoding = next(
        (entry for entry in MARKS if data.startswith(entry[0])), (b"", _unmarked(data))
    )
    try:
        text = data[len(mark) :].decode(encoding)
    except UnicodeDecodeError as error:
        raise TomlFileError(
            f"cannot read {what}: byte {error.start} is not {encoding.upper()}; save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _unmarked(data: bytes) -> str:
    """The encoding of a file without a mark: TOML begins with ASCII, of which UTF-16 makes a null
    beside the letter.
    """
    if data[1:2] == b"\0":
        return "utf-16-le"
    return "utf-16-be" if data[:1] == b"\0" else "utf-8"
