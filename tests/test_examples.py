"""The examples: every one runs, and prints what its docstring says."""

import ast
import contextlib
import io
import runpy
import textwrap
from pathlib import Path

import pytest

from walking_console.planner import registry

FOLDER = Path(__file__).resolve().parent.parent / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))


def promised(path: Path) -> str:
    """What follows ``Prints::`` in its docstring."""
    docstring = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    return textwrap.dedent(docstring.partition("Prints::\n\n")[2]).strip()


def printed(path: Path) -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        runpy.run_path(str(path), run_name="__main__")
    return said.getvalue().strip()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_prints_what_it_promises(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "_ENTRIES", dict(registry._ENTRIES))  # as it was, afterwards
    said = printed(path)
    assert [line.rstrip() for line in said.splitlines()] == promised(path).splitlines()
    assert list(tmp_path.iterdir()) == []


def test_they_are_numbered_without_a_gap() -> None:
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_begins_with_a_sentence(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= 60
    assert text.startswith('"""') and text[3:].splitlines()[0].rstrip().endswith((".", ":", ","))


def test_from_heights_to_a_step_takes_at_most_eight_lines() -> None:
    source = (FOLDER / "03_plan_on_your_own_map.py").read_text("utf-8")
    body = ast.parse(source).body[1:]
    lines = [node for node in body if "print" not in ast.unparse(node)]
    assert sum((node.end_lineno or 0) - node.lineno + 1 for node in lines) <= 8
