"""Whole boats with plant and companion as two processes that meet on pseudo-terminals, by the very configuration of the
boat."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from tests.protocol.driver import Driver
from tests.protocol.process import free_port
from tests.protocol.two_processes import TwoProcesses

pytestmark = pytest.mark.process

HOLD, MISSION, FOLLOW = 0x03040000, 0x04040000, 0x08040000
REPORTED_S, BACK_S = 1.0, 3.0
PULLED_S = {"gnss": 5.6}  # longer than the boat sails on without a position
NEUTRAL = {"gnss": ("position_lost", "position_lost_over"), "microcontroller": ("bridge_silent", "bridge_silent_over")}


def underway(rig: TwoProcesses, station: GroundStation, ahead_m: float = 0.0) -> None:
    """Armed in Hold where it lies, or on its way to a waypoint ahead."""
    station.ready()
    if ahead_m:
        home = rig.config.home
        frame = LocalFrame(home.lat_deg, home.lon_deg)
        point = frame.to_geodetic(ahead_m * math.cos(home.yaw_rad), ahead_m * math.sin(home.yaw_rad))
        station.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, point[0], point[1])])
    station.set_mode(MISSION if ahead_m else HOLD)
    station.arm()


def pull(rig: TwoProcesses, station: GroundStation, device: str) -> None:
    """The device's port vanishes and comes back: reported within 1 s of the boat's time, answered by rule, well again
    soon."""
    before, pulled_s = len(rig.events()), PULLED_S.get(device, 1.2)
    typed_s = rig.type(f"{device}_unplugged+{pulled_s}")
    away_s: dict[str, float] = {}

    def all_said() -> bool:
        for event in rig.events()[before:]:
            away_s.setdefault(event["name"], float(event["t_s"]) - typed_s)
        return all(name in away_s for name in (f"{device}_lost", f"{device}_back", *NEUTRAL.get(device, ())))

    station.wait(f"{device} lost and back", all_said, pulled_s + 20.0)
    print(f"{rig.vessel}: {device}: " + ", ".join(f"{name} {at_s:.2f} s" for name, at_s in away_s.items()))
    assert away_s[f"{device}_lost"] < REPORTED_S, away_s
    assert pulled_s - 0.1 < away_s[f"{device}_back"] < pulled_s + BACK_S, away_s


@pytest.mark.parametrize(
    ("vessel", "ahead_m"),
    [
        ("revolt", 0.0),
        pytest.param("aboat", 0.0, marks=pytest.mark.sweep),
        pytest.param("rescuerunner", 250.0, marks=pytest.mark.sweep),
    ],
)
def test_every_device_may_be_unplugged_and_comes_back(vessel: str, ahead_m: float, tmp_path: Path) -> None:
    with TwoProcesses(tmp_path, vessel, Driver(0.05), "--wind", "1@45") as rig:
        assert rig.hello[-1] == f"for: companion run {vessel} --devices {tmp_path}/ports"
        station = GroundStation(rig)
        underway(rig, station, ahead_m)
        station.sail(2.0)
        for device in (*rig.config.sensors, *rig.config.actuators):
            pull(rig, station, device.name)
        station.sail(2.0)
        rows = rig.truth()
        assert station.last["HEARTBEAT"].base_mode & 128, "still armed"
        if ahead_m:
            speeds_mps = [row["surge_mps"] for row in rows]
            assert max(speeds_mps) > 4.0 and speeds_mps[-1] > 1.0, "under way again"
        else:
            assert math.hypot(rows[-1]["north_m"], rows[-1]["east_m"]) < (1.0 if vessel == "revolt" else 4.0)
    print(rig.said)
    assert not any((tmp_path / "ports").glob("usv-*")), "the plant takes its ports away with it"


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("vessel", "ahead_m"), [("revolt", 0.0), ("cybership2", 0.0), ("aboat", 60.0), ("rescuerunner", 450.0)]
)
def test_a_minute_in_real_time(vessel: str, ahead_m: float, tmp_path: Path) -> None:
    """Hold where it can hold a heading; else, and for the ÅBOAT, a straight line across the wind. By the wall clock,
    which is what it is about: the machine must have time for it."""
    with TwoProcesses(tmp_path, vessel, None, "--wind", "3@90") as rig:
        station = GroundStation(rig)
        underway(rig, station, ahead_m)
        begin_s = rig.truth()[-1]["t_s"]
        station.sail(60.0)
        rows = [row for row in rig.truth() if row["t_s"] > begin_s + 15.0]
        yaw_rad = rig.config.home.yaw_rad
        along_m = [row["north_m"] * math.cos(yaw_rad) + row["east_m"] * math.sin(yaw_rad) for row in rows]
        across_m = [row["east_m"] * math.cos(yaw_rad) - row["north_m"] * math.sin(yaw_rad) for row in rows]
        print(f"{vessel}: along {along_m[0]:.2f} … {along_m[-1]:.2f} m, across at most {max(map(abs, across_m)):.2f} m")
        assert rows[-1]["t_s"] - begin_s > 58.0, "the plant keeps up with the wall clock"
        assert not [event for event in rig.events() if event["severity"] in ("CRITICAL", "ERROR")]
        if ahead_m:
            assert along_m[-1] > 0.75 * ahead_m and max(map(abs, across_m)) < 4.0
        else:
            assert max(map(abs, along_m)) < 0.5 and max(map(abs, across_m)) < 0.5
    print(rig.said)


@pytest.mark.parametrize(("driven", "sailed_s"), [(True, 25.0), pytest.param(False, 60.0, marks=pytest.mark.sweep)])
def test_the_jet_follows_the_plants_lead_boat(driven: bool, sailed_s: float, tmp_path: Path) -> None:
    """The lead boat's module speaks on the follower's own link for it."""
    port = free_port()
    plant = ("--wind", "3@90", "--leader", "thesis@8.2+3600", "--leader-link", f"udpin:127.0.0.1:{port}")
    links, driver = (f"udpin:127.0.0.1:{port}?telemetry=leader",), Driver(0.05) if driven else None
    with TwoProcesses(tmp_path, "rescuerunner", driver, *plant, links=links) as rig:
        assert any(line.split()[0] == "leader" and str(port) in line for line in rig.hello)
        station = GroundStation(rig)
        station.ready()
        station.set_mode(FOLLOW)
        station.arm()
        rig.type("depart")
        station.sail(20.0)
        begin_s = rig.truth()[-1]["t_s"]
        station.sail(sailed_s)
        leader = {round(row["t_s"], 1): row for row in rig.leader()}
        rows = [(row, leader.get(round(row["t_s"], 1))) for row in rig.truth() if row["t_s"] > begin_s]
        gaps_m = [
            math.hypot(row["north_m"] - ahead["north_m"], row["east_m"] - ahead["east_m"])
            for row, ahead in rows
            if ahead is not None
        ]
        assert station.last["HEARTBEAT"].custom_mode == FOLLOW
        assert rows[-1][0]["surge_mps"] > 7.0, "under way at the leader's speed"
        print(f"gap {min(gaps_m):.1f} to {max(gaps_m):.1f} m over {len(gaps_m)} rows")
        assert len(gaps_m) > 0.5 * sailed_s / 0.1 and min(gaps_m) > 12.0 and max(gaps_m) < 30.0
