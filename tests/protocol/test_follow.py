"""Following by protocol, against a whole vessel in lockstep: a ground station's stream, commands, mission items."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk, Sender
from tests.protocol.test_qgroundcontrol import ARM, FRAME, HOLD, MANUAL, MISSION, NAN, item

FOLLOW = 0x08040000
DO_FOLLOW, DO_FOLLOW_REPOSITION, STATION, PAUSE_CONTINUE = 32, 33, 31012, 193
ACCEPTED, REJECTED, DENIED = (
    mavlink.MAV_RESULT_ACCEPTED,
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED,
    mavlink.MAV_RESULT_DENIED,
)


class Phone:
    """FOLLOW_TARGET as QGroundControl sends it: 4 Hz, position and velocity, no heading; here while `on`."""

    def __init__(self, desk: Desk, system: int = 77) -> None:
        self.desk, self.on = desk, True
        self.north_m, self.speed_mps = 30.0, 0.3
        self._sender = Sender(system)
        self._next_s = desk.rig.now_s

    def sail(self, duration_s: float) -> None:
        for n in range(round(duration_s / self.desk.vessel.period_s)):
            now_s = self.desk.rig.now_s
            if self.on and now_s >= self._next_s - 1e-9:
                lat_deg, lon_deg = FRAME.to_geodetic(self.north_m + self.speed_mps * now_s, 0.0)
                message = mavlink.MAVLink_follow_target_message(
                    round(now_s * 1000), 3, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0, [self.speed_mps, 0.0, 0.0],
                    [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [0.0] * 3, [2.0, 0.0, 2.0], 0,
                )  # fmt: skip
                self.desk.rig.send(self._sender.packed(message))
                self._next_s = now_s + 0.25
            if n % 10 == 0:
                self.desk.heartbeat()
            self.desk.tick()

    def until(self, mode: int, timeout_s: float) -> float:
        """How long it took until a heartbeat showed this mode."""
        start_s = self.desk.rig.now_s
        while self.desk.latest("HEARTBEAT").custom_mode != mode:
            assert self.desk.rig.now_s - start_s < timeout_s, self.desk.texts()[-5:]
            self.sail(self.desk.vessel.period_s)
        return self.desk.rig.now_s - start_s


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(tmp_path)
    desk.tick()
    desk.ready()
    yield desk
    desk.close()


def said(desk: Desk, part: str) -> bool:
    """By now; events go out with the next tick, long ones in pieces."""
    desk.tick()
    return part in "".join(desk.texts())


def test_follow_me_of_a_ground_station_from_choice_to_loss_and_back(desk: Desk) -> None:
    phone = Phone(desk)
    assert desk.result(ARM, 1.0) == ACCEPTED
    assert desk.result(DO_FOLLOW, -1.0) == ACCEPTED and said(desk, "Follow waits for the leader: no leader heard")
    phone.on = False
    assert 9.5 < phone.until(HOLD, 12.0) < 10.5 and said(desk, "No leader heard: Hold")
    phone.on = True
    desk.vessel.parameters.set("FOLL_WAIT_T", 0.0)
    assert desk.result(DO_FOLLOW, -1.0) == REJECTED and said(desk, "Follow refused: no leader heard")
    assert desk.result(ARM, 0.0) == ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, FOLLOW))  # disarmed, before the ground station sends where it is
    desk.tick(2)
    assert desk.latest("HEARTBEAT").custom_mode == FOLLOW
    assert desk.result(ARM, 1.0) == REJECTED and said(desk, "PreArm: Follow: no leader heard")
    phone.sail(2.0)
    assert desk.result(ARM, 1.0) == ACCEPTED
    phone.sail(20.0)
    assert desk.latest("HEARTBEAT").custom_mode == FOLLOW and desk.rig.world.truth.north_m > 3.0
    phone.on = False
    assert 0.25 < phone.until(HOLD, 2.0) <= 1.0
    assert said(desk, "Leader silent for 0.") and desk.vessel.supervisor.status(desk.rig.now_s).failsafes == (
        "leader_lost",
    )
    phone.on = True
    assert 3.0 <= phone.until(FOLLOW, 5.0) <= 3.6
    assert desk.result(DO_FOLLOW, 0.0) == ACCEPTED
    desk.tick(2)
    assert desk.latest("HEARTBEAT").custom_mode == HOLD
    assert desk.result(DO_FOLLOW, 77.0) == ACCEPTED and desk.vessel.parameters["FOLL_SYSID"] == 77
    assert desk.result(DO_FOLLOW, 78.0) == REJECTED and said(desk, "leader 78 not heard yet")
    assert desk.vessel.parameters["FOLL_SYSID"] == 77, "a mistyped number changes nothing"


def test_stations_by_command_and_by_parameter(desk: Desk) -> None:
    following = desk.vessel.supervisor.following

    def station() -> tuple[float, float]:
        distance_m, bearing_rad = following.follow_position
        return distance_m, math.degrees(bearing_rad)

    assert desk.result(STATION, 90.0, 30.0) == ACCEPTED and station() == pytest.approx((30.0, 90.0))
    assert desk.result(STATION, NAN, 25.0) == ACCEPTED and station() == pytest.approx((25.0, 90.0))
    assert desk.result(STATION, NAN, 5.0) == DENIED and said(desk, "Follow position refused: FOLL_MIN_DIST is 12 m")
    assert desk.result(STATION, 90.0, 0.0) == DENIED and desk.result(STATION, 999.0, NAN) == DENIED
    assert desk.result(DO_FOLLOW_REPOSITION, 0.0, 0.0, 0.0, 0.0, 0.0, -20.0, 20.0) == ACCEPTED
    assert station() == pytest.approx((math.hypot(20.0, 20.0), 135.0))
    assert desk.result(DO_FOLLOW_REPOSITION) == DENIED  # filled with 0: on top of the leader
    desk.tell(mavlink.MAVLink_param_set_message(1, 1, b"FLW_TGT_DST", 40.0, 9))
    assert station() == pytest.approx((40.0, 180.0))


def test_what_mavsdks_follow_me_reads_and_writes_is_there(desk: Desk) -> None:
    for name, value in (
        (b"FLW_TGT_HT", 12.0),
        (b"FLW_TGT_DST", 15.0),
        (b"FLW_TGT_FA", 90.0),
        (b"FLW_TGT_RS", 0.5),
        (b"FLW_TGT_MAX_VEL", 8.0),
    ):
        (answer,) = [
            m
            for m in desk.tell(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
            if m.get_type() == "PARAM_VALUE"
        ]
        assert (answer.param_id, answer.param_value, answer.param_type) == (
            name.decode(),
            value,
            mavlink.MAV_PARAM_TYPE_REAL32,
        )
    (answer,) = [
        m
        for m in desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, b"FLW_TGT_ALT_M", -1))
        if m.get_type() == "PARAM_VALUE"
    ]
    assert answer.param_type == mavlink.MAV_PARAM_TYPE_INT32


def do(seq: int, command: int, *params: float) -> Any:
    return item(seq, command, 0.0, 0.0, *params, *(NAN for _ in range(4 - len(params))), frame=2)


def test_a_mission_that_follows_and_goes_on_when_continued(desk: Desk) -> None:
    phone = Phone(desk)
    plan = [
        item(0, 16, 6.0, 0.0, 0.0, 0.0, 0.0, NAN), do(1, STATION, 180.0, 15.0), do(2, DO_FOLLOW, -1.0),
        item(3, 16, 6.0, 10.0, 0.0, 0.0, 0.0, NAN),
    ]  # fmt: skip
    assert desk.upload(plan) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    assert desk.result(ARM, 1.0) == ACCEPTED
    phone.until(FOLLOW, 60.0)
    phone.sail(5.0)
    assert said(desk, "Item 3: following; choose Mission for item 4")
    assert desk.vessel.supervisor.following.follow_position == pytest.approx((15.0, math.pi))
    assert desk.latest("MISSION_CURRENT").seq == 3
    assert desk.result(PAUSE_CONTINUE, 1.0) == ACCEPTED
    phone.until(MISSION, 1.0)
    phone.until(HOLD, 90.0)
    assert said(desk, "Mission complete")
    assert desk.result(ARM, 0.0) == ACCEPTED
    desk.tick()
    assert desk.vessel.supervisor.following.follow_position == pytest.approx((20.0, math.pi))


@pytest.mark.parametrize(
    ("command", "params", "result"),
    [
        (DO_FOLLOW, (0.0,), mavlink.MAV_MISSION_INVALID_PARAM1),
        (DO_FOLLOW, (256.0,), mavlink.MAV_MISSION_INVALID_PARAM1),
        (STATION, (500.0, 20.0), mavlink.MAV_MISSION_INVALID_PARAM1),
        (STATION, (90.0, 0.0), mavlink.MAV_MISSION_INVALID_PARAM2),
        (DO_FOLLOW_REPOSITION, (), mavlink.MAV_MISSION_UNSUPPORTED),
    ],
)
def test_items_that_are_refused_at_upload(desk: Desk, command: int, params: tuple[float, ...], result: int) -> None:
    assert desk.upload([item(0, 16, 6.0, 0.0, 0.0, 0.0, 0.0, NAN), do(1, command, *params)]) == result


def test_a_ground_station_that_leads_keeps_its_sticks(desk: Desk) -> None:
    """QGroundControl's own follow-me: it is no lead boat's module."""
    phone = Phone(desk, system=255)
    phone.sail(2.0)
    desk.tell(
        mavlink.MAVLink_set_mode_message(1, 1, MANUAL), mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0, 0)
    )
    assert desk.result(ARM, 1.0) == ACCEPTED
    desk.tell(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 0, 0, 0))
    desk.tick()
    assert any(thruster.force_n > 1.0 for thruster in desk.vessel.last_tick.allocation.thrusters)  # type: ignore[union-attr]
    assert not said(desk, "not obeyed")
