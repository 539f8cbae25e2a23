"""The bars of the house: counts that must not get worse again, one test for each."""

import ast
import math
import re
import statistics
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import pytest

import walking_console
from tests.corpus.walks import RECIPES

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("planner", "sim", "server", "web")
COLUMNS = 100
FUNCTION_LINES = 30
CLASS_LINES = 250
ATTRIBUTES = 15
REGISTERED = {"crab", "trace", "naive", "paper", "predictive", "kinematic", "physics", "mujoco"}


@dataclass(frozen=True)
class Source:
    """A Python file of the repository, read once: its place, lines and tree."""

    place: str  # from the root, with slashes
    text: str

    @cached_property
    def lines(self) -> list[str]:
        return self.text.splitlines()

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text)

    @cached_property
    def nodes(self) -> list[ast.AST]:
        return list(ast.walk(self.tree))

    def at(self, node: ast.stmt | ast.expr) -> str:
        return f"{self.place}:{node.lineno}"


def sources(*folders: str) -> list[Source]:
    return [
        Source(path.relative_to(ROOT).as_posix(), path.read_text("utf-8"))
        for folder in folders
        for path in sorted((ROOT / folder).rglob("*.py"))
    ]


@cache
def product() -> list[Source]:
    return sources(*ROOMS, "walking_console")


@cache
def sources_of_tests() -> list[Source]:
    return sources("tests")


# Lines and how full they are.


PRAGMA = re.compile(r"  # (?:type: ignore|noqa).*")


def long_lines() -> Iterator[str]:
    """Words to a tool at the end, and what has no space to be wrapped at, are not counted."""
    for source in [*product(), *sources_of_tests(), *sources("examples")]:
        for number, line in enumerate(source.lines, 1):
            text = PRAGMA.sub("", line)
            if len(text) > COLUMNS and " " in text.strip():
                yield f"{source.place}:{number}"


def tuple_assignments() -> Iterator[str]:
    """``a, b = one, two``: two thoughts on one line."""
    for source in product():
        for node in source.nodes:
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
                if any(isinstance(target, ast.Tuple) for target in node.targets):
                    yield source.at(node)


def tuple_assignments_per_1000_lines() -> float:
    lines = sum(len(source.lines) for source in product())
    return 1000 * len(list(tuple_assignments())) / lines


def nested_conditionals() -> Iterator[str]:
    for source in product():
        for node in source.nodes:
            if isinstance(node, ast.IfExp):
                inside = (inner for part in ast.iter_child_nodes(node) for inner in ast.walk(part))
                if any(isinstance(inner, ast.IfExp) for inner in inside):
                    yield source.at(node)


# Functions and classes.

Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def functions() -> list[tuple[Source, Function, list[ast.stmt], int]]:
    """Every function with its body after the docstring, and how many lines of code that is."""
    found = []
    for source in product():
        for node in source.nodes:
            if not isinstance(node, Function):
                continue
            body = node.body[1:] if ast.get_docstring(node) is not None else node.body
            if body:
                inside = source.lines[body[0].lineno - 1 : body[-1].end_lineno]
                code = [line for line in inside if line.strip() and line.strip()[0] != "#"]
                found.append((source, node, body, len(code)))
    return found


def function_lines_median() -> float:
    return statistics.median(lines for *_, lines in functions())


def function_lines_nine_in_ten() -> float:
    return statistics.quantiles((lines for *_, lines in functions()), n=10)[-1]


def names_per_line_median() -> float:
    def names(body: list[ast.stmt]) -> int:
        return sum(isinstance(node, ast.Name) for part in body for node in ast.walk(part))

    return statistics.median(names(body) / max(1, lines) for _, _, body, lines in functions())


def long_functions() -> Iterator[str]:
    for source, node, _, lines in functions():
        if lines > FUNCTION_LINES:
            yield f"{source.at(node)} {node.name} has {lines} lines"


def classes() -> Iterator[tuple[Source, ast.ClassDef]]:
    for source in product():
        for node in source.nodes:
            if isinstance(node, ast.ClassDef):
                yield source, node


def long_classes() -> Iterator[str]:
    for source, node in classes():
        lines = (node.end_lineno or node.lineno) - node.lineno + 1
        if lines > CLASS_LINES:
            yield f"{source.at(node)} {node.name} has {lines} lines"


def attributes_kept(node: ast.ClassDef) -> set[str]:
    """What its methods assign on self. Fields that are declared only are a table, however long."""
    return {
        inner.attr
        for inner in ast.walk(node)
        if isinstance(inner, ast.Attribute)
        and isinstance(inner.ctx, ast.Store)
        and isinstance(inner.value, ast.Name)
        and inner.value.id == "self"
    }


def fields_declared(node: ast.ClassDef) -> set[str]:
    return {
        part.target.id
        for part in node.body
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name)
    }


