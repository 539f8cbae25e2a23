"""The QR code of an address."""

from __future__ import annotations

import io
import sys

import pytest

from walking_console.server.qr_code import BLOCKS, print_qr_code, qr_code

URL = "http://192.168.1.5:8000/login?token=" + "k" * 43


def test_the_code_is_square_has_a_light_margin_and_the_three_finders() -> None:
    lines = qr_code(URL)
    names = {letter: modules for modules, letter in BLOCKS.items()}
    rows = [[names[letter][half] for letter in line] for line in lines for half in (0, 1)]
    size = len(rows[0])
    assert len(rows) in (size, size + 1) and not any(rows[0]) and not any(rows[1])
    finder = [1, 1, 1, 1, 1, 1, 1, 0]
    assert rows[2][2:10] == finder and rows[2][-10:-2] == finder[::-1]
    assert [row[2] for row in rows[size - 10 : size - 2]] == finder[::-1]


def test_a_terminal_without_letters_for_it_gets_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for encoding, lines in (("ascii", 0), ("utf-8", len(qr_code(URL)))):
        out = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        monkeypatch.setattr(sys, "stdout", out)
        print_qr_code(URL)
        out.seek(0)
        assert len(out.read().splitlines()) == lines
