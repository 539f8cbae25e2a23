"""The documents: what they link to is there, and the files and tests they name exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "planner/NOTATION.md"])
CODE = [
    path
    for room in ("planner", "sim", "server", "web", "tests")
    for path in (ROOT / room).rglob("*")
]
FILES = {path.relative_to(ROOT).as_posix() for path in [*CODE, *ROOT.glob("*.toml")]}
TESTS = {
    name
    for path in (ROOT / "tests").rglob("test_*.py")
    for name in re.findall(r"def (test_\w+)", path.read_text("utf-8"))
}
LEDGER = (ROOT / "planner/NOTATION.md").read_text("utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_links_to_what_there_is(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text("utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


OF_TODAY = [page for page in PAGES if page.name != "CHANGELOG.md"]


@pytest.mark.parametrize("page", OF_TODAY, ids=lambda page: page.name)
def test_a_page_names_files_that_exist(page: Path) -> None:
    named = set(re.findall(r"`([\w/]+\.(?:py|js|toml))`", page.read_text("utf-8")))
    assert (
        sorted(
            name
            for name in named
            if not any(file == name or file.endswith(f"/{name}") for file in FILES)
        )
        == []
    )


def test_a_row_of_the_faults_is_of_a_fault_that_is_tried_by_its_command() -> None:
    from tests.sweeps.faults.__main__ import FAULTS
    from tests.sweeps.faults.table import PAGE, kept_rows

    rows = kept_rows(PAGE.read_text("utf-8"))
    rows.pop("fault")
    commands = {fault.title: fault.key for fault in FAULTS}
    assert len(rows) >= 10 and set(rows) <= set(commands)
    for title, row in rows.items():
        assert f"`{commands[title]} --count " in row and re.search(r"\d{4}-\d\d-\d\d", row)


def test_the_ledger_names_tests_that_exist() -> None:
    named = re.findall(r"\btest_\w+(?:…)?", LEDGER)
    modules = {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    missing = [
        name
        for name in named
        if name not in modules
        and not any(test == name or test.startswith(name.rstrip("…")) for test in TESTS)
    ]
    assert missing == []


def test_the_ledger_names_words_of_the_code() -> None:
    """Every word in code type of a table of symbols is a name in the planner."""
    tables = [line for line in LEDGER.splitlines() if line.startswith("|")]
    words = {
        part
        for line in tables
        for word in re.findall(r"`([A-Za-z_][\w.]*)`", line)
        for part in word.split(".")
        if len(part) > 2 and not part.startswith("test_")
    }
    said = "\n".join(
        path.read_text("utf-8")
        for path in CODE
        if path.suffix == ".py" and "tests" not in path.parts
    )
    known = (
        set(re.findall(r"\w+", said)) | {path.stem for path in CODE} | {path.name for path in CODE}
    )
    assert sorted(words - known) == []
