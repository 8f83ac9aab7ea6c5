"""A short run in lockstep, and its log through the same code again."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli import LockstepRig, main
from companion.record.log_reader import LogError, open_log, read_table
from companion.record.replay import Spread, replay
from sitl.scenarios.rig import Conditions
from sitl.scenarios.station import Station

_HOLD = 0x03040000
_FORCES = 0x00020000


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Hold in wind, a go-to, a parameter changed under way, sticks, a thruster that dies, a receiver that falls silent: everything that estimator and control look at."""
    folder = tmp_path_factory.mktemp("log")
    rig = LockstepRig(Conditions("revolt", seed=3, wind="2", faults=("thruster_bow_dead@25+5", "gnss_lost@14+3")), folder)
    station = Station(rig)
    station.ready()
    station.set_mode(_HOLD)
    station.arm()
    home = rig.config.home
    station.command(mavlink.MAV_CMD_DO_REPOSITION, -1.0, 1.0, 0.0, 0.5, home.lat_deg + 2e-5, home.lon_deg, math.nan)
    station.sail(5.0)
    station.send(mavlink.MAVLink_param_set_message(1, 1, b"DP_DAMPING", 0.7, mavlink.MAV_PARAM_TYPE_REAL32))
    station.sail(15.0)
    station.send(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 100, 0))
    station.set_mode(_FORCES)
    for _ in range(20):
        station.send(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 100, 0))
        station.step()
    rig.close()
    return folder


def copied(recorded: Path, folder: Path) -> Path:
    return Path(shutil.copytree(recorded, folder / "log"))


def test_the_same_code_gives_the_same_to_the_last_bit(recorded: Path, tmp_path: Path) -> None:
    result = replay(open_log(recorded), tmp_path / "replay.csv", whole=True)
    assert result.ticks > 200 and result.warnings == []
    assert result.largest_in_log() <= 1e-9
    assert result.wrenches["achieved sway"].count == result.ticks


def test_it_is_near_the_truth_and_the_csv_says_so(recorded: Path, tmp_path: Path) -> None:
    out = tmp_path / "replay.csv"
    result = replay(open_log(recorded), out)
    assert result.against_truth is not None and result.against_truth.position.count > 150
    assert 0.0 < result.against_truth.position.rms < 0.05 and result.against_truth.heading.largest < 0.03
    warnings: list[str] = []
    table = read_table(out, ("t_s", "north_m", "recorded_north_m"), warnings)
    ticks = read_table(recorded / "ticks.csv", ("t_s", "north_m"), warnings)
    assert warnings == [] and len(table["t_s"]) == result.ticks == len(ticks["t_s"])
    assert table["north_m"] == pytest.approx(ticks["north_m"], abs=1e-4)


def test_the_control_really_ran(recorded: Path, tmp_path: Path) -> None:
    columns = tuple(f"{what}_{axis}" for what in ("demanded", "achieved") for axis in ("surge_n", "sway_n", "yaw_nm"))
    out = tmp_path / "replay.csv"
    replay(open_log(recorded), out, whole=True)
    again, ticks = read_table(out, columns, []), read_table(recorded / "ticks.csv", columns, [])
    for name in columns:
        assert again[name] == pytest.approx(ticks[name], abs=1e-3)
        assert max(map(abs, again[name])) > 0.1


def test_a_parameter_changed_under_way_is_part_of_it(recorded: Path, tmp_path: Path) -> None:
    log = copied(recorded, tmp_path)
    lines = (log / "readings.csv").read_bytes().splitlines(keepends=True)
    changes = [line for line in lines if line.startswith(b"parameter,")]
    assert len(changes) == 1 and changes[0].startswith(b"parameter,DP_DAMPING,")
    (log / "readings.csv").write_bytes(b"".join(line for line in lines if line not in changes))
    result = replay(open_log(log), tmp_path / "replay.csv", whole=True)
    assert result.against_log.position.largest <= 1e-9 < result.wrenches["demanded surge"].largest


def test_other_code_is_told_apart_and_the_tolerance_decides(recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = copied(recorded, tmp_path)
    assert main(["replay", str(log)]) == 0
    manifest: dict[str, Any] = json.loads((log / "manifest.json").read_text(encoding="utf-8"))
    manifest["configuration"]["sensors"][0]["x_m"] += 0.02
    (log / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    capsys.readouterr()
    assert main(["replay", str(log), "--out", str(tmp_path / "other.csv")]) == 1
    assert "against the truth" in capsys.readouterr().out
    assert (tmp_path / "other.csv").exists()
    assert main(["replay", str(log), "--tolerance", "0.5"]) == 0


@pytest.mark.parametrize("share", [0.1, 0.5, 0.90001])
def test_a_log_of_a_power_cut_is_replayed_as_far_as_it_goes(recorded: Path, tmp_path: Path, share: float) -> None:
    log = copied(recorded, tmp_path)
    for name in ("readings.csv", "truth.csv"):
        data = (log / name).read_bytes()
        (log / name).write_bytes(data[: int(share * len(data)) | 1])
    result = replay(open_log(log), tmp_path / "replay.csv")
    assert result.ticks > 10 and result.largest_in_log() <= 1e-9
    assert any("readings.csv" in warning for warning in result.warnings)


def test_what_cannot_be_replayed_is_said(recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = copied(recorded, tmp_path)
    (log / "readings.csv").write_bytes(b"kind,source,values\n")
    with pytest.raises(LogError, match="no whole tick"):
        replay(open_log(log), tmp_path / "replay.csv")
    (log / "readings.csv").unlink()
    (log / "truth.csv").unlink()
    assert main(["replay", str(log)]) == 2
    assert "recorded without its readings" in capsys.readouterr().err


def test_a_difference_that_is_no_number_counts_as_infinite() -> None:
    spread = Spread("m")
    spread.add(0.1)
    spread.add(math.nan)
    assert spread.largest == math.inf
