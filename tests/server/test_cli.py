"""The command line keeps the outside contract: exit codes, one clear line for bad input, run
directories, replays.
"""

from __future__ import annotations

import json
from hashlib import blake2b

import numpy as np
import pytest

from tests.server.command_line import SHORT, called
from walking_console.sim.runs.runner import product_version


def test_a_run_writes_the_whole_run_directory(run_directory):
    names = {path.name for path in run_directory.iterdir()}
    assert {"run.json", "ticks.npz", "steps.jsonl", "terrain.npz", "inputs.jsonl"} <= names
    summary = json.loads((run_directory / "run.json").read_text())
    assert summary["schema"] == 1
    assert summary["result"] == "completed" and summary["reason"] == "time"
    assert summary["ticks"] == 200 and summary["seconds"] == pytest.approx(4.0)
    with np.load(run_directory / "ticks.npz", allow_pickle=False) as log:
        assert {name: log[name].shape for name in log.files} == {
            "t": (200,), "body": (200, 6), "feet": (200, 4, 3), "contact": (200, 4),
            "support": (200, 4), "margin": (200,), "polygon_margin": (200,), "command": (200, 3),
            "step": (200,), "mode": (200,), "hash": (200,), "capture_margin": (200,),
            "joints": (200, 4, 3), "loads": (200, 4), "planned_loads": (200, 4),
            "flags": (200, 3), "handshake": (200,),
        }  # fmt: skip
        assert (
            log["contact"].dtype == bool
            and log["step"].dtype == np.int32
            and log["mode"].dtype == np.int8
        )


def test_anybody_can_compute_the_state_hash_from_the_log(run_directory):
    summary = json.loads((run_directory / "run.json").read_text())
    previous = bytes(8)
    with np.load(run_directory / "ticks.npz", allow_pickle=False) as log:
        for row in range(len(log["t"])):
            floats = (
                np.concatenate([log["body"][row], log["feet"][row].ravel(), log["command"][row]])
                + 0.0
            )
            flags = np.concatenate(
                [log["contact"][row], log["support"][row], [log["mode"][row]]]
            ).astype(np.uint8)
            previous = blake2b(
                previous + floats.astype("<f8").tobytes() + flags.tobytes(), digest_size=8
            ).digest()
            assert int.from_bytes(previous, "little") == int(log["hash"][row])
    assert summary["state_hash"] == f"{int.from_bytes(previous, 'little'):016x}"


@pytest.mark.parametrize(
    ("drive", "said"),
    [
        ('[{t=0.0, posture="sit", speed=0.1}]', 'drive.0: posture = "sit" needs speed = 0'),
        (
            '[{t=0.0, posture="stand", turn_rate_deg_s=1.0}]',
            'drive.0: posture = "stand" needs speed = 0',
        ),
        (
            '[{t=0.0, posture="lie"}]',
            "drive.0.posture should be 'sit', 'stand' or 'standard', got 'lie'",
        ),
        ("[{t=0.0, posture=1}]", "drive.0.posture should be 'sit', 'stand' or 'standard', got 1"),
    ],
)
def test_a_posture_that_cannot_be_ends_in_one_clear_line(tmp_path, drive, said):
    result = called("run", "flat", "--out", tmp_path / "no", "--set", f"drive={drive}")
    assert result.exit_code == 2 and said in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.parametrize("seconds", ("-1", "soon"))
def test_how_long_to_wait_before_sitting_down_is_seconds(seconds):
    result = called("serve", "--no-open", "--sit-after", seconds)
    assert result.exit_code == 2 and "--sit-after" in result.stderr


def test_a_recorded_posture_that_is_none_is_refused_by_its_line(run_directory, tmp_path):
    for name in ("run.json", "ticks.npz"):
        (tmp_path / name).write_bytes((run_directory / name).read_bytes())
    (tmp_path / "inputs.jsonl").write_text('{"tick": 0, "input": "pose", "posture": "lie"}\n')
    result = called("replay", tmp_path)
    assert (
        result.exit_code == 2
        and "line 1" in result.stderr
        and "there are: sit, stand, standard" in result.stderr
    )


