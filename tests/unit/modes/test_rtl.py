"""Back home along the own track, or by the shortest way."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.decision import ModeId
from companion.core.setpoint import PathSetpoint
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat

CORNER, END = (40.0, 0.0), (40.0, 30.0)


def sailed_out(boat: Boat) -> None:
    """From home round the corner to the end, in Hold."""
    boat.supervisor.arm(boat.now_s)
    for place in (CORNER, END):
        boat.supervisor.go_to(*boat.point(*place), None, None, boat.now_s)
        boat.until(lambda at=place: boat.away_m(*at) < 0.1)


def back_home(boat: Boat) -> tuple[float, float]:
    """(nearest to the corner on the way home, nearest to the middle of the short cut)."""
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    corner_m = cut_m = math.inf

    def arrived() -> bool:
        nonlocal corner_m, cut_m
        corner_m, cut_m = min(corner_m, boat.away_m(*CORNER)), min(cut_m, boat.away_m(20.0, 15.0))
        return "rtl_arrived" in boat.names()

    boat.until(arrived)
    assert boat.away_m(0.0, 0.0) < 0.3
    return corner_m, cut_m


def test_along_the_own_track(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(RTL_TRACK=1)
    sailed_out(boat)
    corner_m, cut_m = back_home(boat)
    assert corner_m < 5.0 and cut_m > 8.0


def test_the_shortest_way_by_default(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    sailed_out(boat)
    corner_m, cut_m = back_home(boat)
    assert cut_m < 1.0 and corner_m > 15.0


def test_a_track_that_a_later_fence_forbids_is_not_taken(make_boat: Callable[..., Boat]) -> None:
    """A keep-out on the corner: the short cut is left."""
    boat = make_boat(RTL_TRACK=1)
    sailed_out(boat)
    lat_deg, lon_deg = boat.point(*CORNER)
    zone = PlanItem(0, 5004, 0, 6.0, 0.0, 0.0, 0.0, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
    boat.plans.replace(PlanKind.FENCE, [zone])
    boat.step(2.0)
    corner_m, cut_m = back_home(boat)
    assert corner_m > 6.0 and cut_m < 3.0


def test_a_rally_point_does_not_lead_off_the_track(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(RTL_TRACK=1)
    boat.upload((38.0, 34.0), kind=PlanKind.RALLY)
    sailed_out(boat)
    corner_m, _ = back_home(boat)
    assert corner_m < 5.0


def test_armed_and_still_at_home_there_is_nothing_to_follow(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(RTL_TRACK=1)
    boat.supervisor.arm(boat.now_s)
    boat.step(1.0)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.until(lambda: "rtl_arrived" in boat.names())
    assert not isinstance(boat.setpoint, PathSetpoint)


def test_each_arrival_is_announced_however_soon_after_the_last(make_boat: Callable[..., Boat]) -> None:
    """Disarmed and armed again at home; a program that watched waited for the second one for ever."""
    boat = make_boat()
    boat.supervisor.arm(boat.now_s)
    boat.step(1.0)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.until(lambda: "rtl_arrived" in boat.names())
    first_s = boat.now_s
    boat.supervisor.disarm(boat.now_s)
    boat.step(0.5)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: boat.names().count("rtl_arrived") == 2, timeout_s=60.0)
    assert boat.now_s < first_s + 9.0


@pytest.mark.parametrize("track", [0, 1])
def test_moved_ashore_and_armed_again_the_old_track_is_gone(make_boat: Callable[..., Boat], track: int) -> None:
    boat = make_boat(RTL_TRACK=track)
    sailed_out(boat)
    boat.supervisor.disarm(boat.now_s, force=True)
    boat.step(1.0)
    boat.supervisor.arm(boat.now_s)
    boat.step(1.0)
    _, cut_m = back_home(boat)
    assert cut_m < 1.0
