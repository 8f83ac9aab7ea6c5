"""The table of the fault matrix, how a cell is judged, and how one past has many futures."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId
from sitl.fault_matrix import deeds
from sitl.fault_matrix.branch import branch
from sitl.fault_matrix.cell import Observed, judge, observed_of
from sitl.fault_matrix.stages import BY_STICK, PX4_MODES
from sitl.fault_matrix.table import load as load_table
from sitl.faults import parse

TABLE = load_table()
ASKED = {  # what has to be in the matrix, each by the faults that stand for it
    "link": ["link_cut"], "station": ["station_silent"], "sticks": ["sticks_silent"], "safe switch": ["safe_switch"],
    "GNSS": ["gnss_lost", "gnss_frozen", "gnss_jump", "gnss_drift", "gnss_spoof"],
    "heading": ["heading_lost", "heading_turned", "heading_drift", "heading_noise"],
    "IMU": ["imu_lost", "imu_stuck", "imu_biased"],
    "thruster": ["thruster_dead", "thruster_stuck", "thruster_runaway", "thruster_reversed", "thruster_fouled"],
    "bridge": ["bridge_silent", "bridge_garbled"], "hull": ["battery_low", "leak", "capsized", "aground"],
    "disk": ["disk_full", "disk_read_only"], "process": ["clock_step", "process_stopped", "tick_overrun"],
    "leader": ["leader_lost", "leader_frozen", "leader_lying"], "around": ["fence_crossed", "ais_forged"],
}  # fmt: skip
GREEN = Observed(
    "revolt", "Hold", "leak", "RTL", 0.0, ((0.1, "leak", "Water in the hull: RTL"),),
    ((0.1, "Water in the hull: RTL"),), 0.1, (),
)  # fmt: skip


def test_every_fault_that_was_asked_for_is_there() -> None:
    names = {fault.name for fault in TABLE.faults}
    assert not [name for asked in ASKED.values() for name in asked if name not in names]
    assert len(names) == len(TABLE.faults)


def test_modes_are_those_of_the_boat() -> None:
    assert {*TABLE.modes, *TABLE.open_modes} == {mode.value for mode in ModeId}
    assert set(TABLE.modes) == set(PX4_MODES) and not set(TABLE.modes) & set(TABLE.open_modes)
    assert {mode for mode, group in TABLE.modes.items() if group == "sticks"} == set(BY_STICK)


@pytest.mark.parametrize("vessel", [row.name for row in TABLE.vessels])
def test_every_fault_exists_on_every_vessel_or_says_why_not(vessel: str) -> None:
    row, config = TABLE.vessel(vessel), load(find(vessel))
    for fault in TABLE.faults:
        exists = any(not TABLE.expected(vessel, mode, fault).none for mode in TABLE.modes)
        for name in fault.sitl if exists else ():
            parse(f"{name.format(thruster=row.thruster, bridge=row.bridge)}@1", config)
        assert fault.sitl or fault.deed or fault.name == "none"
        assert not fault.deed or fault.deed in deeds.DEEDS
    for mode in TABLE.modes:
        assert (vessel, mode) in TABLE.absent or mode in BY_STICK or row.reach_m[mode] > 0.0


def test_rules_use_known_modes_and_vessels() -> None:
    modes = {*TABLE.modes, *TABLE.modes.values()}
    vessels = {row.name for row in TABLE.vessels}
    for fault in TABLE.faults:
        for rule in fault.rules:
            assert set(rule.get("modes", ())) <= modes and set(rule.get("vessels", ())) <= vessels, fault.name


def test_later_rules_go_over_earlier_ones() -> None:
    lost = TABLE.fault("gnss_lost")
    assert TABLE.expected("revolt", "Hold", lost).after == "neutral"
    assert TABLE.expected("revolt", "Manual", lost).after == "same"
    assert TABLE.expected("aboat", "Dock", lost).none == "its file has no berth"


def test_a_green_cell_and_its_file() -> None:
    assert judge(TABLE, GREEN) == [] and observed_of(GREEN.row()) == GREEN


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"after": "Hold"}, "Hold, not RTL"),
        ({"after": "RTL, neutral"}, "RTL, neutral, not RTL"),
        ({"events": ()}, "not said"),
        ({"events": ((1.5, "leak", "Water in the hull: RTL"),)}, "said 1.5 s after it was knowable"),
        ({"heard": ()}, "said to nobody"),
        ({"log": ("packets of the log are cut",)}, "packets of the log are cut"),
    ],
)
def test_what_makes_a_cell_red(changes: dict[str, object], problem: str) -> None:
    assert judge(TABLE, replace(GREEN, **changes)) == [problem]  # type: ignore[arg-type]


def test_distance_counts_where_one_is_promised() -> None:
    jumped = Observed(
        "revolt", "Hold", "gnss_jump", "Hold", 0.0, ((0.5, "sense_distrusted", "gnss position jumped 50 m: not used"),),
        ((0.6, "gnss position jumped 50 m: not used"),), 0.7, (),
    )  # fmt: skip
    assert judge(TABLE, jumped) == []
    assert judge(TABLE, replace(jumped, off_m=0.8)) == ["0.80 m away"]


def test_what_could_not_be_known_need_not_be_said() -> None:
    assert judge(TABLE, replace(GREEN, known_s=None, events=())) == []
    late = replace(GREEN, known_s=5.0, events=((5.9, "leak", "Water in the hull: RTL"),))
    assert judge(TABLE, late) == []


def test_each_future_writes_into_its_own_copy(tmp_path: Path) -> None:
    past = tmp_path / "past"
    past.mkdir()
    descriptor = os.open(past / "log", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.write(descriptor, b"begun\n")
    for name in (b"one", b"two"):
        into = tmp_path / name.decode()
        assert branch(past, into, lambda name=name: os.write(descriptor, name))  # type: ignore[misc]
        assert (into / "log").read_bytes() == b"begun\n" + name
    os.write(descriptor, b"gone on")
    os.close(descriptor)
    assert (past / "log").read_bytes() == b"begun\ngone on"


def test_a_future_that_breaks_off_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    past = tmp_path / "past"
    past.mkdir()

    def breaks() -> None:
        raise ValueError("in the middle")

    assert not branch(past, tmp_path / "future", breaks)
    assert "in the middle" in capfd.readouterr().err