def test_a_replay_is_equal_and_a_changed_input_is_found(run_directory, tmp_path):
    assert called("replay", run_directory).exit_code == 0
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in run_directory.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    changed = (copy / "inputs.jsonl").read_text().replace('"speed": 0.08', '"speed": 0.07')
    (copy / "inputs.jsonl").write_text(changed)
    result = called("replay", copy)
    assert result.exit_code == 1
    assert "differs" in result.output


def test_a_run_refuses_a_full_directory_and_force_empties_a_run_directory(run_directory, tmp_path):
    result = called("run", "flat", "--out", run_directory, *SHORT)
    assert result.exit_code == 2 and "--force" in result.stderr
    assert called("run", "flat", "--out", run_directory, "--force", *SHORT).exit_code == 0
    (tmp_path / "precious.txt").write_text("mine")
    assert called("run", "flat", "--out", tmp_path, "--force", *SHORT).exit_code == 2
    assert (tmp_path / "precious.txt").exists()


def test_an_expectation_that_fails_is_exit_1(tmp_path):
    result = called(
        "run",
        "flat",
        "--out",
        tmp_path / "r",
        "--set",
        "end={time=2.0}",
        "--set",
        "expect={distance_min=5.0}",
    )
    assert result.exit_code == 1
    assert "FAIL" in result.output
    assert (
        json.loads((tmp_path / "r" / "run.json").read_text())["expect"]["distance_min"]["pass"]
        is False
    )


BAD = [
    (("run", "flatt"), "unknown scenario 'flatt'; there are: "),
    (("run", "flat", "--set", "robot=titan9"), "unknown robot 'titan9'; there are: "),
    (("run", "flat", "--set", "terrain.kind=lava"), "lava"),
    (("run", "flat", "--set", "gait.duty_factor=nan"), "duty_factor"),
    (("run", "flat", "--set", "seed=inf"), "seed"),
    (("run", "flat", "--set", "sped=1"), "sped"),
    (("run", "flat", "--set", "robot=hexapod"), "four-legged"),
    (("run", "flat", "--set", "no-equals-sign"), "KEY=VALUE"),
    (("run", "flat", "--set", "drive.0.speed=true"), "speed"),
    (("run", "flat", "--set", "drive.7.speed=0.1"), "drive"),
    (("run", "nowhere.toml"), "nowhere.toml"),
]


@pytest.mark.parametrize(("arguments", "said"), BAD, ids=[" ".join(case[0]) for case in BAD])
def test_bad_input_is_one_clear_line_and_exit_2(tmp_path, arguments, said):
    result = called(*arguments, "--out", tmp_path / "r")
    assert result.exit_code == 2, result.output
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "r" / "run.json").exists()


def test_malformed_toml_is_one_clear_line_and_exit_2(tmp_path):
    (tmp_path / "bad.toml").write_text("title = [unclosed\n")
    result = called("run", tmp_path / "bad.toml", "--out", tmp_path / "r")
    assert result.exit_code == 2 and len(result.stderr.strip().splitlines()) == 1
    assert "TOML" in result.stderr


def test_a_heightmap_with_nan_is_one_clear_line_and_exit_2(tmp_path):
    heights = np.zeros((200, 200))
    heights[3, 4] = np.nan
    np.save(tmp_path / "bad.npy", heights)
    (tmp_path / "s.toml").write_text(
        '[terrain]\nkind = "file"\nfile = "bad.npy"\ncell = 0.05\n[end]\ntime = 1.0\n'
    )
    result = called("run", tmp_path / "s.toml", "--out", tmp_path / "r")
    assert result.exit_code == 2 and len(result.stderr.strip().splitlines()) == 1
    assert "NaN" in result.stderr and "3" in result.stderr and "4" in result.stderr


@pytest.mark.parametrize(
    ("listed", "known"),
    [("robots", "titan3"), ("terrains", "stepping_stones"), ("scenarios", "dem")],
)
def test_what_can_be_named_is_listed_with_a_line_each(listed, known):
    result = called(listed)
    assert result.exit_code == 0
    lines = {line.split()[0]: line for line in result.output.splitlines()}
    assert known in lines
    assert all(len(line.split()) >= 3 for line in lines.values())


