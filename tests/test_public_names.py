"""The public names of ``walking_console``: found by people, editors and doctest alike."""

import ast
import doctest
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import walking_console

SOURCE = Path(walking_console.__file__).read_text("utf-8")


def names_for_type_checkers() -> list[str]:
    block = next(node for node in ast.parse(SOURCE).body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    return sorted(alias.name for node in imports for alias in node.names)


def test_type_checkers_see_the_same_names() -> None:
    assert names_for_type_checkers() == sorted(walking_console.__all__)
    assert sorted(walking_console._HOMES) == sorted(walking_console.__all__)


@pytest.mark.parametrize("name", walking_console.__all__)
def test_a_name_has_a_docstring_with_an_example_that_runs(name: str) -> None:
    public = getattr(walking_console, name)
    assert public.__name__ == name
    module = inspect.getmodule(public)
    (test,) = doctest.DocTestFinder(recurse=False).find(public, name, module)
    assert len(test.examples) >= 1
    said: list[str] = []
    failed, _ = doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    assert failed == 0, "".join(said)


def test_a_name_there_is_not_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Walker'"):
        walking_console.Walker  # noqa: B018


def test_dir_lists_the_public_names() -> None:
    assert set(walking_console.__all__) <= set(dir(walking_console))


def loaded_by(program: str) -> set[str]:
    """What a fresh interpreter has loaded after running this."""
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\nimport sys\nprint(*sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return set(done.stdout.split())


def test_the_bare_import_loads_nothing_else() -> None:
    loaded = loaded_by("import walking_console")
    assert not loaded & {"numpy", "pydantic", "pymunk", "viser", "fastapi"}


def test_planning_loads_neither_simulation_nor_server() -> None:
    loaded = loaded_by("from walking_console import StepPlanner, TerrainMap, load_machine")
    assert not loaded & {"walking_console.sim", "pydantic", "pymunk", "viser", "fastapi"}
