"""The way to the standoff point: watched for headway, and inside the fence."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.decision import ModeId
from tests.unit.conftest import Boat
from tests.unit.modes.parts.test_docking import STANDOFF_M, Quay, dock, said


@pytest.fixture
def far_quay(boat: Boat) -> Quay:
    """Its boat lies 25 m off."""
    return Quay(boat)


def test_a_boat_that_comes_no_nearer_to_its_berth_says_so_and_holds(boat: Boat, far_quay: Quay) -> None:
    dock(boat)
    boat.step(5.0)
    boat.obey = lambda _setpoint: None  # weed: it lies where it is
    boat.step(60.0)
    assert "Dock: no headway: wind, current or obstacle" in boat.texts()
    assert boat.status.mode is ModeId.DOCK
    boat.parameters.set("WP_STUCK_ACT", 1)
    boat.until(lambda: boat.status.mode is ModeId.HOLD, 90.0)


def in_a_lane(boat: Boat, quay: Quay) -> float:
    """A fence with less than a boat's length between its outer side and the standoff point, and the boat in it, 30 m
    along the quay. Returns how far off that side is, m."""
    outer_m = STANDOFF_M + 0.8 * boat.config.length_m
    boat.fence(
        *(quay.berth.pose(*corner)[:2] for corner in ((-5.0, -40.0), (-5.0, 40.0), (outer_m, 40.0), (outer_m, -40.0)))
    )
    north_m, east_m, yaw_rad = quay.berth.pose(STANDOFF_M, 30.0)
    boat.nav = replace(boat.nav, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad)
    boat.step()
    return outer_m


def stays_inside(boat: Boat, quay: Quay, outer_m: float, until: str) -> None:
    def reached() -> bool:
        assert boat.status.mode is ModeId.DOCK and quay.off_m < outer_m
        return said(boat, until)()

    boat.until(reached)


def test_from_afar_it_stays_inside_a_fence_along_the_quay(boat: Boat, far_quay: Quay) -> None:
    outer_m = in_a_lane(boat, far_quay)
    dock(boat)
    boat.tick()
    stays_inside(boat, far_quay, outer_m, "dock_docked")
    assert "fence_breach" not in boat.names()


def test_docking_given_up_on_the_way_it_stays_inside_too(boat: Boat, far_quay: Quay) -> None:
    outer_m = in_a_lane(boat, far_quay)
    dock(boat)
    boat.step(3.0)
    boat.supervisor.thruster_failed(2, True)
    stays_inside(boat, far_quay, outer_m, "dock_clear")