def test_bench_prints_its_figures_and_writes_them_as_json(tmp_path, monkeypatch):
    monkeypatch.setattr("walking_console.sim.runs.benchmark.ROUNDS", 1)
    out = tmp_path / "bench.json"
    result = called("bench", "--json", out)
    assert result.exit_code == 0, result.output
    figures = json.loads(out.read_text())["figures"]
    assert all(entry["value"] > 0 for entry in figures.values())
    assert any("Level C" in name for name in figures)


def test_help_has_a_short_name():
    assert called("run", "-h").stdout == called("run", "--help").stdout != ""


def test_the_version_is_printed():
    result = called("--version")
    assert result.exit_code == 0
    assert result.stdout.strip() == f"walking-console {product_version()}"


def test_without_an_out_directory_the_next_free_number_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        result = called("run", "flat", "--set", "end={time=0.5}", "--set", "expect={}")
        assert result.exit_code == 0, result.output
        assert (tmp_path / "runs" / f"flat-000{number}" / "run.json").is_file()
        assert f"runs/flat-000{number}" in result.stdout


def test_a_run_that_is_bad_input_makes_no_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert called("run", "flatt").exit_code == 2
    assert not (tmp_path / "runs").exists()


@pytest.fixture
def served(monkeypatch):
    """What the console was asked to serve, instead of serving it."""
    asked = []
    monkeypatch.setattr("walking_console.server.launch.serve", asked.append)
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    return asked


VARIABLES = {
    "WALKING_CONSOLE_HOST": ("host", "127.0.0.2", "--host"),
    "WALKING_CONSOLE_PORT": ("port", "4321", "--port"),
    "WALKING_CONSOLE_TOKEN": ("token", "k" * 40, "--token"),
    "WALKING_CONSOLE_VIEWER_TOKEN": ("viewer_token", "v" * 40, "--viewer-token"),
    "WALKING_CONSOLE_DATA": ("data", "elsewhere", "--data"),
    "WALKING_CONSOLE_LOG_LEVEL": ("log_level", "info", "--log-level"),
}


@pytest.mark.parametrize("command", [(), ("serve",)])
@pytest.mark.parametrize("name", VARIABLES)
def test_a_variable_of_the_environment_sets_what_the_command_line_leaves_open(
    served, monkeypatch, command, name
):
    field, value, _ = VARIABLES[name]
    monkeypatch.setenv(name, value)
    assert called(*command, "--no-open").exit_code == 0
    assert str(getattr(served[0], field)) == value


@pytest.mark.parametrize("name", VARIABLES)
def test_the_command_line_wins_over_the_environment(served, monkeypatch, name):
    field, value, option = VARIABLES[name]
    monkeypatch.setenv(name, {"port": "1", "log_level": "error"}.get(field, "other"))
    assert called("--no-open", option, value).exit_code == 0
    assert str(getattr(served[0], field)) == value


@pytest.mark.parametrize("command", [(), ("serve",)])
def test_the_help_names_every_option_and_variable(command):
    shown = " ".join(called(*command, "--help").stdout.split())
    for name, (_, _, option) in VARIABLES.items():
        assert name in shown.replace("- ", "-") and option in shown


def test_without_a_command_the_words_are_those_of_serve(served):
    assert called("--port", 4000, "--scenario", "river", "--sit-after", 2).exit_code == 0
    assert called("serve", "--port", 4000, "--scenario", "river", "--sit-after", 2).exit_code == 0
    assert served[0] == served[1]
    assert served[0].scenario == "river" and served[0].open_page


def test_an_unknown_command_is_refused_by_name():
    result = called("fly")
    assert result.exit_code == 2 and "fly" in result.stderr


def test_a_level_of_talk_that_is_none_is_refused(served):
    result = called("--log-level", "loud")
    assert result.exit_code == 2 and "loud" in result.stderr and not served
