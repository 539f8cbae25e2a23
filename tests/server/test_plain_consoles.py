"""Consoles that cannot print every letter: all of the command line works on them."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from walking_console.server import cli

CONSOLES = ("ascii", "cp1252")
SCENARIO = 'title = "Größe λ → ✓"\n[terrain]\nkind = "file"\nfile = "g→é.npy"\n[end]\ntime = 0.1\n'
COMMANDS = ("bench", "serve", "run", "replay", "export", "figure", "robots", "terrains", "sweep")
ASKING = [["--help"], *([command, "--help"] for command in COMMANDS)]
LISTS = [["--version"], ["robots"], ["terrains"], ["scenarios"]]
WALKS = [
    ["run", "λ.toml", "--out", "o→é"],
    ["replay", "o→é"],
    *(["export", "o→é", "--to", form] for form in ("csv", "html", "mcap")),
]
WRONG = [
    ["rün→"],
    ["run", "--ünknown→"],
    ["run", "nö→.toml"],
    ["run", "wide→.toml"],
    ["run", "flat", "--set", "gait.lïft→=1"],
    ["run", "flat", "--set", 'robot="r→é.toml"'],
    ["run", "flat", "--set", 'terrain={kind="file",file="→é.tif"}'],
    ["replay", "keïn→"],
    ["export", "keïn→", "--to", "csv"],
    ["figure", "ü→", "--out", "f.svg"],
    ["serve", "--robot", "ü→.toml", "--no-open", "--port", "0"],
    ["serve", "--host", "ü→", "--no-open", "--port", "0"],
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a scenario, a ground and a robot of many letters."""
    monkeypatch.chdir(tmp_path)
    Path("λ.toml").write_text(SCENARIO, encoding="utf-8")
    Path("wide→.toml").write_text('"spéed→" = 1\n', encoding="utf-8")
    Path("r→é.toml").write_text('name = "λ→é"\n', encoding="utf-8")
    np.save("g→é.npy", np.zeros((80, 80)))
    return tmp_path


def said_on(console: str, arguments: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> str:
    """What a command prints on a console of an encoding; an error of its own is raised."""
    buffers = io.BytesIO(), io.BytesIO()
    streams = [io.TextIOWrapper(each, encoding=console, write_through=True) for each in buffers]
    with monkeypatch.context() as patched:
        patched.setattr(sys, "argv", ["walking-console", *arguments])
        for name, stream in zip(("stdout", "stderr"), streams, strict=True):
            patched.setattr(sys, name, stream)
        with pytest.raises(SystemExit) as ended:
            cli.main()
    written = b"".join(buffer.getvalue() for buffer in buffers)
    return f"{ended.value.code}: " + written.decode(console, "replace")


@pytest.mark.parametrize("console", CONSOLES)
def test_every_command_lists_and_helps(
    folder: Path, console: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for arguments in [*ASKING, *LISTS]:
        said = said_on(console, arguments, monkeypatch)
        assert said.startswith("0: ") and len(said) > 10, arguments


@pytest.mark.parametrize("console", CONSOLES)
def test_a_walk_of_many_letters_is_run_replayed_and_exported(
    folder: Path, console: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for arguments in WALKS:
        said = said_on(console, arguments, monkeypatch)
        assert said.startswith("0: "), (arguments, said)


@pytest.mark.parametrize("console", CONSOLES)
def test_what_is_wrong_is_said_in_letters_it_has(
    folder: Path, console: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for arguments in WRONG:
        said = said_on(console, arguments, monkeypatch)
        assert said.startswith("2: "), (arguments, said)
        assert "Error: " in said or "walking-console: " in said, (arguments, said)
        assert "Traceback" not in said


def test_a_console_of_plain_letters_gets_escapes_for_the_others(folder: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "walking_console", "run", "λ.toml", "--out", "o→é"]
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert b"written to" in done.stdout and rb"o\u2192\xe9" in done.stdout and not done.stderr
