"""The mission protocol at a desk: one message in, the right answer out, to the client that asked only."""

from __future__ import annotations

import math
import struct
from typing import Any

import pytest

from companion.core.decision import Home
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Peer
from companion.mission.plan import PlanKind, PlanResult, plan_id
from companion.mission.validation import CAPACITY
from tests.remembered import remembered
from tests.unit.io.mavlink.conftest import Desk
from tests.unit.io.mavlink.transfer.client import LAT, LON, item_int, upload, waypoint
from tests.unit.mission.item_bits import bits

MISSION, FENCE, RALLY = PlanKind


@pytest.fixture(autouse=True)
def service(desk: Desk) -> Any:
    return desk.serve(MissionService(desk.hub, desk.vessel))


def download(desk: Desk, kind: int = 0, peer: Peer | None = None) -> list[Any]:
    peer = peer or desk.peer("qgc")
    desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, kind), peer)
    (count,) = desk.replies()
    assert (count.id, count.mission_type) == (mavlink.MAVLINK_MSG_ID_MISSION_COUNT, kind)
    items = []
    for seq in range(count.count):
        desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, seq, kind), peer)
        items += desk.replies()
    assert [(i.seq, i.mission_type, i.target_system, i.target_component) for i in items] == [
        (n, kind, peer.system, peer.component) for n in range(count.count)
    ]
    return items


FLAVOURS = [
    waypoint(0, current=1),
    waypoint(
        1, param1=5.5, param2=float(struct.unpack("<f", struct.pack("<f", 0.1))[0]), z=math.nan, frame=6, autocontinue=0
    ),
    waypoint(2, x=-LAT, y=-1_799_999_999, frame=0, param4=float(struct.unpack("<f", b"\x01\x00\xc0\xff")[0])),
    waypoint(3, command=178, frame=2, param1=1.0, param2=0.5, param3=-1.0, param4=0.0, x=0, y=0, z=-0.0),
    waypoint(4, command=177, frame=2, param1=1.0, param2=3.0, param4=0.0, x=77, y=-5, z=0.0),
]


def test_a_download_equals_the_upload_bit_for_bit(desk: Desk) -> None:
    answer = upload(desk, FLAVOURS)
    assert (answer.type, answer.opaque_id) == (0, plan_id(desk.plans.items(MISSION))) and answer.opaque_id != 0
    assert desk.hub.announced == [42]
    assert [bits(i) for i in desk.plans.items(MISSION)] == [bits(i) for i in FLAVOURS]
    desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    (count,) = desk.replies()
    assert count.opaque_id == answer.opaque_id
    assert [bits(i) for i in download(desk)] == [bits(i) for i in FLAVOURS]


def test_fence_and_rally_are_lists_of_their_own(desk: Desk) -> None:
    fence = [
        *(
            waypoint(n, command=5001, frame=0, param1=3.0, param4=0.0, x=LAT + dx, y=LON + dy)
            for n, (dx, dy) in enumerate([(0, 0), (9000, 0), (0, 9000)])
        ),
        waypoint(3, command=5003, frame=0, param1=200.0, param4=0.0),
    ]
    rally = [waypoint(0, command=5100, param4=0.0)]
    for kind, items in ((FENCE, fence), (RALLY, rally), (MISSION, [waypoint(0)])):
        assert upload(desk, items, kind).type == 0
    assert [bits(i) for i in download(desk, FENCE)] == [bits(i) for i in fence]
    assert [bits(i) for i in download(desk, RALLY)] == [bits(i) for i in rally]
    assert len(download(desk, MISSION)) == 1


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_nothing_there_is_a_count_of_zero(desk: Desk, kind: int) -> None:
    assert download(desk, kind) == []
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 0, kind))
    assert [r.type for r in desk.replies()] == [PlanResult.INVALID_SEQUENCE]