def classes_of_many_attributes() -> Iterator[str]:
    for source, node in classes():
        kept = attributes_kept(node)
        count = len(kept | fields_declared(node))
        if kept and count > ATTRIBUTES:
            yield f"{source.at(node)} {node.name} has {count} attributes"


# One meaning, one place.


def type_names_with_several_meanings() -> Iterator[str]:
    places: dict[str, list[str]] = defaultdict(list)
    for source in product():
        for node in source.tree.body:
            for name in type_names(node):
                if name[0] != "_":
                    places[name].append(source.place)
    for name, where in places.items():
        if len(where) > 1:
            yield f"{name}: {', '.join(where)}"


def type_names(node: ast.stmt) -> list[str]:
    """Classes and aliases (``Point = tuple[...]``) that a statement of a module makes."""
    if isinstance(node, ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.Assign):
        names = [target.id for target in node.targets if isinstance(target, ast.Name)]
        return [name for name in names if name[:1].isupper() and not name.isupper()]
    return []


def calls(name: str) -> Iterator[str]:
    for source in product():
        for node in source.nodes:
            if isinstance(node, ast.Call) and called(node) == name:
                yield source.at(node)


def called(call: ast.Call) -> str:
    """What a call calls, ``name`` or ``module.name``; of anything longer the last name alone."""
    function = call.func
    if isinstance(function, ast.Name):
        return function.id
    if not isinstance(function, ast.Attribute):
        return ""
    owner = function.value
    return f"{owner.id if isinstance(owner, ast.Name) else ''}.{function.attr}"


def places_that_build_a_step_plan() -> Iterator[str]:
    return calls("StepPlan")


def cos_sin_pairs_outside_geometry() -> Iterator[str]:
    """Both of one angle in one function: a rotation written by hand."""
    for source in product():
        if source.place.startswith("planner/geometry/"):
            continue
        used: dict[tuple[int, str], set[str]] = defaultdict(set)
        for line, call in calls_with_function(source.tree, 0):
            if called(call) in ("math.cos", "math.sin", "np.cos", "np.sin"):
                angle = ast.unparse(call.args[0]) if call.args else ""
                used[line, angle].add(called(call)[-3:])
        for (line, angle), both in used.items():
            if len(both) == 2:
                yield f"{source.place}:{line} {angle}"


def calls_with_function(node: ast.AST, line: int) -> Iterator[tuple[int, ast.Call]]:
    """Every call below, with the line of the function it stands in."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Call):
            yield line, child
        inner = child.lineno if isinstance(child, Function | ast.Lambda) else line
        yield from calls_with_function(child, inner)


def registered_names_compared() -> Iterator[str]:
    """Planners, modes and plants are asked what they can, never compared by name."""
    for source in product():
        if source.place == "planner/registry.py":
            continue
        for node in source.nodes:
            if isinstance(node, ast.Compare):
                told = [part for side in (node.left, *node.comparators) for part in parts_of(side)]
                if any(isinstance(p, ast.Constant) and p.value in REGISTERED for p in told):
                    yield source.at(node)


def parts_of(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple | ast.Set | ast.List) else [node]


def planners_imported_outside_the_registry() -> Iterator[str]:
    inside = ("planner/crab/", "planner/trace/", "planner/registry.py")
    named = re.compile(r"(walking_console\.planner\.)?(crab|trace)\b")
    for source in product():
        if not source.place.startswith("planner/") or source.place.startswith(inside):
            continue
        for node in source.nodes:
            if isinstance(node, ast.ImportFrom) and named.match(node.module or ""):
                yield source.at(node)


# The crab planner.


def crab() -> list[Source]:
    return [source for source in product() if source.place.startswith("planner/crab/")]


def crab_lines() -> int:
    return sum(len(source.lines) for source in crab())


def crab_floors() -> float:
    """The longest chain of imports inside ``planner/crab``; endless where two import each other."""
    wanted = {Path(source.place).stem: neighbours(source.tree) for source in crab()}

    def floor(module: str, above: frozenset[str]) -> float:
        if module in above:
            return math.inf
        below = wanted[module] & wanted.keys()
        return 1 + max((floor(name, above | {module}) for name in below), default=0)

    return max(floor(module, frozenset()) for module in wanted)


def neighbours(tree: ast.Module) -> set[str]:
    """Modules of its own folder that a module imports."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {alias.name for alias in node.names}
    return found


# The tests and what is around.


def without_a_test_file() -> Iterator[str]:
    files = {source.place for source in sources_of_tests()}
    for source in product():
        folder, _, name = source.place.rpartition("/")
        if not any(isinstance(node, Function | ast.ClassDef) for node in source.nodes):
            continue  # names of types only: nothing that could be tested
        if name[0] != "_" and f"tests/{folder}/test_{name}" not in files:
            yield source.place


def without_an_assertion() -> Iterator[str]:
    """Tests that neither assert nor call anything of the tests that does."""
    asserting = asserting_functions()
    for source in sources_of_tests():
        for node in source.nodes:
            if isinstance(node, Function) and node.name.startswith("test_"):
                if not asserts(node, asserting):
                    yield f"{source.at(node)} {node.name}"


