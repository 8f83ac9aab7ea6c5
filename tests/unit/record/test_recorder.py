"""The log folder: whole rows at any moment."""

from __future__ import annotations

import csv
import json
import os
import struct
from dataclasses import replace
from pathlib import Path

import pytest

from companion.core.decision import Event, TextKind
from companion.core.tick import DeviceHealth
from companion.record.readings import read_ticks
from companion.record.recorder import LogFolder, Medium, tick_columns
from tests.unit.record.ticks import tick

THRUSTERS = ("port", "starboard")
DEVICES = ("gnss", "imu")


def log(folder: Path, sync: bool = False) -> LogFolder:
    return LogFolder(folder, THRUSTERS, DEVICES, {"vessel": "test"}, medium=Medium(durable=sync, beside=sync))


def test_every_row_is_there_without_closing(tmp_path: Path) -> None:
    folder = log(tmp_path)
    for n in range(3):
        folder.record(replace(tick(0.1 * n), events=(Event(0.1 * n, TextKind.ROUTINE, "said", 'a "quoted", text'),)))
        rows = list(csv.DictReader((tmp_path / "ticks.csv").read_text(encoding="utf-8").splitlines()))
        assert len(rows) == n + 1 and float(rows[-1]["t_s"]) == pytest.approx(0.1 * n)
    assert list(rows[0]) == tick_columns(THRUSTERS, DEVICES) and None not in rows[0].values()
    assert rows[0]["mode"] == "Hold" and rows[0]["gnss_ok"] == "1" and rows[0]["imu_ok"] == "0"
    assert float(rows[0]["desired_north_m"]) == 1.0 and float(rows[0]["starboard_throttle"]) == -0.5
    assert rows[0]["starboard_condition"] == "moving"
    assert rows[0]["cross_track_error_m"] == "", "what is not there is empty"
    events = list(csv.DictReader((tmp_path / "events.csv").read_text(encoding="utf-8").splitlines()))
    assert [event["text"] for event in events] == ["a 'quoted', text"] * 3
    assert json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))["vessel"] == "test"
    folder.close()


def test_packets_are_kept_in_the_tlog_form(tmp_path: Path) -> None:
    folder = log(tmp_path)
    folder.packets([b"\xfd\x00", b"\xfe"], 1_780_000_000_123_456_789)
    data = (tmp_path / "telemetry.tlog").read_bytes()
    stamp = struct.pack(">Q", 1_780_000_000_123_456)
    assert data == stamp + b"\xfd\x00" + stamp + b"\xfe"
    folder.close()


def test_a_synced_log_closes_cleanly(tmp_path: Path) -> None:
    folder = log(tmp_path, sync=True)
    folder.record(tick(0.0))
    folder.close()
    folder.record(tick(0.1))
    assert len((tmp_path / "ticks.csv").read_text(encoding="utf-8").splitlines()) == 2


def test_a_folder_that_cannot_be_written_is_an_error_at_start(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way", encoding="utf-8")
    with pytest.raises(OSError, match=os.strerror(17) + "|Not a directory"):
        log(blocked)


def test_each_minute_what_the_devices_count(tmp_path: Path) -> None:
    """Rates and counts change with every message; what is wrong is logged at once."""
    folder = log(tmp_path)
    for n in range(1300):
        state = (
            DeviceHealth("gnss", True, 0.1, f"{n} NMEA sentences, 0 bad; GGA 20 Hz"),
            DeviceHealth("imu", n < 900, 0.1, "self-test failed"),
        )
        folder.record(replace(tick(0.1 * n), health=state))
    folder.close()
    found = [(t.t_s, health.name, health.text) for t in read_ticks(tmp_path / "log.mcap", []) for health in t.health]
    minutes = [t_s for t_s, name, text in found if name == "gnss" and "GGA 20 Hz" in text]
    assert (
        minutes == pytest.approx([0.0, 60.0, 120.0]) and (90.0, "imu", "self-test failed") in found and len(found) == 7
    )