def test_a_count_of_zero_clears(desk: Desk) -> None:
    upload(desk, [waypoint(0)])
    answer = upload(desk, [])
    assert (answer.type, answer.opaque_id) == (0, 0) and desk.plans.items(MISSION) == ()


@pytest.mark.parametrize("count", [CAPACITY + 1, 20_000, 65_535])
def test_too_many_are_refused_before_the_first_request(desk: Desk, count: int) -> None:
    upload(desk, [waypoint(0)])
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, count, 0))
    (answer,) = desk.replies()
    assert answer.type == PlanResult.NO_SPACE and len(desk.plans.items(MISSION)) == 1
    assert str(CAPACITY) in desk.texts()[0]


def test_as_many_as_there_is_room_for(desk: Desk) -> None:
    items = [waypoint(n) for n in range(CAPACITY)]
    assert upload(desk, items).type == 0
    assert desk.plans.items(MISSION)[-1].x == LAT + CAPACITY - 1


@pytest.mark.parametrize(
    ("bad", "result"),
    [
        ({"command": 9999}, PlanResult.UNSUPPORTED),
        ({"command": 5100}, PlanResult.UNSUPPORTED),
        ({"frame": 1}, PlanResult.UNSUPPORTED_FRAME),
        ({"x": 900_000_001}, PlanResult.INVALID_PARAM5_X),
        ({"y": -1_800_000_001}, PlanResult.INVALID_PARAM6_Y),
        ({"param1": -5.0}, PlanResult.INVALID_PARAM1),
    ],
)
def test_an_item_is_refused_at_once_with_its_reason(desk: Desk, bad: dict[str, Any], result: PlanResult) -> None:
    upload(desk, [waypoint(0)])
    answer = upload(desk, [waypoint(0), waypoint(1, **bad), waypoint(2)])
    assert (answer.type, answer.opaque_id) == (result, 0)
    assert len(desk.plans.items(MISSION)) == 1
    (text,) = desk.texts()
    assert text.startswith("mission item 2: ") and text.count("item 2:") == 1
    desk.wait(8.0)
    assert desk.replies() == []
    desk.tell(item_int(waypoint(1, **bad)))  # again, for the answer was lost
    desk.wait(0.0)
    assert desk.replies() == []


def test_a_refused_item_that_comes_again_is_refused_again(desk: Desk) -> None:
    bad = waypoint(0, command=9999)
    upload(desk, [bad])
    desk.tell(item_int(bad))
    assert [r.type for r in desk.replies()] == [PlanResult.UNSUPPORTED]


def test_the_whole_plan_is_checked_before_it_is_accepted(desk: Desk) -> None:
    upload(desk, [waypoint(0)])
    answer = upload(desk, [waypoint(0), waypoint(1, command=177, frame=2, param1=7.0, param2=1.0)])
    assert answer.type == PlanResult.INVALID_PARAM1 and len(desk.plans.items(MISSION)) == 1
    assert "item 2: DO_JUMP to item 8" in desk.texts()[0]


@pytest.mark.parametrize(("kind", "command"), [(MISSION, 16), (MISSION, 19), (RALLY, 5100)])
def test_latitude_and_longitude_0_is_no_place(desk: Desk, kind: PlanKind, command: int) -> None:
    nowhere = waypoint(1, command=command, x=0, y=0, param4=0.0)
    answer = upload(desk, [waypoint(0, command=command, param4=0.0), nowhere], kind)
    assert answer.type == PlanResult.INVALID_PARAM5_X and desk.plans.items(kind) == ()
    (said,) = desk.texts()
    assert "item 2: " in said and said.endswith("is at latitude 0, longitude 0; give it a place")


@pytest.mark.parametrize(("home", "result"), [((0.005, -0.005), 0), ((0.02, 0.0), 10)])
def test_but_for_a_boat_that_lives_there(desk: Desk, home: tuple[float, float], result: int) -> None:
    desk.supervisor.home = Home(*home, 0.0)
    assert upload(desk, [waypoint(0, x=0, y=0)]).type == result


