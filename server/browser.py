"""The page in a graphical browser, and never in a text browser: that would take the terminal."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import webbrowser
from pathlib import PurePath

# they draw into the terminal, and run no scripts
TEXT_BROWSERS = frozenset("browsh carbonyl elinks links links2 lynx netrik w3m www-browser".split())
# they look for a graphical browser first and take a text browser where there is none
CHOOSERS = frozenset(("gio", "sensible-browser", "xdg-open", "x-www-browser"))
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")  # either is set where there is one
PLATFORMS_WITH_A_SCREEN = ("darwin", "win32", "cygwin")


def open_page(url: str) -> bool:
    """Open the page where a graphical browser is; False where none is.

    In a process of its own without this terminal, so that nothing is written over the address;
    waits until that process is done, with some browsers until they are closed.
    """
    if not graphical_browser():
        return False
    subprocess.run(
        [sys.executable, "-I", "-m", "webbrowser", url],
        check=False,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    return True


def graphical_browser() -> str:
    """Name of the browser that would open a page here; '' when there is none but a text browser.

    Without a screen only a browser that the user names (``BROWSER``) counts: an editor on another
    computer shows pages so.
    """
    seen = sys.platform in PLATFORMS_WITH_A_SCREEN or any(map(os.environ.get, SCREENS))
    if not seen and not os.environ.get("BROWSER"):
        return ""
    try:
        name = _name_of(webbrowser.get())
    except webbrowser.Error:
        return ""
    names = {PurePath(name).name, PurePath(os.path.realpath(shutil.which(name) or name)).name}
    if names & TEXT_BROWSERS or (not seen and names & CHOOSERS):
        return ""
    return name


def _name_of(browser: webbrowser.BaseBrowser) -> str:
    """Its command, or what it is where it has none (Windows, macOS)."""
    return str(getattr(browser, "name", "")) or type(browser).__name__
