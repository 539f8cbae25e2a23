"""Walks on rigid bodies of a machine that is other than its file says (all: sweeps/live)."""

import pytest

from .telling import walked

HEAVY = "physics={sag=0.005,mass_error=0.2,cog_offset=[0.02,0.02,0.0],friction=0.5}"
LIGHT = "physics={sag=0.0005,mass_error=-0.1,cog_offset=[-0.02,-0.02,0.0],friction=0.5}"


@pytest.mark.parametrize("machine", [HEAVY, LIGHT], ids=["heavy", "light"])
@pytest.mark.parametrize(
    ("name", "seconds", "degrees"), [("flat", 15.0, 0.5), ("k-curve", 15.0, 1.0)]
)
def test_it_walks_on_and_meets_nothing_that_is_not_there(tmp_path, name, seconds, degrees, machine):
    pytest.importorskip("mujoco")
    settings = ("plant=physics", machine, "expect={}", f"end={{time={seconds}}}")
    summary = walked(tmp_path, name, *settings).summary
    assert summary["result"] == "completed" and summary["falls"] == 0
    assert summary["emergent"] == {} and summary["tilt_deg"] <= degrees


def test_a_foot_held_back_by_its_reach_comes_down_on_its_foothold(tmp_path):
    """The body is led 2 cm behind its plan; a foot it carries forward early is stopped by the leg's
    reach, and has until it lands to catch up.
    """
    pytest.importorskip("mujoco")
    walk = walked(tmp_path, "k-curve", "plant=physics", HEAVY, "expect={}", "end={time=15.0}")
    assert walk.summary["forbidden_steps"] == 0
    for step in walk.steps:
        for landing in step.get("landings", [step["landing"]]):
            assert landing is None or landing[2] == pytest.approx(0.0, abs=0.006)