def test_on_the_equator_or_the_meridian_is_a_place(desk: Desk) -> None:
    assert upload(desk, [waypoint(0, x=0), waypoint(1, y=0)]).type == 0


def test_what_is_missing_is_asked_for_again(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.heard()
    desk.wait(0.5)
    assert [r.seq for r in desk.replies()] == [0]
    desk.tell(item_int(waypoint(1)))  # out of turn
    assert desk.replies() == []
    desk.tell(item_int(waypoint(0)))
    desk.tell(item_int(waypoint(0)))  # doubled
    assert [r.seq for r in desk.replies()] == [1]
    desk.wait(0.5)
    assert {r.seq for r in desk.replies()} == {1}


def test_a_silent_client_is_given_up(desk: Desk) -> None:
    upload(desk, [waypoint(0)])
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.wait(4.0)
    assert 6 <= len(desk.heard()) <= 12
    desk.wait(2.0)
    desk.heard()
    desk.wait(5.0)
    assert desk.heard() == [] and len(desk.plans.items(MISSION)) == 1
    assert "broke off at item 1" in desk.texts()[0]


def test_a_repeated_count_starts_again(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    desk.tell(item_int(waypoint(0)))
    desk.heard()
    assert upload(desk, [waypoint(0, x=1), waypoint(1)]).type == 0
    assert [i.x for i in desk.plans.items(MISSION)] == [1, LAT + 1]


def test_another_ground_station_is_denied_while_one_uploads(desk: Desk) -> None:
    other = desk.peer("other")
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.heard()
    for message in (
        mavlink.MAVLink_mission_count_message(1, 1, 2, 0),
        mavlink.MAVLink_mission_clear_all_message(1, 1, 0),
        mavlink.MAVLink_mission_clear_all_message(1, 1, 255),
        mavlink.MAVLink_mission_write_partial_list_message(1, 1, 0, 0, 0),
    ):
        desk.tell(message, other)
        ((to, answer),) = desk.heard()
        assert to == other and answer.type == PlanResult.DENIED
    desk.tell(item_int(waypoint(0, x=5)), other)
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, 15, 0), other)
    assert desk.heard() == []
    assert download(desk, 0, other) == []
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 0, 2), other)  # another list is free
    assert [r.type for r in desk.replies()] == [0]
    desk.tell(item_int(waypoint(0)))
    assert [r.type for r in desk.replies()] == [0]


def test_a_ground_station_whose_link_is_gone_blocks_no_other(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.peer("qgc").endpoint.gone = True
    desk.heard()
    assert upload(desk, [waypoint(0)], peer=desk.peer("other")).type == 0


@pytest.mark.parametrize("how", [PlanResult.OPERATION_CANCELLED, PlanResult.ERROR, 200])
def test_the_client_can_cancel(desk: Desk, how: int) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.tell(item_int(waypoint(0)))
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, how, 0))
    desk.heard()
    desk.tell(item_int(waypoint(1)))
    desk.wait(6.0)
    assert desk.heard() == [] and desk.plans.items(MISSION) == () and desk.texts() == []


def test_an_accepted_from_the_client_cancels_nothing(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, 0, 0))
    desk.heard()
    desk.tell(item_int(waypoint(0)))
    assert [r.type for r in desk.replies()] == [0]


def test_the_last_item_again_has_the_same_answer_for_a_while(desk: Desk) -> None:
    answer = upload(desk, [waypoint(0), waypoint(1)])
    desk.tell(item_int(waypoint(1)))
    (again,) = desk.replies()
    assert (again.type, again.opaque_id) == (0, answer.opaque_id)
    desk.tell(item_int(waypoint(0)))
    desk.tell(item_int(waypoint(1)), desk.peer("other"))
    desk.wait(6.0)
    desk.tell(item_int(waypoint(1)))
    assert desk.heard() == []


