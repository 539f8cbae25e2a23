"""A console that is started again stands in the world that was loaded last."""

import json
import os
from pathlib import Path

import pytest

from walking_console.server.api.kept_world import KeptWorld
from walking_console.server.limits import BODY_MAX
from walking_console.server.schemas import ScenarioBody
from walking_console.server.uploads import Uploads


@pytest.fixture
def kept(tmp_path: Path) -> KeptWorld:
    return KeptWorld(tmp_path / "world.json")


def keep(kept: KeptWorld, **body: object) -> None:
    kept.keep(ScenarioBody.model_validate(body))
    assert kept._disk.write(lambda: None, "").wait(10.0)


def test_a_shipped_scenario_comes_back_with_its_mode_and_robot(
    kept: KeptWorld, tmp_path: Path
) -> None:
    keep(kept, name="flat", mode="paper")
    world = kept.made(Uploads(tmp_path))
    assert world is not None
    assert (world.scenario.name, world.scenario.mode) == ("flat", "paper")


def test_an_inline_scenario_comes_back_whole(kept: KeptWorld, tmp_path: Path) -> None:
    keep(kept, scenario={"name": "mine", "terrain": {"kind": "slope", "angle_deg": 4.0}})
    world = kept.made(Uploads(tmp_path))
    assert world is not None and world.scenario.name == "mine"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", json.dumps({"name": "no-such"}), "x" * (BODY_MAX + 1)]
)
def test_what_is_no_world_is_none(kept: KeptWorld, tmp_path: Path, text: str) -> None:
    (tmp_path / "world.json").write_text(text)
    assert kept.made(Uploads(tmp_path)) is None


def test_nothing_kept_is_none(kept: KeptWorld, tmp_path: Path) -> None:
    assert kept.made(Uploads(tmp_path)) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_not_read(kept: KeptWorld, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "world.json")
    assert kept.made(Uploads(tmp_path)) is None
