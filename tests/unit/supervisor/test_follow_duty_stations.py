"""Following as a duty: where the station is, and missions that follow."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from companion.core.decision import ModeId, Result
from companion.mission.plan import PlanItem
from tests.unit.following.lead_boat import LeadBoat
from tests.unit.supervisor.follower import following, station

NAN = math.nan


# --- the station ---------------------------------------------------------------------------------------------------


def test_the_station_is_by_parameters_until_commanded_and_again_after(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    duty = boat.supervisor.following
    assert station(boat) == pytest.approx((20.0, 180.0))
    assert duty.set_follow_position(math.radians(-90.0), 30.0, boat.now_s).accepted
    assert station(boat) == pytest.approx((30.0, -90.0))
    assert duty.set_follow_position(None, 40.0, boat.now_s).accepted and station(boat) == pytest.approx((40.0, -90.0))
    assert duty.set_follow_position(math.radians(270.0), None, boat.now_s).accepted and station(boat) == pytest.approx(
        (40.0, -90.0)
    )
    lead.run(0.1)
    assert "Follow position: 30 m at 90 deg to port" in boat.texts()
    boat.parameters.set("FLW_TGT_FA", 135.0)
    assert station(boat) == pytest.approx((20.0, 135.0))
    assert duty.set_follow_position(0.0, 50.0, boat.now_s).accepted and station(boat) == pytest.approx((50.0, 0.0))
    boat.supervisor.disarm(boat.now_s)
    lead.run(0.1)
    assert station(boat) == pytest.approx((20.0, 135.0))


def test_a_station_by_parameters_is_said_too_and_what_keeps_the_boat_further_out(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    boat.parameters.set("FLW_TGT_DST", 30.0)
    lead.run(0.1)
    assert "Follow position: 30 m astern" in boat.texts()
    boat.parameters.set("FOLL_MIN_DIST", 40.0)
    lead.run(0.1)
    assert "Follow position: 30 m astern, but FOLL_MIN_DIST is 40 m" in boat.texts()
    told = len(boat.texts())
    lead.run(1.0)
    assert len(boat.texts()) == told


def test_a_distance_that_the_margin_makes_longer_is_said(boat: Any, lead: LeadBoat) -> None:
    """15 m was announced, and 16.9 m kept."""
    following(boat, lead)
    assert boat.supervisor.following.set_follow_position(None, 15.0, boat.now_s).accepted
    lead.run(0.1)
    assert boat.texts()[-1] == "Follow position: 15 m astern, but 17 m is kept"
    boat.parameters.set("FOLL_MARGIN", 0.5)
    lead.run(0.1)
    assert boat.texts()[-1] == "Follow position: 15 m astern"


def test_a_heading_of_the_leader_that_cannot_be_true_is_said_once(boat: Any, lead: LeadBoat) -> None:
    lead.speed_mps = 5.0
    following(boat, lead)
    told = len(boat.texts())
    lead.yaw_rad = math.pi
    lead.run(10.0)
    assert [text for text in boat.texts()[told:] if "heading" in text] == [
        "Leader's heading ignored: it is off its course"
    ]
    lead.yaw_rad = 0.0
    lead.run(1.0)
    assert "Leader's heading is used again" in boat.texts()[told:]


@pytest.mark.parametrize(
    ("bearing_deg", "distance_m", "reason"),
    [
        (None, 11.0, "FOLL_MIN_DIST is 12 m"),
        (None, 501.0, "give 1 to 500 m"),
        (None, NAN, "give 1 to 500 m"),
        (None, -20.0, "give 1 to 500 m"),
        (400.0, None, "give -360 to 360 deg"),
        (math.inf, 20.0, "give -360 to 360 deg"),
    ],
)
def test_stations_that_cannot_be(boat: Any, bearing_deg: float | None, distance_m: float | None, reason: str) -> None:
    outcome = boat.supervisor.following.set_follow_position(
        None if bearing_deg is None else math.radians(bearing_deg), distance_m, boat.now_s
    )
    assert outcome.result is Result.DENIED and reason in outcome.reason
    boat.step()
    assert outcome.reason in boat.texts() and station(boat) == pytest.approx((20.0, 180.0))


def test_a_station_is_not_taken_inside_by_a_bearing_alone(make_boat: Any) -> None:
    boat = make_boat(FLW_TGT_DST=5.0)
    assert boat.supervisor.following.set_follow_position(0.0, None, boat.now_s).result is Result.DENIED


# --- missions ------------------------------------------------------------------------------------------------------


def do(command: int, *params: float) -> PlanItem:
    return PlanItem(0, command, 2, *(*params, *(NAN for _ in range(4 - len(params)))), 0, 0, 0.0)


def on_mission(boat: Any, lead: LeadBoat, commands: dict[int, PlanItem]) -> None:
    boat.upload((10.0, 0.0), (10.0, 20.0), commands=commands)
    lead.run(1.0)
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted


def run_until(boat: Any, lead: LeadBoat, condition: Callable[[], bool], timeout_s: float = 200.0) -> None:
    end_s = boat.now_s + timeout_s
    while not condition():
        assert boat.now_s < end_s, (boat.status, boat.said[-5:])
        lead.tick()


def test_a_mission_hands_over_to_follow_and_goes_on_after_it_when_resumed(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {1: do(31012, -135.0, 25.0), 2: do(32, -1.0)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.FOLLOW)
    assert station(boat) == pytest.approx((25.0, -135.0)) and boat.status.mission.reached == 1
    lead.run(0.1)
    assert "Item 3: following; choose Mission for item 4" in boat.texts()
    lead.run(20.0)
    assert boat.status.mode is boat.status.intended_mode is ModeId.FOLLOW
    lead.on = False
    lead.run(2.0)
    assert boat.status.mode is ModeId.HOLD
    lead.on = True
    lead.run(4.0)
    assert boat.status.mode is ModeId.FOLLOW  # the plan meant it
    assert boat.supervisor.resume(boat.now_s).accepted
    run_until(boat, lead, lambda: boat.status.mode is ModeId.HOLD)
    assert boat.status.mission.reached == 2 and "Mission complete" in boat.texts()


def test_a_mission_may_end_in_follow(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {2: do(32, NAN)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.FOLLOW)
    lead.run(20.0)
    assert boat.status.mode is ModeId.FOLLOW and "Item 3: following; Mission complete" in boat.texts()


@pytest.mark.parametrize("last", [True, False])
@pytest.mark.parametrize("system", [-1.0, 7.0])
def test_without_a_leader_the_mission_holds_where_it_is_and_says_why(
    boat: Any, lead: LeadBoat, last: bool, system: float
) -> None:
    lead.on = system > 0.0
    on_mission(boat, lead, {2 if last else 1: do(32, system)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.HOLD)
    expected = "Follow refused: leader 7 not heard yet" if system > 0.0 else "Follow refused: no leader heard"
    assert any(text.endswith(expected) for text in boat.texts())
    lead.run(5.0)
    assert boat.status.mode is ModeId.HOLD
    if not last:
        assert boat.supervisor.resume(boat.now_s).accepted
        run_until(boat, lead, lambda: "Mission complete" in boat.texts())


def test_a_station_in_a_mission_that_cannot_be_is_said(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {1: do(31012, 0.0, 3.0)})
    run_until(boat, lead, lambda: "Mission complete" in boat.texts())
    assert "Follow position refused: FOLL_MIN_DIST is 12 m" in boat.texts()
