"""The repository itself: what is checked in, what is installed, and whether the README tells the
truth.
"""

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 900.0  # s a child may take on a machine that has much else to do
ROOMS = ("planner", "sim", "server", "web")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def repository_files() -> list[Path]:
    """What git tracks or would track; in an unpacked archive without git, everything that is not
    hidden or left behind by a tool.
    """
    if (ROOT / ".git").exists() and shutil.which("git"):
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        files = [ROOT / name for name in listed.stdout.split("\0") if name]
    else:
        left_behind = re.compile(
            r"(^|/)(\.venv[^/]*|node_modules|\.[a-z]+_cache|\.hypothesis|build|__pycache__|walking-console-data|[^/]+\.egg-info)(/|$)"
        )
        files = [
            path
            for path in ROOT.rglob("*")
            if not left_behind.search(path.relative_to(ROOT).as_posix())
        ]
    return sorted(path for path in files if path.is_file())


@cache
def texts() -> list[tuple[str, str]]:
    """Place and content of every text file in the repository."""
    found = []
    for path in repository_files():
        content = path.read_bytes()
        if b"\0" not in content[:4096]:
            found.append((path.relative_to(ROOT).as_posix(), content.decode("utf-8")))
    return found


def lines_with(pattern: re.Pattern[str]) -> list[str]:
    """Place and beginning of every line of a text file in which there is such a thing."""
    return [
        f"{place}:{number}: {line[:120]}"
        for place, text in texts()
        if pattern.search(text)
        for number, line in enumerate(text.splitlines(), 1)
        if pattern.search(line)
    ]


def test_no_file_names_a_folder_of_somebodys_machine() -> None:
    machine_path = re.compile(r"(?<![\w.\-/])(/(?:home|Users|work)/\w|/root/\.)|[A-Z]:\\Users")
    assert lines_with(machine_path) == []


def test_no_file_names_a_package_registry() -> None:
    registry = re.compile(
        r"pypi\.org|pythonhosted\.org|npmjs\.(?:org|com)|deb\.debian\.org|--(?:extra-)?index-url|--find-links"
    )
    here = "tests/test_repository.py:"
    named = lines_with(registry)
    assert [line for line in named if not line.startswith(here)] == []
    assert named  # the pattern itself


IMPORTED_AS = {"pillow": "PIL", "pypng": "png"}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(file: str = "constraints.txt") -> dict[str, str]:
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    assert [
        line for line in lines if not re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!]+", line)
    ] == []
    return {canonical(name): version for name, version in (line.split("==") for line in lines)}


@pytest.mark.parametrize(
    "needed", PROJECT["dependencies"] + PROJECT["optional-dependencies"]["test"]
)
def test_every_dependency_is_pinned_within_its_bounds(needed: str) -> None:
    requirement = Requirement(needed)
    assert requirement.specifier.contains(pins()[canonical(requirement.name)])


def test_the_oldest_versions_tried_are_the_lower_bounds() -> None:
    extras = PROJECT["optional-dependencies"]
    needed = [*PROJECT["dependencies"], *extras["figures"], *extras["mcap"]]
    bounds = {
        canonical(requirement.name): bound.version
        for requirement in map(Requirement, needed)
        for bound in requirement.specifier
        if bound.operator == ">="
    }
    assert pins("constraints-lowest.txt") == bounds


