"""Which browser the page is opened in."""

from __future__ import annotations

import os
import sys
import time
import webbrowser
from pathlib import Path

import pytest

from walking_console.server.browser import graphical_browser, open_page

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="asks what Linux has installed")


def install(monkeypatch: pytest.MonkeyPatch, folder: Path, *names: str, **environment: str) -> Path:
    """These commands and no others are there; each notes that it was started."""
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_text(f'#!/bin/sh\necho "$0 $@" >> {folder}/taken\n')
        (folder / name).chmod(0o755)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"PATH": str(folder), **environment}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(webbrowser, "_tryorder", None)
    monkeypatch.setattr(webbrowser, "_browsers", {})
    return folder / "taken"


def wait_for(path: Path) -> None:
    """Until a process of its own has written the file: some browsers are not waited for."""
    deadline = time.monotonic() + 20.0
    while not path.exists() or not path.read_text():
        assert time.monotonic() < deadline, f"{path} was not written"
        os.sched_yield()


SCREEN = {"DISPLAY": ":0"}
TEXT = ["w3m", "lynx", "links", "elinks", "www-browser"]


@pytest.mark.parametrize("name", TEXT)
@pytest.mark.parametrize("environment", [{}, SCREEN, {"TERM": "xterm"}, {"BROWSER": "w3m %s"}])
def test_no_text_browser_is_ever_started(
    name: str, environment: dict[str, str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    taken = install(monkeypatch, tmp_path / "bin", name, **environment)
    assert not open_page("http://127.0.0.1:8000") and not taken.exists()


def test_a_graphical_browser_is_opened_where_there_is_a_screen(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    taken = install(monkeypatch, tmp_path / "bin", "xdg-open", "w3m", **SCREEN)
    assert graphical_browser() == "xdg-open" and open_page("http://127.0.0.1:8000/x")
    wait_for(taken)
    assert "http://127.0.0.1:8000/x" in taken.read_text()


def test_without_a_screen_only_a_browser_that_is_named_counts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    install(monkeypatch, tmp_path / "bin", "xdg-open", "firefox")
    assert graphical_browser() == ""
    install(monkeypatch, tmp_path / "bin", "code-helper", BROWSER="code-helper")
    assert graphical_browser() == "code-helper"
    install(monkeypatch, tmp_path / "bin", BROWSER="xdg-open")
    assert graphical_browser() == "", "it would take a text browser"
