"""The recipes of CONTRIBUTING: that the files they name are the only ones that know such a
thing.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
NAMED = re.compile(r"`((?:planner|sim|server|web|tests|docs)/[\w/.-]+)`")
CODE = {
    path.relative_to(ROOT).as_posix(): path.read_text("utf-8")
    for room in ("planner", "sim", "server", "web")
    for pattern in ("*.py", "*.js", "*.html")
    for path in (ROOT / room).rglob(pattern)
    if "vendor" not in path.parts
}


def files_that_say(word: str) -> set[str]:
    """Files in which a word stands as a string of its own, examples in docstrings aside."""
    quoted = re.compile(rf"(?<!\()[\"']{word}[\"'](?!\))")
    return {
        place
        for place, text in CODE.items()
        if any(quoted.search(line) for line in text.splitlines() if ">>>" not in line)
    }


def test_every_file_it_names_exists() -> None:
    assert (
        sorted(name for name in set(NAMED.findall(CONTRIBUTING)) if not (ROOT / name).exists())
        == []
    )


@pytest.mark.parametrize(
    ("what", "of_its_kind", "places"),
    [
        ("robot", "phantomx", set()),
        ("terrain", "stepping_stones", {"sim/terrain/generators.py"}),
        ("gait", "ripple", {"planner/trace/periodic_gaits.py"}),
        ("plant", "kinematic", {"sim/plants.py"}),
        ("scenario", "k-turn", set()),
    ],
)
def test_a_recipe_touches_no_more_than_it_says(
    what: str, of_its_kind: str, places: set[str]
) -> None:
    assert files_that_say(of_its_kind) == places
    assert f"### A {what}: " in CONTRIBUTING
