from pathlib import Path

import pytest

from walking_console.web.figures.run_data import Recipe, RecordedWalk, read_walk, walk_recipe

pytest.importorskip("matplotlib")


@pytest.fixture(scope="session")
def run_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight steps or so of a standard walk between holes, the body swayed."""
    settings = ("gait.body=sway", "end={time=120.0, distance=1.5}", "expect={}")
    recipe = Recipe("fig12", settings)
    return walk_recipe(recipe, tmp_path_factory.mktemp("runs") / "holes")


@pytest.fixture(scope="session")
def walk(run_directory: Path) -> RecordedWalk:
    """The same, read."""
    return read_walk(run_directory)
