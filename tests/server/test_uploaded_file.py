"""Files of strangers are read by a child that may take so much and no more."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from walking_console.server import uploaded_file
from walking_console.server.uploaded_file import Unreadable, read_by_child, understood

FIXTURES = Path(__file__).parents[1] / "fixtures"
DOG = FIXTURES / "robot-option-and-folders" / "robots" / "dog.toml"
PICTURE = FIXTURES / "colour-mode-pictures" / "L.png"


@pytest.mark.parametrize("path", [DOG, PICTURE], ids=["robot", "ground"])
def test_a_child_understands_what_the_console_does(path: Path) -> None:
    assert read_by_child(path, path.name) == understood(path, path.name)


def test_a_child_says_every_fault(tmp_path: Path) -> None:
    bad = DOG.read_text("utf-8").replace("mass = 32.7", "mass = -1").replace("0.8", "2.0")
    (tmp_path / "bad.toml").write_text(bad, "utf-8")
    with pytest.raises(Unreadable) as refusal:
        read_by_child(tmp_path / "bad.toml", "bad.toml")
    assert len(refusal.value.faults) >= 2 and any("mass" in said for said in refusal.value.faults)


def test_a_file_that_takes_too_long_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "h.npy", np.zeros((80, 80)))
    monkeypatch.setattr(uploaded_file, "SECONDS_MAX", 0.005)
    with pytest.raises(Unreadable, match="h.npy takes too much memory or time to read"):
        read_by_child(tmp_path / "h.npy", "h.npy")


def test_a_file_that_takes_too_much_memory_ends_its_child_only(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.zeros((5000, 5000), np.uint8))
    program = (
        "import sys; from pathlib import Path; from walking_console.server import uploaded_file; "
        "uploaded_file.MEMORY_MAX = 100_000_000; "
        "print(uploaded_file.answer_of_child(Path(sys.argv[1]), 'h.npy'))"
    )
    child = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "h.npy")], capture_output=True, timeout=120
    )
    assert b"h.npy cannot be read" in child.stdout or child.returncode != 0
