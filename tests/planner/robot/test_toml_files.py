"""TOML files as editors save them."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest

from walking_console.planner.robot.toml_files import (
    FILE_BYTES_MAX,
    TomlFileError,
    is_file,
    names_toml_file,
    parse_toml,
    read_toml,
)

TEXT = 'title = "Grüße über die Böschung"\r\n[end]\r\ntime = 3.0\r\n'
READ = {"title": "Grüße über die Böschung", "end": {"time": 3.0}}


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode(),
        codecs.BOM_UTF8 + TEXT.encode(),
        TEXT.encode("utf-16"),
        codecs.BOM_UTF16_BE + TEXT.encode("utf-16-be"),
        TEXT.encode("utf-16-le"),
        TEXT.encode("utf-16-be"),
        TEXT.replace("\r\n", "\n").encode(),
        TEXT.replace("\r\n", "\r").encode(),
    ],
)
def test_a_file_says_the_same_in_every_encoding_and_with_every_line_end(
    data: bytes, tmp_path: Path
) -> None:
    (tmp_path / "a.toml").write_bytes(data)
    assert read_toml(tmp_path / "a.toml", "a file") == READ


def test_a_file_of_an_old_code_page_is_told_to_be_saved_as_utf_8(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_bytes(TEXT.encode("cp1252"))
    with pytest.raises(TomlFileError, match="cannot read a file: byte 11 is not UTF-8; save it"):
        read_toml(tmp_path / "a.toml", "a file")


def test_a_backslash_in_a_path_is_explained() -> None:
    for path in ("C:\\Users\\me\\dem.npy", "maps\\dem.npy", "C:\\data\\x.png"):
        with pytest.raises(TomlFileError, match="'C:.folder.file' in single quotes"):
            parse_toml(f'file = "{path}"', "a file")


def test_the_suffix_may_be_in_any_case() -> None:
    assert names_toml_file("A.TOML") and names_toml_file("a.Toml") and not names_toml_file("toml")


def test_a_file_too_large_or_not_there_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_bytes(b"#" * (FILE_BYTES_MAX + 1))
    with pytest.raises(TomlFileError, match="larger than"):
        read_toml(tmp_path / "a.toml", "a file")
    with pytest.raises(TomlFileError, match="cannot read"):
        read_toml(tmp_path / "b.toml", "a file")
    assert not is_file(tmp_path / ("x" * 5000)) and not is_file(tmp_path / "a\0.toml")