def test_items_as_floats(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.tell(mavlink.MAVLink_mission_item_message(1, 1, 0, 3, 16, 0, 1, 0, 0, 0, math.nan, 63.5, 10.25, 5.0, 0))
    desk.tell(mavlink.MAVLink_mission_item_message(1, 1, 1, 2, 178, 0, 1, 1, 0.5, -1, 0, 0, 0, 0, 0))
    assert desk.replies()[-1].type == 0
    assert [(i.x, i.y) for i in desk.plans.items(MISSION)] == [(635_000_000, 102_500_000), (0, 0)]
    desk.tell(mavlink.MAVLink_mission_request_message(1, 1, 0, 0))
    (item,) = desk.replies()
    assert (
        item.id == mavlink.MAVLINK_MSG_ID_MISSION_ITEM and (item.x, item.y) == (63.5, 10.25) and math.isnan(item.param4)
    )


@pytest.mark.parametrize(
    ("x", "y", "result"),
    [
        (math.inf, 1.0, PlanResult.INVALID_PARAM5_X),
        (1e30, 1.0, PlanResult.INVALID_PARAM5_X),
        (1.0, -math.inf, PlanResult.INVALID_PARAM6_Y),
        (91.0, 1.0, PlanResult.INVALID_PARAM5_X),
        (math.nan, 1.0, PlanResult.INVALID_PARAM5_X),
    ],
)
def test_floats_that_are_no_position(desk: Desk, x: float, y: float, result: PlanResult) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    desk.tell(mavlink.MAVLink_mission_item_message(1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, x, y, 0, 0))
    assert desk.replies()[-1].type == result


@pytest.mark.parametrize("kind", [3, 77, 255])
def test_unknown_kinds_of_plan(desk: Desk, kind: int) -> None:
    for message in (
        mavlink.MAVLink_mission_count_message(1, 1, 1, kind),
        mavlink.MAVLink_mission_request_list_message(1, 1, kind),
        mavlink.MAVLink_mission_request_int_message(1, 1, 0, kind),
        mavlink.MAVLink_mission_write_partial_list_message(1, 1, 0, 0, kind),
        mavlink.MAVLink_mission_request_partial_list_message(1, 1, 0, 0, kind),
    ):
        desk.tell(message)
        assert [(r.type, r.mission_type) for r in desk.replies()] == [(PlanResult.UNSUPPORTED, kind)]
    desk.tell(item_int(waypoint(0), kind))
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, 1, kind))
    assert desk.replies() == []


def test_items_in_any_order_and_several_at_once(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(6)])
    for seq in (5, 0, 3, 3):
        desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, seq, 0), desk.peer("other"))
    assert [(r.seq, r.x) for r in desk.replies()] == [(n, LAT + n) for n in (5, 0, 3, 3)]
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 6, 0))
    assert [r.type for r in desk.replies()] == [PlanResult.INVALID_SEQUENCE]


def test_a_reader_sees_one_list_though_another_is_put_in_force_meanwhile(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(4)])
    desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0), desk.peer("other"))
    desk.heard()
    upload(desk, [waypoint(n, x=n) for n in range(2)])
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 3, 0), desk.peer("other"))
    assert [r.x for r in desk.replies()] == [LAT + 3]
    desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, 0, 0), desk.peer("other"))
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 1, 0), desk.peer("other"))
    assert [r.x for r in desk.replies()] == [1]


def test_readers_are_forgotten(desk: Desk, service: Any) -> None:
    before = remembered(service)
    for component in range(200):
        desk.tell(
            mavlink.MAVLink_mission_request_list_message(1, 1, 0), Peer(desk.peer("qgc").endpoint, 255, component)
        )
    assert remembered(service) - before < 64 * 20
    desk.wait(16.0)
    assert remembered(service) == before


