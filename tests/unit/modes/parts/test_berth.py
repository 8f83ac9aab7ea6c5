"""Where a berth puts the boat, and which berth is chosen."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import DockConfig, VesselConfig
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.modes.parts.berth import BerthChoice
from tests.unit.conftest import Boat


@pytest.mark.parametrize(
    ("side", "bearing_deg", "reach_m"),
    [("port", -90, 0.46), ("starboard", 90, 0.46), ("bow", 0, 1.6), ("stern", 180, 1.6)],
)
@pytest.mark.parametrize("heading_deg", [0.0, -40.0, 130.0])
def test_where_a_berth_puts_the_boat(
    boat: Boat, revolt: VesselConfig, side: Any, bearing_deg: float, reach_m: float, heading_deg: float
) -> None:
    dock = DockConfig(63.4389, 10.399, math.radians(heading_deg), side, 2.0, 0.1)
    berth = BerthChoice(replace(revolt, dock=dock), Plans(), lambda: boat.frame).find(boat.nav)
    assert berth is not None
    for off_m, along_m in ((0.0, 0.0), (2.0, 0.5), (-0.3, -1.0)):
        north_m, east_m, yaw_rad = berth.pose(off_m, along_m)
        assert berth.place(north_m, east_m) == pytest.approx((off_m, along_m), abs=1e-6)
        assert yaw_rad == pytest.approx(math.radians(heading_deg))
    north_m, east_m, _ = berth.pose(2.0)
    assert math.hypot(north_m, east_m) == pytest.approx(reach_m + 2.0)
    towards_deg = math.degrees(math.atan2(-east_m, -north_m))
    assert math.remainder(towards_deg - heading_deg - bearing_deg, 360.0) == pytest.approx(0.0, abs=1e-6)


def landing(boat: Boat, north_m: float, east_m: float, heading_deg: float) -> PlanItem:
    lat_deg, lon_deg = boat.point(north_m, east_m)
    return PlanItem(0, 21, 3, 0.0, 0.0, 0.0, heading_deg, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)


def test_the_missions_berth_comes_before_the_vessels_own(boat: Boat, revolt: VesselConfig) -> None:
    choice = BerthChoice(revolt, boat.plans, lambda: boat.frame)
    own = choice.find(boat.nav)
    boat.plans.replace(
        PlanKind.MISSION,
        [replace(landing(boat, *row), seq=i) for i, row in enumerate([(9.0, 5.0, 90.0), (30.0, 5.0, 0.0)])],
    )
    berth = choice.find(boat.nav)
    assert own is not None and berth is not None
    assert (berth.north_m, berth.east_m) == pytest.approx((9.0, 5.0), abs=0.01) and berth.yaw_rad == pytest.approx(
        math.pi / 2.0
    )
    assert own.yaw_rad == pytest.approx(math.radians(-40.0))
