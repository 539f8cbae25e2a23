"""Every limit of the web side is in one place, and leaves room for what it has to."""

import re
from pathlib import Path

import pytest

from walking_console.server import limits

SERVER = Path(limits.__file__).parent
NAMES = [name for name in vars(limits) if name.isupper()]


@pytest.mark.parametrize("name", NAMES)
def test_a_limit_is_used_and_set_nowhere_else(name: str) -> None:
    others = [path for path in SERVER.rglob("*.py") if path.name != "limits.py"]
    texts = [path.read_text("utf-8") for path in others]
    assert any(re.search(rf"\b{name}\b", text) for text in texts)
    assert not any(re.search(rf"^{name} =", text, re.MULTILINE) for text in texts)


def test_every_page_and_canvas_finds_room_among_the_connections() -> None:
    of_one_page = 2 + 6  # its two sockets, and what a browser opens for files
    assert limits.DRIVERS_MAX + limits.CANVASES_MAX * of_one_page < limits.CONNECTIONS_MAX
    assert limits.CONNECTIONS_MAX + limits.DESCRIPTORS_KEPT < 1024
    assert 3 * limits.ACCEPTED_AT_ONCE < limits.DESCRIPTORS_KEPT


def test_a_stuck_driver_gives_its_place_back_within_five_seconds() -> None:
    assert limits.DRIVE_PING_EVERY + limits.DRIVE_PING_TIME < 5.0