@pytest.mark.parametrize("kind", [0, 1, 2, 255])
def test_clear(desk: Desk, kind: int) -> None:
    changed: list[PlanKind] = []
    for one, command in ((MISSION, 16), (RALLY, 5100)):
        upload(desk, [waypoint(0, command=command)], one)
    desk.plans.on_change(changed.append)
    desk.tell(mavlink.MAVLink_mission_clear_all_message(1, 1, kind))
    ((to, answer),) = desk.heard()
    assert to == desk.peer("qgc") and (answer.type, answer.mission_type, answer.opaque_id) == (0, kind, 0)
    assert changed == {0: [MISSION], 1: [], 2: [RALLY], 255: [MISSION, RALLY]}[kind]


def test_clear_ends_ones_own_upload(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.tell(mavlink.MAVLink_mission_clear_all_message(1, 1, 255))
    desk.heard()
    desk.wait(3.0)
    assert desk.heard() == []


def test_set_current(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(3)])
    desk.hub.announced.clear()
    desk.tell(mavlink.MAVLink_mission_set_current_message(1, 1, 2))
    assert desk.supervisor.seq == 2 and desk.hub.announced == [42] and desk.heard() == []
    desk.tell(mavlink.MAVLink_mission_set_current_message(1, 1, 3))
    assert desk.supervisor.seq == 2 and desk.hub.announced == [42]
    assert desk.texts() == []  # for the supervisor has said why


def test_senders_to_a_vessel_in_fast_motion_get_more_of_its_time(desk: Desk) -> None:
    desk.hub.patience = 20.0
    desk.serve(MissionService(desk.hub, desk.vessel))
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    desk.heard()
    desk.wait(4.5)  # 0.2 s on the wall
    assert desk.heard() == []
    desk.wait(90.0)
    assert desk.texts() == []
    desk.wait(6.0)
    assert "broke off at item 1" in desk.texts()[0]


def test_part_of_a_list(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(5)])
    desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 1, 2, 0))
    assert [r.seq for r in desk.replies()] == [1]
    desk.tell(item_int(waypoint(1, z=7.0)))
    assert [r.seq for r in desk.replies()] == [2]
    assert desk.plans.items(MISSION)[1].z == 50.0
    desk.tell(item_int(waypoint(2, z=8.0)))
    assert [r.type for r in desk.replies()] == [0]
    assert [i.z for i in desk.plans.items(MISSION)] == [50.0, 7.0, 8.0, 50.0, 50.0]


def test_part_of_a_list_that_would_break_the_whole(desk: Desk) -> None:
    upload(desk, [waypoint(0)])
    desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 0, 9, 0))  # the end is taken as the list's
    desk.tell(item_int(waypoint(0, command=178, frame=2, param1=1.0, param2=0.5)))
    assert desk.replies()[-1].type == PlanResult.INVALID
    assert desk.plans.items(MISSION)[0].command == 16


def test_part_of_a_list_that_changed_meanwhile(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(3)])
    desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 2, 2, 0))
    desk.plans.replace(MISSION, (waypoint(0),))
    desk.tell(item_int(waypoint(2)))
    assert desk.replies()[-1].type == PlanResult.ERROR and len(desk.plans.items(MISSION)) == 1


@pytest.mark.parametrize(("first", "last"), [(5, 5), (2, 1), (-1, 2), (9, 12)])
def test_parts_that_are_none(desk: Desk, first: int, last: int) -> None:
    upload(desk, [waypoint(n) for n in range(5)])
    desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, first, last, 0))
    assert [r.type for r in desk.replies()] == [PlanResult.INVALID_SEQUENCE]


# --- home at item 0 ------------------------------------------------------------------------------------------------

ROVER_PLAN = [
    waypoint(0, frame=0, x=1, y=2, z=3.0, param4=0.0),
    waypoint(1),
    waypoint(2),
    waypoint(3, command=177, frame=2, param1=1.0, param2=2.0, param4=0.0, x=0, y=0, z=0.0),
]


