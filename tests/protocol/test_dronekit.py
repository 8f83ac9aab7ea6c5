"""What DroneKit-Python and scripts with pymavlink send, in their order, against a whole vessel in lockstep.

Facts from DroneKit 2.9.2 (dronekit/__init__.py: `is_armable`, `simple_goto`, `CommandSequence`), and from scripts for
ArduPilot in public repositories, which wait for MISSION_REQUEST. Both were tried with a running boat.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk, of, rover_desk

ACCEPTED, DENIED = 0, 14  # MAV_MISSION_RESULT
ARM, SET_MODE = 400, 176
HOLD, GUIDED = 4, 15
RELATIVE_ALT, WAYPOINT = 3, 16
PREDICTED_ABSOLUTE = 512  # EKF_STATUS_FLAGS
FRAME = LocalFrame(63.4389, 10.3990)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with rover_desk(tmp_path) as desk:
        desk.ready()
        yield desk


def item(seq: int, north_m: float, current: int = 0, target: int = 1) -> Any:
    """MISSION_ITEM, the old form, as DroneKit and MAVWPLoader make it."""
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, 0.0)
    head = (target, target, seq, RELATIVE_ALT, WAYPOINT, current, 0 if current else 1)
    return mavlink.MAVLink_mission_item_message(*head, 0.0, 0.0, 0.0, 0.0, lat_deg, lon_deg, 0.0)


def armable(desk: Desk) -> bool:
    report = desk.latest("EKF_STATUS_REPORT")
    return report is not None and bool(report.flags & PREDICTED_ABSOLUTE) and desk.latest("GPS_RAW_INT").fix_type > 1


def test_a_boat_with_a_position_is_armable(desk: Desk) -> None:
    """Its examples wait for that before anything else."""
    desk.tick(20)
    assert armable(desk)


def test_a_px4_link_has_no_report_that_its_clients_do_not_know(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    try:
        desk.ready()
        desk.tick(50)
        assert desk.latest("EKF_STATUS_REPORT") is None
    finally:
        desk.close()


def test_simple_goto(desk: Desk) -> None:
    """A waypoint with current = 2, addressed to all."""
    assert desk.result(ARM, 1.0) == 0
    assert desk.result(SET_MODE, 1.0, float(HOLD)) == 0
    assert [ack.type for ack in of(desk.tell(item(0, 20.0, 2, target=0)), "MISSION_ACK")] == [DENIED]
    assert desk.result(SET_MODE, 1.0, float(GUIDED)) == 0
    assert [ack.type for ack in of(desk.tell(item(0, 20.0, 2, target=0)), "MISSION_ACK")] == [ACCEPTED]
    desk.tick(12)
    tick = desk.vessel.last_tick
    assert tick is not None and tick.setpoint.progress.target.north_m == pytest.approx(20.0, abs=0.7)
    assert desk.latest("HEARTBEAT").custom_mode == GUIDED
    assert "Go-to refused: choose Guided first" in desk.texts()


def test_a_download_without_a_mission_ends_with_home(desk: Desk) -> None:
    (count,) = of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")
    assert count.count == 0
    (home,) = of(desk.tell(mavlink.MAVLink_mission_request_message(1, 1, 0, 0)), "MISSION_ITEM")
    assert (home.seq, home.x) == (0, pytest.approx(63.4389, abs=1e-4))


@pytest.mark.parametrize("link", ["memory:desk", "memory:desk?dialect=ardupilot"])
def test_an_upload_that_waits_for_the_old_request(tmp_path: Path, link: str) -> None:
    """waypoint_clear_all_send, waypoint_count_send, then recv_match(type="MISSION_REQUEST") for each item."""
    desk = Desk(tmp_path, link=link)
    try:
        desk.ready()
        items = [item(seq, 5.0 * seq) for seq in range(4)]
        desk.tell(mavlink.MAVLink_mission_clear_all_message(1, 1), mavlink.MAVLink_mission_count_message(1, 1, 4))
        heard: list[Any] = []
        while not of(heard, "MISSION_REQUEST"):
            assert desk.rig.now_s < 30.0
            heard = desk.tick()
        for wanted in items:
            (request,) = of(heard, "MISSION_REQUEST")
            assert request.seq == wanted.seq
            heard = desk.tell(wanted)
        desk.until("the mission is in force", lambda: len(desk.vessel.plans.items(0)) == 4 - ("ardupilot" in link))
    finally:
        desk.close()