@pytest.mark.parametrize("needed", PROJECT["dependencies"])
def test_every_dependency_is_imported_by_the_product(needed: str) -> None:
    name = canonical(Requirement(needed).name)
    wanted = re.compile(rf"^\s*(?:import|from) {IMPORTED_AS.get(name, name)}\b", re.MULTILINE)
    files = [path for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    assert any(wanted.search(path.read_text(encoding="utf-8")) for path in files)


def built(kind: str, source: Path, out: Path) -> Path:
    """What setuptools builds (``sdist`` or ``wheel``) of a copy of the repository."""
    program = f"from setuptools import build_meta; print(build_meta.build_{kind}({str(out)!r}))"
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=source,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    return out / done.stdout.split()[-1]


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the repository, so that nothing is left behind in it."""
    copy = tmp_path_factory.mktemp("copy")
    for path in repository_files():
        target = copy / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    return copy


@pytest.fixture(scope="module")
def wheel(copy: Path, tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    return zipfile.ZipFile(built("wheel", copy, tmp_path_factory.mktemp("wheel")))


@pytest.fixture(scope="module")
def unpacked(copy: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source archive, unpacked."""
    out = tmp_path_factory.mktemp("sdist")
    with tarfile.open(built("sdist", copy, out)) as archive:
        archive.extractall(out, filter="data")
    return next(path for path in out.iterdir() if path.is_dir())


def test_the_source_archive_holds_every_file_of_the_repository(unpacked: Path) -> None:
    wanted = [path.relative_to(ROOT) for path in repository_files()]
    assert [place.as_posix() for place in wanted if not (unpacked / place).exists()] == []


def test_the_tests_run_from_the_source_archive(unpacked: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/test_layers.py"],
        cwd=unpacked,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stdout


def test_the_wheel_of_the_source_archive_is_the_same(
    wheel: zipfile.ZipFile, unpacked: Path, tmp_path: Path
) -> None:
    again = zipfile.ZipFile(built("wheel", unpacked, tmp_path))
    assert sorted(again.namelist()) == sorted(wheel.namelist())


def test_the_wheel_holds_every_file_of_the_four_rooms(wheel: zipfile.ZipFile) -> None:
    inside = set()
    for path in repository_files():
        place = path.relative_to(ROOT)
        if place.parts[0] in ROOMS:
            inside.add(f"walking_console/{place.as_posix()}")
        elif place.parts[0] == "walking_console":
            inside.add(place.as_posix())
    assert sorted(inside - set(wheel.namelist())) == []


def test_the_wheel_installs_one_import_name_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    tops = {name.partition("/")[0] for name in wheel.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"walking_console"}


def test_the_wheel_carries_all_licences(wheel: zipfile.ZipFile) -> None:
    licences = [name for name in wheel.namelist() if ".dist-info/licenses/" in name]
    assert {name.partition("licenses/")[2] for name in licences} >= {
        "LICENSE",
        "web/vendor/swagger/LICENSE",
        "web/vendor/uplot/LICENSE",
    }


def test_the_wheel_installs_the_command(wheel: zipfile.ZipFile) -> None:
    name = next(name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    assert "walking-console = walking_console.server.cli:main" in wheel.read(name).decode()


def test_the_version_is_the_same_everywhere() -> None:
    version = PROJECT["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert distribution("walking-console").version == version


def test_the_readme_names_targets_that_make_knows() -> None:
    targets = set(
        re.findall(
            r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE
        )
    )
    assert set(re.findall(r"\bmake ([a-z-]+)\b", README)) <= targets


def test_all_tests_in_a_browser_are_where_make_looks_for_them() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    named = re.search(r"^BROWSER_TESTS = ([\w/]+)", makefile, flags=re.MULTILINE)
    marks = re.compile(r"\bIN_A_(?:BROWSER)\b|\bpytest\.mark\.browser\b")
    marked = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "tests").rglob("test_*.py")
        if marks.search(path.read_text(encoding="utf-8"))
    }
    assert named is not None and len(marked) >= 5
    assert [place for place in marked if not place.startswith(f"{named[1]}/")] == []


def test_the_readme_names_commands_that_exist() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "walking_console", "--help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    ).stdout
    named = set(re.findall(r"walking-console ([a-z]+)\b", README))
    assert {command for command in named if not re.search(rf"\b{command}\b", shown)} == set()


def test_the_readme_links_to_files_that_exist() -> None:
    links = set(re.findall(r"\]\((?!https?:|#)([^)#]+)", README))
    missing = sorted(link for link in links if not (ROOT / link).exists())
    assert missing == []


SNIPPETS = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", README, flags=re.DOTALL)


def test_the_readme_shows_two_snippets_and_the_first_has_six_lines() -> None:
    assert len(SNIPPETS) == 2
    assert len([line for line in SNIPPETS[0][0].splitlines() if line]) <= 6


@pytest.mark.parametrize(("program", "result"), SNIPPETS, ids=["drive", "plan"])
def test_the_readme_shows_what_its_snippets_print(program: str, result: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE
    )
    assert (done.stdout, done.stderr) == (result, "")


def test_make_says_its_commands_so_that_the_shell_understands_them(tmp_path: Path) -> None:
    """Of an environment that is not there yet: what it would do, word by word."""
    said = subprocess.run(
        ["make", "--dry-run", "test", "run", f"VENV={tmp_path}/env"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE,
    ).stdout
    assert "walking_console/*.py" in said
    subprocess.run(["sh", "-n"], input=said, text=True, check=True, timeout=PATIENCE)