def test_item_zero_is_home_both_ways(desk: Desk) -> None:
    rover = desk.peer("rover")
    assert upload(desk, ROVER_PLAN, peer=rover).type == 0
    kept = desk.plans.items(MISSION)
    assert [(i.seq, i.command) for i in kept] == [(0, 16), (1, 16), (2, 177)] and kept[2].param1 == 0.0
    back = download(desk, 0, rover)
    assert (back[0].command, back[0].frame, back[0].x, back[0].y, back[0].z) == (16, 0, 634_400_000, 104_000_000, 2.5)
    assert [bits(i) for i in back[1:]] == [bits(i) for i in ROVER_PLAN[1:]]
    assert [i.param1 for i in download(desk) if i.command == 177] == [0.0]
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 4, 0), rover)
    assert [r.type for r in desk.replies()] == [PlanResult.INVALID_SEQUENCE]


def test_home_alone_is_no_mission(desk: Desk) -> None:
    rover = desk.peer("rover")
    upload(desk, ROVER_PLAN, peer=rover)
    answer = upload(desk, ROVER_PLAN[:1], peer=rover)
    assert (answer.type, answer.opaque_id) == (0, 0) and desk.plans.items(MISSION) == ()
    assert download(desk, 0, rover) == []


def test_home_can_be_read_without_a_mission(desk: Desk) -> None:
    """DroneKit reads item 0 whatever the count is, and waits for it."""
    rover = desk.peer("rover")
    assert download(desk, 0, rover) == []
    for request in (mavlink.MAVLink_mission_request_int_message, mavlink.MAVLink_mission_request_message):
        desk.tell(request(1, 1, 0, 0), rover)
        (home,) = desk.replies()
        assert (home.seq, home.command) == (0, 16) and home.x in (634_400_000, pytest.approx(63.44))
    desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 1, 0), rover)
    assert [r.type for r in desk.replies()] == [PlanResult.INVALID_SEQUENCE]


def test_an_unknown_home_is_zeros(desk: Desk) -> None:
    desk.supervisor.home = None
    upload(desk, [waypoint(0)])
    home, _ = download(desk, 0, desk.peer("rover"))
    assert (home.x, home.y, home.z) == (0, 0, 0.0)


def test_the_item_in_the_place_of_home_is_not_checked(desk: Desk) -> None:
    assert upload(desk, [waypoint(0, command=0, frame=77, x=2**31 - 1), waypoint(1)], peer=desk.peer("rover")).type == 0


def test_an_item_has_the_same_number_for_people_on_every_link(desk: Desk) -> None:
    """The second item: 2 on QGroundControl's map (sequence number 1), and 2 on a link whose item 0 is home."""
    upload(desk, [waypoint(0), waypoint(1, command=9999)])
    said = desk.texts()
    desk.wait(11.0)  # the same text is said once in 10 s
    upload(desk, [ROVER_PLAN[0], waypoint(1), waypoint(2, command=9999)], peer=desk.peer("rover"))
    assert desk.texts() == said and said[0].startswith("mission item 2: command 9999 is not supported")


def test_a_jump_names_its_target_by_the_number_for_people(desk: Desk) -> None:
    """Sequence number 7 is the eighth item; on a link whose item 0 is home the eighth item is 8."""
    upload(desk, [waypoint(0), waypoint(1, command=177, frame=2, param1=7.0, param2=1.0)])
    said = desk.texts()
    desk.wait(11.0)
    jump = waypoint(2, command=177, frame=2, param1=8.0, param2=1.0)
    upload(desk, [ROVER_PLAN[0], waypoint(1), jump], peer=desk.peer("rover"))
    assert desk.texts() == said and "item 2: DO_JUMP to item 8" in said[0]


def test_an_upload_breaks_off_at_the_same_number_on_every_link(desk: Desk) -> None:
    said = []
    for name, count in (("qgc", 2), ("rover", 3)):
        peer = desk.peer(name)
        desk.tell(mavlink.MAVLink_mission_count_message(1, 1, count, 0), peer)
        for seq in range(count - 1):
            desk.tell(item_int(waypoint(seq)), peer)
        desk.wait(16.0)
        said.append(desk.texts())
    assert said[0] == said[1] == ["mission upload broke off at item 2: old one kept"]