def asserting_functions() -> set[str]:
    """Names of functions of the tests that assert, by themselves or by what they call."""
    every = [
        node for source in sources_of_tests() for node in source.nodes if isinstance(node, Function)
    ]
    found: set[str] = set()
    while True:
        more = {node.name for node in every if asserts(node, found)} - found
        if not more:
            return found
        found |= more


def asserts(function: Function, asserting: set[str]) -> bool:
    by_itself, names = what_it_does(function)
    return by_itself or not names.isdisjoint(asserting)


@cache
def what_it_does(function: Function) -> tuple[bool, frozenset[str]]:
    """Whether a function asserts by itself, and the names of what it calls."""
    nodes = list(ast.walk(function))
    calls = [called(node) for node in nodes if isinstance(node, ast.Call)]
    names = frozenset(name.rpartition(".")[2] for name in calls)
    by_itself = any(isinstance(node, ast.Assert) for node in nodes)
    by_itself = by_itself or any(name.startswith("assert") for name in names)
    by_pytest = {"pytest.raises", "pytest.warns", "pytest.fail"}
    return by_itself or not by_pytest.isdisjoint(calls), names


def public_names() -> list[str]:
    return list(walking_console.__all__)


def import_names_installed() -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    return {name.partition(".")[0] for name in project["tool"]["setuptools"]["packages"]}


def examples() -> list[str]:
    return sorted(path.name for path in (ROOT / "examples").glob("[0-9][0-9]_*.py"))


def walks_recorded() -> list[str]:
    return sorted(
        name for name in RECIPES if (ROOT / f"tests/corpus/recorded/{name}.jsonl").exists()
    )


Count = float | Iterator[str] | list[str] | set[str]
Bar = Callable[[], Count]

# Where the limit is not yet what is wanted, what is wanted stands beside it: only ever tighten.
AT_MOST: dict[Bar, float] = {
    import_names_installed: 1,
    public_names: 15,
    long_lines: 0,
    names_per_line_median: 4,
    tuple_assignments_per_1000_lines: 5,
    nested_conditionals: 0,
    function_lines_median: 10,
    function_lines_nine_in_ten: 30,
    long_functions: 4,
    long_classes: 0,
    classes_of_many_attributes: 0,
    type_names_with_several_meanings: 3,
    places_that_build_a_step_plan: 1,
    cos_sin_pairs_outside_geometry: 5,
    registered_names_compared: 0,
    planners_imported_outside_the_registry: 0,
    crab_lines: 3000,
    crab_floors: 8,
    without_a_test_file: 0,
    without_an_assertion: 0,
}
AT_LEAST: dict[Bar, float] = {examples: 12, walks_recorded: 40}


def counted(bar: Bar) -> tuple[float, str]:
    """The number, and what was counted for whoever has to look."""
    count = bar()
    if isinstance(count, int | float):
        return count, f"{bar.__name__}: {count:g}"
    found = [str(what) for what in count]
    return len(found), "\n".join([f"{bar.__name__}: {len(found)}", *found])


@pytest.mark.parametrize("bar", AT_MOST, ids=lambda bar: bar.__name__)
def test_no_more_than(bar: Bar) -> None:
    number, what = counted(bar)
    assert number <= AT_MOST[bar], what


@pytest.mark.parametrize("bar", AT_LEAST, ids=lambda bar: bar.__name__)
def test_no_fewer_than(bar: Bar) -> None:
    number, what = counted(bar)
    assert number >= AT_LEAST[bar], what


def plain(text: str) -> Source:
    return Source("planner/somewhere.py", text)


def test_what_counts_as_a_bar_broken_is_seen() -> None:
    """The counters themselves, held against a few lines each."""
    assert list(calls_with_function(plain("f()\ndef g():\n    h()").tree, 0))[1][0] == 2
    assert type_names(plain("Point = tuple[float]").tree.body[0]) == ["Point"]
    assert type_names(plain("LIMIT = 3").tree.body[0]) == []
    kept = plain("class A:\n    def f(self):\n        self.x = self.y = 1").tree.body[0]
    assert isinstance(kept, ast.ClassDef) and attributes_kept(kept) == {"x", "y"}
    told = plain("def test_it():\n    check(1)").tree.body[0]
    assert isinstance(told, Function) and asserts(told, {"check"}) and not asserts(told, set())
    refused = plain("def test_it():\n    with pytest.raises(ValueError):\n        f()").tree.body[0]
    assert isinstance(refused, Function) and asserts(refused, set())
    turns = [node for node in plain("math.cos(a)\nself.x.sin(b)\nf()()").nodes]
    assert [called(node) for node in turns if isinstance(node, ast.Call)] == [
        "math.cos",
        ".sin",
        "",
        "f",
    ]
    assert neighbours(plain("from .gait import x\nfrom . import turning").tree) == {
        "gait",
        "turning",
    }
