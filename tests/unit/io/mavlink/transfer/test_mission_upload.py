"""How items are asked for, and items that come outside an upload."""

from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanKind, PlanResult
from tests.unit.io.mavlink.conftest import Desk
from tests.unit.io.mavlink.transfer.client import item_float, item_int, upload, waypoint

MISSION = PlanKind.MISSION


@pytest.fixture(autouse=True)
def service(desk: Desk) -> Any:
    return desk.serve(MissionService(desk.hub, desk.vessel))


# --- points for Guided ---------------------------------------------------------------------------------------------


def test_an_item_of_the_old_guided_kind_is_refused_not_ignored(desk: Desk) -> None:
    desk.tell(item_int(waypoint(0, current=2)))
    assert [r.type for r in desk.replies()] == [PlanResult.UNSUPPORTED] and desk.supervisor.gone_to == []


@pytest.mark.parametrize("form", [item_int, item_float])
def test_a_waypoint_for_guided_is_a_go_to_on_links_that_have_guided(desk: Desk, form: Any) -> None:
    """DroneKit's simple_goto sends the old form to all; ArduPilot answers with MISSION_ACK."""
    rover = desk.peer("rover")
    desk.tell(form(waypoint(0, current=2)), rover)
    assert [r.type for r in desk.replies()] == [PlanResult.ACCEPTED]
    assert desk.supervisor.gone_to == [(pytest.approx(63.44), pytest.approx(10.3989999, abs=2e-6))]
    assert desk.plans.items(MISSION) == ()
    desk.supervisor.in_guided = False
    desk.tell(form(waypoint(0, current=2)), rover)
    assert [r.type for r in desk.replies()] == [PlanResult.DENIED] and len(desk.supervisor.gone_to) == 1


def test_a_go_to_after_an_upload_is_not_taken_for_its_last_item(desk: Desk) -> None:
    rover = desk.peer("rover")
    assert upload(desk, [waypoint(0)], peer=rover).type == 0
    desk.tell(item_int(waypoint(0, current=2)), rover)
    assert [r.type for r in desk.replies()] == [PlanResult.ACCEPTED] and len(desk.supervisor.gone_to) == 1


@pytest.mark.parametrize(
    ("changes", "result", "text"),
    [
        ({"command": 17}, PlanResult.UNSUPPORTED, "Go-to refused: NAV_LOITER_UNLIM is no waypoint"),
        ({"x": 0, "y": 0}, PlanResult.INVALID_PARAM5_X, "Go-to refused: no such place"),
        ({"frame": 1}, PlanResult.UNSUPPORTED_FRAME, "Go-to refused: NAV_WAYPOINT is in frame 1"),
        ({"x": 1_000_000_000}, PlanResult.INVALID_PARAM5_X, "Go-to refused: NAV_WAYPOINT latitude is 100.0"),
    ],
)
def test_what_is_no_point_for_guided(desk: Desk, changes: Any, result: int, text: str) -> None:
    desk.tell(item_int(waypoint(0, current=2, **changes)), desk.peer("rover"))
    assert [r.type for r in desk.replies()] == [result] and desk.supervisor.gone_to == []
    assert desk.texts()[0].startswith(text)


def test_the_old_change_of_altitude_is_unsupported(desk: Desk) -> None:
    desk.tell(item_int(waypoint(0, current=3)), desk.peer("rover"))
    assert [r.type for r in desk.replies()] == [PlanResult.UNSUPPORTED] and desk.supervisor.gone_to == []


# --- the form of requests ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["qgc", "rover"])
def test_a_client_that_knows_the_old_request_only_uploads_all_the_same(desk: Desk, name: str) -> None:
    """DroneKit, and scripts that wait for MISSION_REQUEST, as ArduPilot asks."""
    peer = desk.peer(name)
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 3, 0), peer)
    asked: list[str] = []
    for _ in range(10):
        desk.wait(0.1)
        requests = desk.replies()
        asked += [r.get_type() for r in requests]
        if "MISSION_REQUEST" in asked:
            break
    assert asked == ["MISSION_REQUEST_INT"] * 2 + ["MISSION_REQUEST"], "within a second"
    for seq in range(2):
        desk.tell(item_float(waypoint(seq)), peer)
        assert [(r.get_type(), r.seq) for r in desk.replies()] == [("MISSION_REQUEST", seq + 1)]
    desk.wait(0.3)
    assert {(r.get_type(), r.seq) for r in desk.replies()} == {("MISSION_REQUEST", 2)}
    desk.tell(item_float(waypoint(2)), peer)
    assert [r.type for r in desk.replies() if r.get_type() == "MISSION_ACK"] == [PlanResult.ACCEPTED]


def test_a_client_that_begins_again_twice_a_second_is_asked_by_the_old_request_too(desk: Desk) -> None:
    asked: list[str] = []
    for _ in range(4):
        desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
        asked.append(desk.replies()[0].get_type())
        desk.wait(0.4)
        desk.heard()
    assert asked == ["MISSION_REQUEST_INT", "MISSION_REQUEST"] * 2
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    assert {r.get_type() for r in desk.replies()} == {"MISSION_REQUEST_INT"}, "not for a doubled packet"


def test_a_client_that_answered_is_asked_in_the_same_form_whatever_is_lost(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    desk.tell(item_int(waypoint(0)))
    desk.heard()
    desk.wait(4.0)
    assert {r.get_type() for r in desk.replies()} == {"MISSION_REQUEST_INT"}


@pytest.mark.parametrize("late_s", [0.0, 0.3])
def test_a_client_that_refuses_the_old_request_goes_on(desk: Desk, late_s: float) -> None:
    """MAVSDK answers each MISSION_REQUEST with UNSUPPORTED; over a slow link it may have the first item under way."""
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.wait(0.6)
    assert desk.replies()[-1].get_type() == "MISSION_REQUEST"
    desk.wait(late_s)
    if late_s:
        desk.tell(item_int(waypoint(0)))
    desk.heard()
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.UNSUPPORTED, 0))
    desk.wait(3.0)
    assert {r.get_type() for r in desk.replies()} == {"MISSION_REQUEST_INT"}
    for seq in (0, 1):
        desk.tell(item_int(waypoint(seq)))
    assert [r.type for r in desk.replies() if r.get_type() == "MISSION_ACK"] == [PlanResult.ACCEPTED]


def test_a_client_that_refuses_the_new_request_is_asked_by_the_old_one_at_once(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.heard()
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.UNSUPPORTED, 0))
    assert [(r.get_type(), r.seq) for r in desk.replies()] == [("MISSION_REQUEST", 0)]
    desk.tell(item_float(waypoint(0)))
    assert desk.replies()[-1].type == PlanResult.ACCEPTED


def test_a_client_that_refuses_both_is_not_asked_the_faster(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    for _ in range(20):
        desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.UNSUPPORTED, 0))
    assert len(desk.replies()) <= 3
    desk.wait(6.0)
    assert desk.texts() == ["mission upload broke off at item 1: old one kept"]


def test_unsupported_after_an_item_ends_the_upload(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.tell(item_int(waypoint(0)))
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.UNSUPPORTED, 0))
    desk.heard()
    desk.wait(3.0)
    assert desk.heard() == []
