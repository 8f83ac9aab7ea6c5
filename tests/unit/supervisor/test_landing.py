"""Take-off and Land of a boat: what is accepted, when the voyage counts as over, and disarming after it."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId, Result
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat

BERTH = (6.0, 4.0)


def armed(boat: Boat, mode: ModeId = ModeId.HOLD) -> Boat:
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    return boat


def land(boat: Boat, place: tuple[float, float] | None = None) -> None:
    assert boat.supervisor.landing.land(place, boat.now_s).accepted
    boat.step()


def item(boat: Boat, command: int, north_m: float, east_m: float, heading_deg: float = math.nan) -> PlanItem:
    lat_deg, lon_deg = boat.point(north_m, east_m)
    return PlanItem(0, command, 3, 0.0, 0.0, 0.0, heading_deg, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)


def test_a_take_off_changes_nothing_in_a_mode_that_steers_by_itself(boat: Boat) -> None:
    assert boat.supervisor.landing.take_off(boat.now_s).accepted
    boat.step()
    assert not boat.status.armed and "Take-off: afloat already, nothing to do" in boat.texts()
    armed(boat)
    version = boat.supervisor.version
    assert boat.supervisor.landing.take_off(boat.now_s).accepted and boat.supervisor.version == version


def test_after_a_take_off_a_boat_that_sticks_steer_holds(boat: Boat) -> None:
    armed(boat, ModeId.MANUAL)
    assert boat.supervisor.landing.take_off(boat.now_s).accepted
    boat.step()
    assert boat.status.mode is ModeId.HOLD


def test_a_take_off_can_be_refused(make_boat: Any) -> None:
    boat = make_boat(COM_TAKEOFF_OK=0)
    outcome = boat.supervisor.landing.take_off(boat.now_s)
    assert outcome.result is Result.DENIED and "COM_TAKEOFF_OK" in outcome.reason


def test_land_holds_here_and_counts_as_landed_until_the_next_order(boat: Boat) -> None:
    armed(boat)
    assert boat.supervisor.go_to(*boat.point(30.0, 0.0), None, None, boat.now_s).accepted
    boat.step(10.0)
    assert not boat.status.landed
    land(boat)
    boat.until(lambda: boat.status.landed)
    assert boat.status.armed and boat.status.mode is ModeId.HOLD and boat.away_m(30.0, 0.0) > 5.0
    assert boat.supervisor.go_to(*boat.point(30.0, 0.0), None, None, boat.now_s).accepted
    boat.step()
    assert not boat.status.landed
    boat.until(lambda: boat.away_m(30.0, 0.0) < 0.5)
    boat.step(5.0)
    assert not boat.status.landed


def test_land_at_a_place_is_done_there(boat: Boat) -> None:
    armed(boat)
    land(boat, boat.point(20.0, 5.0))
    assert not boat.status.landed
    boat.until(lambda: boat.status.landed)
    assert boat.away_m(20.0, 5.0) < 1.0


def test_sticks_and_nudges_take_a_landed_boat_on(boat: Boat) -> None:
    armed(boat)
    land(boat)
    boat.until(lambda: boat.status.landed)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(1.0)
    assert boat.status.landed
    boat.sticks = (0.8, 0.0, 0.0)
    boat.step(1.0)
    assert not boat.status.landed
    boat.sticks = (0.0, 0.0, 0.0)
    land(boat)
    boat.until(lambda: boat.status.landed)
    assert boat.supervisor.nudge(1.0, 0.0, 0.0, boat.now_s).accepted
    boat.step()
    assert not boat.status.landed


def test_land_docks_where_that_is_chosen_and_a_berth_is_near(make_boat: Any) -> None:
    boat = make_boat(COM_LAND_ACT=1)
    armed(boat)
    land(boat)
    assert boat.status.mode is ModeId.DOCK and not boat.status.landed


def test_land_holds_where_the_boat_cannot_dock() -> None:
    boat = Boat(load(find("rescuerunner")), COM_LAND_ACT=1)
    armed(boat)
    land(boat)
    assert boat.status.mode is ModeId.HOLD
    assert any(text.startswith("Land holds, no docking: ") for text in boat.texts())


def test_a_disarmed_boat_has_landed(boat: Boat) -> None:
    assert boat.supervisor.landing.land(None, boat.now_s).accepted


def test_a_mission_that_ends_at_home_has_landed(boat: Boat) -> None:
    boat.upload((10.0, 0.0), commands={1: item(boat, 20, 0.0, 0.0)})
    armed(boat, ModeId.MISSION)
    boat.until(lambda: boat.status.mode is ModeId.HOLD)
    boat.until(lambda: boat.status.landed)
    assert boat.away_m(0.0, 0.0) < 1.0


def test_a_mission_that_ends_elsewhere_has_not(boat: Boat) -> None:
    boat.upload((10.0, 0.0))
    armed(boat, ModeId.MISSION)
    boat.until(lambda: boat.status.mode is ModeId.HOLD)
    boat.step(20.0)
    assert not boat.status.landed


@pytest.mark.parametrize(("act", "heading_deg"), [(1, math.nan), (0, 90.0), (0, math.nan)])
def test_a_mission_lands_by_holding_there(make_boat: Any, act: int, heading_deg: float) -> None:
    """Without a heading there is no berth; with MIS_LAND_ACT 0 the boat docks at none."""
    boat = make_boat(MIS_LAND_ACT=act)
    boat.upload((10.0, 0.0), commands={1: item(boat, 21, *BERTH, heading_deg)})
    armed(boat, ModeId.MISSION)
    boat.until(lambda: boat.status.mode is ModeId.HOLD)
    boat.until(lambda: boat.status.landed)
    assert boat.away_m(*BERTH) < 1.0 and boat.status.mission.reached == 2


def test_a_boat_without_sideways_thrust_lands_by_holding_there() -> None:
    boat = Boat(load(find("rescuerunner")))
    boat.upload((40.0, 0.0), commands={1: item(boat, 21, 80.0, 0.0, 90.0)})
    armed(boat, ModeId.MISSION)
    boat.until(lambda: boat.status.mode is ModeId.HOLD)
    assert boat.away_m(80.0, 0.0) < boat.parameters["DP_WATCH_R"]


def test_a_mission_that_lands_outside_the_fence_is_refused(boat: Boat) -> None:
    corners = [item(boat, 5001, north, east) for north, east in ((-30, -30), (30, -30), (30, 30), (-30, 30))]
    fence = [PlanItem(n, 5001, 3, 4.0, 0.0, 0.0, 0.0, corner.x, corner.y, 0.0) for n, corner in enumerate(corners)]
    boat.plans.replace(PlanKind.FENCE, fence)
    boat.upload((10.0, 0.0), commands={1: item(boat, 21, 60.0, 0.0)})
    boat.step()
    outcome = boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert outcome.reason == "Mission refused: item 2: outside the fence"


def test_rtl_at_home_is_not_landed_to_ground_stations_but_disarms_where_asked(make_boat: Any) -> None:
    """QGroundControl offers no go-to to a landed boat."""
    boat = armed(make_boat())
    assert boat.supervisor.go_to(*boat.point(15.0, 0.0), None, None, boat.now_s).accepted
    boat.until(lambda: boat.away_m(15.0, 0.0) < 0.5)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.until(lambda: "RTL: at home, holding" in boat.texts())
    boat.step(30.0)
    assert boat.status.armed and not boat.status.landed
    boat.parameters.set("COM_DISARM_LAND", 4.0)
    boat.step(3.5)
    assert boat.status.armed
    boat.step(1.0)
    assert not boat.status.armed and boat.texts()[-1] == "Disarmed"


def test_disarming_waits_for_the_end_of_the_voyage(make_boat: Any) -> None:
    boat = armed(make_boat(COM_DISARM_LAND=0.0))
    boat.step(60.0)
    assert boat.status.armed
    land(boat)
    boat.until(lambda: not boat.status.armed)
    armed(boat)
    boat.step(10.0)
    assert boat.status.armed, "armed again it holds"


def test_an_order_in_time_keeps_it_armed(make_boat: Any) -> None:
    boat = armed(make_boat(COM_DISARM_LAND=5.0))
    land(boat)
    boat.until(lambda: boat.status.landed)
    boat.step(3.0)
    assert boat.supervisor.nudge(1.0, 0.0, 0.0, boat.now_s).accepted
    boat.step(20.0)
    assert boat.status.armed
