"""A log in other programs' formats, read back by their libraries."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import gpxpy
import numpy as np
import pandas
import pytest
from defusedxml import ElementTree

from companion.analysis.export import size_text
from companion.analysis.report_data import read_log
from companion.cli.main import main
from companion.cli.rig import LockstepRig
from companion.core.readings import GnssFix, Imu
from companion.record.readings import read_ticks
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions

_HOLD = 0x03040000


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few seconds of Hold, in every format."""
    folder = tmp_path_factory.mktemp("export") / "log"
    rig = LockstepRig(Conditions("revolt", seed=4, faults=("thruster_bow_dead@6",)), folder)
    station = GroundStation(rig)
    station.ready()
    station.set_mode(_HOLD)
    station.arm()
    station.sail(8.0)
    rig.close()
    assert main(["export", str(folder), "--to", "csv,gpx,kml,geojson,parquet"]) == 0
    return folder


def test_the_track_is_where_the_boat_was(exported: Path) -> None:
    ticks = read_log(exported).ticks
    known = ticks["position_valid"] > 0
    with (exported / "export" / "track.gpx").open(encoding="utf-8") as file:
        gpx = gpxpy.parse(file)
    points = [point for segment in gpx.tracks[0].segments for point in segment.points]
    assert len(points) >= np.sum(known)
    assert (points[-1].latitude, points[-1].longitude) == (ticks["lat_deg"][-1], ticks["lon_deg"][-1])
    assert points[0].time is not None and points[0].time.timestamp() == pytest.approx(
        ticks["time_unix_ns"][known][0] / 1e9
    )
    text = (exported / "export" / "track.kml").read_text(encoding="utf-8")
    lines = ElementTree.fromstring(text).iter("{http://www.opengis.net/kml/2.2}LineString")
    last = list(lines)[-1][1].text.split()[-1]
    assert [float(part) for part in last.split(",")] == [ticks["lon_deg"][-1], ticks["lat_deg"][-1]]
    shapes = json.loads((exported / "export" / "track.geojson").read_text(encoding="utf-8"))["features"]
    lines = [shape for shape in shapes if shape["geometry"]["type"] == "LineString"]
    assert {line["properties"]["mode"] for line in lines} == {"Manual", "Hold"}
    assert lines[-1]["geometry"]["coordinates"][-1] == [ticks["lon_deg"][-1], ticks["lat_deg"][-1]]
    assert all(len(line["geometry"]["coordinates"]) == len(line["properties"]["times"]) for line in lines)


def test_a_track_has_the_time_of_the_satellites_where_the_computer_kept_none(exported: Path, tmp_path: Path) -> None:
    """Its clock began at the time when it was last switched off; NTP set it half way."""
    folder = tmp_path / "log"
    shutil.copytree(exported, folder)
    right_ns = read_log(exported).ticks["time_unix_ns"]
    with (folder / "ticks.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    at = header.index("time_unix_ns")
    for row in rows[: len(rows) // 2]:
        row[at] = str(int(row[at]) - 40 * 86400 * 1_000_000_000)
    with (folder / "ticks.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
    assert main(["export", str(folder), "--to", "gpx", "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "track.gpx").open(encoding="utf-8") as file:
        gpx = gpxpy.parse(file)
    known = read_log(folder).ticks["position_valid"] > 0
    times = [point.time.timestamp() for segment in gpx.tracks[0].segments for point in segment.points if point.time]
    assert times[0] == pytest.approx(right_ns[known][0] / 1e9, abs=0.5)
    assert times[-1] == pytest.approx(right_ns[known][-1] / 1e9, abs=0.5)


def test_the_tables_are_the_readings(exported: Path) -> None:
    readings = [r for t in read_ticks(exported / "log.mcap", []) for r in t.readings]
    imu = [r for r in readings if isinstance(r, Imu)]
    table = pandas.read_parquet(exported / "export" / "imu_imu.parquet")
    assert table["x_mps2"].tolist() == [r.x_mps2 for r in imu] and table["t_s"].tolist() == [r.t_s for r in imu]
    fixes = [r for r in readings if isinstance(r, GnssFix)]
    with (exported / "export" / "gnss_gnss.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["lat_deg"]) for row in rows] == [r.lat_deg for r in fixes] and rows[-1]["fix"] == "rtk_fixed"
    ticks = pandas.read_parquet(exported / "export" / "ticks.parquet")
    assert (
        ticks["north_m"].tolist() == read_log(exported).ticks["north_m"].tolist() and ticks["mode"].iloc[-1] == "Hold"
    )
    assert pandas.read_csv(exported / "ticks.csv")["battery_v"].notna().any()


def test_what_cannot_be_exported_is_said(exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(exported), "--to", "shp"]) == 2
    assert "one or more of csv, gpx, kml, geojson, parquet" in capsys.readouterr().err
    assert main(["export", str(tmp_path), "--to", "gpx"]) == 2
    assert "no log folder" in capsys.readouterr().err


@pytest.mark.parametrize("left", [b"", b"t_s,time_un", b"\0" * 512])
def test_a_table_of_which_a_power_cut_left_no_line_is_left_out_with_a_word(
    exported: Path, tmp_path: Path, left: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    log = shutil.copytree(exported, tmp_path / "log", ignore=shutil.ignore_patterns("export"))
    (log / "events.csv").write_bytes(left)
    assert main(["export", str(log), "--to", "parquet"]) == 0
    assert "warning: events.csv: left out" in capsys.readouterr().err
    assert not (log / "export" / "events.parquet").exists() and (log / "export" / "truth.parquet").exists()


def test_sizes() -> None:
    assert [size_text(n) for n in (0, 999, 1000, 12_345_678)] == ["0 B", "999 B", "1.0 kB", "12.3 MB"]
