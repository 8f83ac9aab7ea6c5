"""Docking with something wrong: a thruster that dies on the way in, a berth that is not quite where the file says,
nudges by command."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from sitl.berth import BerthModel
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions

DOCK, HOLD = 0x06040000, 0x03040000


@pytest.fixture
def station(tmp_path: Path) -> GroundStation:
    return GroundStation(LockstepRig(Conditions(vessel="revolt", seed=5, wind="2"), tmp_path))


def near_the_berth(station: GroundStation, off_m: float = 4.0) -> None:
    rig = station.rig
    dock, home = rig.config.dock, rig.config.home
    assert dock is not None
    north_m, east_m = LocalFrame(home.lat_deg, home.lon_deg).to_ned(dock.lat_deg, dock.lon_deg)
    out_rad = dock.yaw_rad + 0.5 * math.pi
    rig.world.set_state(north_m + off_m * math.cos(out_rad), east_m + off_m * math.sin(out_rad), dock.yaw_rad)


def said(station: GroundStation, text: str) -> bool:
    return any(text in line for line in station.texts)


def test_a_thruster_that_dies_on_the_way_in(station: GroundStation) -> None:
    near_the_berth(station)
    station.ready()
    station.set_mode(DOCK)
    station.arm()
    station.wait("the approach", lambda: said(station, "coming alongside at"), 200.0)
    station.sail(10.0)
    station.rig.world.add_fault("thruster_stern_port_dead")
    station.wait("giving up", lambda: said(station, "thruster stern_port failed"), 10.0)
    station.wait("holding off", lambda: said(station, "holding off the berth"), 120.0)
    station.sail(20.0)
    berth = station.rig.world.berth
    assert berth is not None and berth.gap_m > 1.5 and math.isnan(berth.touch_sway_mps)
    station.rig.close()


@pytest.mark.parametrize(("further_m", "turned_deg"), [(0.25, 2.0), pytest.param(-0.25, -2.0, marks=pytest.mark.sweep)])
def test_a_berth_that_is_not_quite_where_the_file_says(
    station: GroundStation, further_m: float, turned_deg: float
) -> None:
    rig = station.rig
    dock, home = rig.config.dock, rig.config.home
    assert dock is not None
    into_rad = dock.yaw_rad - 0.5 * math.pi
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    north_m, east_m = frame.to_ned(dock.lat_deg, dock.lon_deg)
    lat_deg, lon_deg = frame.to_geodetic(
        north_m + further_m * math.cos(into_rad), east_m + further_m * math.sin(into_rad)
    )
    moved = replace(dock, lat_deg=lat_deg, lon_deg=lon_deg, yaw_rad=dock.yaw_rad + math.radians(turned_deg))
    berth = rig.world.berth = BerthModel(moved, home, rig.config.length_m, rig.config.beam_m, rig.config.hull.m22_kg)
    near_the_berth(station)
    station.ready()
    station.set_mode(DOCK)
    station.arm()
    station.wait("docked", lambda: said(station, "Docked"), 250.0)
    farthest_m = 0.0
    for _ in range(300):
        station.step()
        farthest_m = max(farthest_m, berth.gap_m)
    assert farthest_m < 0.05 and berth.force_n > 2.0
    assert math.degrees(rig.world.truth.yaw_rad - dock.yaw_rad) == pytest.approx(turned_deg, abs=1.0)
    rig.close()


def test_nudges_by_command(station: GroundStation) -> None:
    station.ready()
    station.set_mode(HOLD)
    station.arm()
    station.sail(10.0)
    before = station.rig.world.truth
    station.command(31010, 1.0, 1.0, -0.5, 20.0)
    station.sail(30.0)
    after = station.rig.world.truth
    assert (after.north_m - before.north_m, after.east_m - before.east_m) == pytest.approx((1.0, -0.5), abs=0.15)
    assert math.degrees(after.yaw_rad) == pytest.approx(20.0, abs=1.5)
    station.command(31010, 1.0, 30.0, expect=2)
    station.command(31010, 2.0, 350.0)
    station.sail(25.0)
    assert math.degrees(station.rig.world.truth.yaw_rad) == pytest.approx(-10.0, abs=1.5)
    station.rig.close()
