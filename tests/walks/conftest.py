"""Walks that several tests look at."""

import os

import pytest

from .telling import SharedWalks


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> SharedWalks:
    """Each walked once in a run of the tests, whichever of its processes asks for it first."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    return SharedWalks(folder / "shared-walks")
