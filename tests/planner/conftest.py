"""The toy planner, registered while a module's tests run and not before or after."""

import importlib
import sys

import pytest

from walking_console.planner import registry

TOY = "tests.planner.toy_planner"


@pytest.fixture
def toy():
    """The toy's module, freshly imported: importing it is its entry."""
    sys.modules.pop(TOY, None)
    yield importlib.import_module(TOY)
    registry.unregister_planner("toy")
    sys.modules.pop(TOY, None)