@pytest.mark.parametrize(("wire", "seq"), [(0, 0), (1, 0), (3, 2)])
def test_set_current_with_home_at_zero(desk: Desk, wire: int, seq: int) -> None:
    upload(desk, [waypoint(n) for n in range(3)])
    desk.supervisor.seq = -1
    desk.tell(mavlink.MAVLink_mission_set_current_message(1, 1, wire), desk.peer("rover"))
    assert desk.supervisor.seq == seq


def test_fence_and_rally_have_no_home(desk: Desk) -> None:
    rover = desk.peer("rover")
    rally = [waypoint(0, command=5100, param4=0.0)]
    assert upload(desk, rally, RALLY, rover).type == 0
    assert [bits(i) for i in download(desk, RALLY, rover)] == [bits(i) for i in rally]


def test_room_for_home_beside_a_full_list(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, CAPACITY + 1, 0), desk.peer("rover"))
    assert desk.replies()[0].id == mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT


def test_part_of_a_list_with_home_at_zero(desk: Desk) -> None:
    upload(desk, [waypoint(n) for n in range(3)])
    rover = desk.peer("rover")
    desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 2, 2, 0), rover)
    assert [r.seq for r in desk.replies()] == [2]
    desk.tell(item_int(waypoint(2, z=9.0)), rover)
    assert desk.replies()[-1].type == 0
    assert [i.z for i in desk.plans.items(MISSION)] == [50.0, 9.0, 50.0]


@pytest.mark.parametrize("useless", ["silent", "wrong items", "begins again"])
def test_who_sends_nothing_useful_loses_the_slot_to_who_asks(desk: Desk, useless: str) -> None:
    other = desk.peer("other")
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 9, 0))
    for _ in range(9):
        desk.wait(0.2)
        if useless == "wrong items":
            desk.tell(item_int(waypoint(5)))
        elif useless == "begins again":
            desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 9, 0))
        desk.heard()
        desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0), other)
        assert [r.type for to, r in desk.heard() if to == other] == [PlanResult.DENIED]
    desk.wait(0.3)
    desk.heard()
    desk.texts()
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0), other)
    to_first = [(r.get_type(), r.type) for to, r in desk.heard() if to == desk.peer("qgc")]
    assert to_first == [("MISSION_ACK", PlanResult.OPERATION_CANCELLED)]
    assert desk.texts() == ["mission upload by 255 ended at 1: 254 asks"]
    desk.tell(item_int(waypoint(0, x=7)), other)
    assert [i.x for i in desk.plans.items(MISSION)] == [7]


def test_a_trickle_is_of_no_use_for_ever(desk: Desk) -> None:
    other = desk.peer("other")
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 10_000, 0))
    denied = 0
    for seq in range(60):
        desk.wait(1.9)
        desk.tell(item_int(waypoint(seq)))
        desk.heard()
        desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 1, 0), other)
        if [r.get_type() for to, r in desk.heard() if to == other] != ["MISSION_ACK"]:
            break
        denied += 1
    assert 10 < denied < 17


def test_an_upload_that_goes_on_is_not_taken_but_by_who_is_trusted(desk: Desk) -> None:
    other = desk.peer("other")
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 200, 0))
    for seq in range(100):
        desk.wait(0.5)
        desk.tell(item_int(waypoint(seq)))
        desk.heard()
        desk.tell(mavlink.MAVLink_mission_clear_all_message(1, 1, 0), other)
        assert [r.type for to, r in desk.heard() if to == other] == [PlanResult.DENIED]
    other.endpoint.trusted = True
    desk.tell(mavlink.MAVLink_mission_clear_all_message(1, 1, 255), other)
    assert [r.type for to, r in desk.heard() if to == other] == [PlanResult.ACCEPTED]
