"""Recorded hands."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest

from walking_console.sim.drive_files import DriveFileError, read_drive
from walking_console.sim.scenario_files import load_scenario

Read = list[tuple[float, float, float, float]]


def read(text: str | bytes, folder: Path) -> Read:
    """t s, crab angle degrees, speed m/s, turn rate degrees/s of every entry."""
    file = folder / "hand.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return [
        (
            e["t"],
            round(e["crab_angle_deg"], 6),
            round(e["speed"], 9),
            round(e["turn_rate_deg_s"], 6),
        )
        for e in read_drive(file, "hand.csv")
    ]


WALK = [(0.0, 0.0, 0.1, 0.0), (0.5, 90.0, 0.05, 10.0)]


@pytest.mark.parametrize(
    "text",
    [
        "t,alpha,speed,turn\n0,0,0.1,0\n0.5,90,0.05,10\n",
        "t_s,crab_angle_deg,speed_m_s,turn_rate_deg_s\n0,0,0.1,0\n0.5,90,0.05,10\n",
        "speed (mm/s);t [ms];alpha [deg];turn [deg/s]\n100;0;0;0\n50;500;90;10\n",
        "t;alpha;speed;turn\r\n0,0;0,0;0,1;0\r\n0,5;90,0;0,05;10,0\r\n",
        "t\talpha\tspeed\tturn\n0\t0\t0.1\t0\n0.5\t90\t0.05\t10\n",
        "t,alpha_rad,speed,turn_rad_s\n0,0,0.1,0\n0.5,1.5707963267948966,0.05,0.17453292519943295\n",
        "t,vx,vy,wz\n0,0.1,0,0\n0.5,0,0.05,0.17453292519943295\n",
        "# by hand\nt,vx_mm_s,vy_mm_s,wz_deg_s,battery\n\n0,100,0,0,12\n0.5,0,50,10,\n",
        "time,linear.x,linear.y,angular.z\n0,0.1,0,0\n0.5,0,0.05,0.17453292519943295\n",
        "%time,field.linear.x,field.linear.y,field.linear.z,field.angular.x,field.angular.z\n"
        "0,0.1,0,0,0,0\n0.5,0,0.05,0,0,0.17453292519943295\n",
        "__time,/cmd_vel/linear/x,/cmd_vel/linear/y,/cmd_vel/angular/z\n"
        "0,0.1,0,0\n0.5,0,0.05,0.17453292519943295\n",
        "t,direction,speed_km_h,turn\n0,0,0.36,0\n0.5,90,0.18,10\n",
        "t\tangle\tspeed\tturn\n0,0\t0\t0,1\t0\n0,5\t90\t0,05\t10\n",
        "timestamp_ns,vx,vy,wz\n1700000000000000000,0.1,0,0\n"
        "1700000000500000000,0,0.05,0.17453292519943295\n",
        "t,alpha,speed,turn\n0,9,9,9\n0,0,0.1,0\n0.5,90,0.05,10\n",
        "t,alpha,speed,turn\n0,-180,-0.1,0\n0.5,270,-0.05,10\n",
    ],
)
def test_one_hand_reads_the_same_however_it_is_written(text: str, tmp_path: Path) -> None:
    read_back = read(text, tmp_path)
    assert [(round(t, 6), *rest) for t, *rest in read_back] == WALK
    assert read(codecs.BOM_UTF8 + text.encode(), tmp_path) == read_back


def test_a_hand_at_rest_keeps_its_direction(tmp_path: Path) -> None:
    assert read("t,vx,vy\n0,0,0.1\n1,0,0\n2,0,0.1\n", tmp_path)[1] == (1.0, 90.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "a line of column names"),
        ("t,alpha,speed,turn\n", "a line of column names"),
        ("0,0,0.1,0\n1,0,0.1,0\n", "it needs columns t and alpha"),
        ("t,alpha,turn\n0,0,0\n", "it needs columns"),
        ("t,speed,vx\n0,0,0\n", "it needs columns"),
        ("t,vx_furlong\n0,0\n", "it needs columns"),
        ("t,t_ms,vx\n0,0,0\n", "each once"),
        ("t,vx\n0,0.1\n1,fast\n", "line 3: vx must be a number, got 'fast'"),
        ("t,vx\n0,0.1\n1\n", "line 3: vx must be a number, got ''"),
        ("t,vx\n0,nan\n", "line 2: vx must be a number"),
        ("t,vx\n1,0.1\n0.5,0.1\n", "line 3: t must not go back"),
    ],
)
def test_what_is_no_hand_is_refused_by_its_line(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(DriveFileError) as error:
        read(text, tmp_path)
    assert says in str(error.value) and "hand.csv" in str(error.value)


def test_a_scenario_names_it_and_holds_its_entries(tmp_path: Path) -> None:
    lines = "".join(f"{k / 20:.2f},0.08,{k % 7 / 100},0\n" for k in range(24_000))
    (tmp_path / "hand.csv").write_text("t,vx,vy,wz\n" + lines)
    (tmp_path / "s.toml").write_text('drive = "hand.csv"\n[end]\ntime = 1200.0\n')
    scenario = load_scenario(str(tmp_path / "s.toml"))
    assert len(scenario.drive) == 24_000 and scenario.drive[-1].t == 1199.95
    assert scenario.as_data()["drive"][1]["speed"] == pytest.approx(0.0806, abs=1e-4)


def test_a_long_timeline_in_the_scenario_itself_is_read(tmp_path: Path) -> None:
    entry = "[[drive]]\nt = {:.4f}\ncrab_angle_deg = {:.1f}\nspeed = 0.08\n"
    text = "".join(entry.format(k / 20, k % 90 / 10) for k in range(24_000))
    (tmp_path / "s.toml").write_text(text + "[end]\ntime = 1200.0\n")
    assert len(load_scenario(str(tmp_path / "s.toml")).drive) == 24_000
