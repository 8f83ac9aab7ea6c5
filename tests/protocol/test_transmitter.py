"""The transmitter's switches as a person sets them up in QGroundControl and throws them: a whole vessel in lockstep, its
receiver on the thruster board."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from companion.core.storing import Stored, Ticket
from companion.io.mavlink.wire import messages as mavlink
from companion.loop import NoStorage
from companion.mission.plan import PlanKind
from tests.protocol.desk import Desk, of
from tests.protocol.test_qgroundcontrol import ARM, HOLD, MANUAL, RTL
from tests.protocol.test_qgroundcontrol_pages import write

CENTRED = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)
ON = 2000


class Medium(NoStorage):
    """A slow one: `ticket` of the last plan, settled by the test."""

    def __init__(self) -> None:
        self.plans: list[Sequence[Any]] = []
        self.ticket = Ticket()

    def plan(self, kind: int, items: Sequence[Any]) -> Ticket:
        self.plans.append(items)
        self.ticket = Ticket()
        return self.ticket


class Hand:
    """Holds the transmitter."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.pulses = list(CENTRED)
        self.throw()

    def throw(self, **pulses: int) -> None:
        """`c6=2000`: that channel, held for a second."""
        for name, pulse_us in pulses.items():
            self.pulses[int(name[1:]) - 1] = pulse_us
        self.desk.rig.world.set_transmitter(self.pulses)
        self.desk.heartbeat()
        self.desk.tick(round(1.0 / self.desk.vessel.period_s))

    @property
    def armed(self) -> bool:
        return bool(self.desk.latest("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def mode(self) -> int:
        return int(self.desk.latest("HEARTBEAT").custom_mode)


@pytest.fixture
def hand(tmp_path: Path) -> Iterator[Hand]:
    desk = Desk(tmp_path)
    desk.tick()
    hand = Hand(desk)
    desk.ready()
    yield hand
    desk.close()


def test_arm_mode_and_kill_by_the_transmitter_alone(hand: Hand) -> None:
    desk = hand.desk
    for name, value in {
        "MAN_RC_SAFE_CH": 0, "RC_MAP_FLTMODE": 5, "RC_MAP_ARM_SW": 6, "RC_MAP_KILL_SW": 7, "RC_MAP_RETURN_SW": 8,
        "COM_FLTMODE1": 0, "COM_FLTMODE6": 4,
    }.items():  # fmt: skip
        assert write(desk, name, value) == value
    hand.throw()
    assert "Mode switch at 1, Manual: it acts when moved" in desk.texts()
    hand.throw(c5=ON)
    assert hand.mode == HOLD and not hand.armed
    hand.throw(c6=ON)
    assert hand.armed
    hand.throw(c8=ON)
    assert hand.mode == RTL
    hand.throw(c8=1000)
    assert hand.mode == HOLD, "back to the mode switch"
    hand.throw(c5=1000)
    assert hand.mode == MANUAL
    hand.throw(c2=1800)
    tick = desk.vessel.last_tick
    assert tick is not None and any(thruster.throttle > 0.1 for thruster in tick.command.thrusters)

    hand.desk.rig.world.set_transmitter([*hand.pulses[:6], ON, hand.pulses[7]])
    desk.tick(2)
    tick = desk.vessel.last_tick
    assert (
        tick is not None and not tick.status.armed and not any(thruster.throttle for thruster in tick.command.thrusters)
    )
    assert "Kill switch is on: thrusters stopped" in desk.texts()
    hand.throw(c7=ON)
    for force in (0.0, 2989.0):
        assert desk.result(ARM, 1.0, force) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    hand.throw(c7=1000, c2=1500)
    assert not hand.armed, "it stays disarmed until somebody arms it"
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED


def test_radio_calibration_as_qgroundcontrol_writes_it(hand: Hand) -> None:
    """A transmitter whose forward stick is reversed, on channel 3, with short travel."""
    desk = hand.desk
    hand.throw(c3=1880)
    assert desk.latest("RC_CHANNELS").chan3_raw == 1880
    for name, value in {"RC3_MIN": 1120, "RC3_TRIM": 1500, "RC3_MAX": 1880, "RC3_REV": -1, "RC_MAP_PITCH": 3}.items():
        assert write(desk, name, value) == value
    hand.throw()
    live = desk.vessel.supervisor.parts.sticks.live(desk.rig.now_s)
    assert live is not None and live.surge == pytest.approx(-1.0)
    assert desk.latest("RC_CHANNELS").chan3_raw == 1880, "the monitor shows the pulse as it comes"


def test_a_mission_is_taught_by_the_transmitter_and_read_by_the_ground_station(hand: Hand) -> None:
    """ArduPilot's function 7: each move of the switch appends a waypoint, which is stored before it is announced."""
    desk = hand.desk
    for name, value in {"MAN_RC_SAFE_CH": 0, "RC7_OPTION": 7, "RC8_OPTION": 58}.items():
        assert write(desk, name, value) == value
    hand.throw()
    medium = Medium()
    desk.vessel.store_in(medium)
    for count in (1, 2):
        hand.throw(c7=ON)
        hand.throw(c7=1000)
        assert f"Waypoint saved: item {count}" not in desk.texts() and len(medium.plans[-1]) == count
        medium.ticket.state = Stored.DURABLE
        desk.until("it is stored", lambda n=count: f"Waypoint saved: item {n}" in desk.texts())  # type: ignore[misc]
    (count,) = of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")
    assert count.count == 2
    (item,) = of(desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 1, 0)), "MISSION_ITEM_INT")
    home = desk.vessel.config.home
    assert (item.command, item.x * 1e-7, item.y * 1e-7) == (
        16,
        pytest.approx(home.lat_deg, abs=1e-4),
        pytest.approx(home.lon_deg, abs=1e-4),
    )
    hand.throw(c8=ON)
    medium.ticket.state = Stored.DURABLE
    desk.until("it is cleared", lambda: "Mission cleared by the transmitter" in desk.texts())
    (count,) = of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")
    assert count.count == 0


def test_a_ground_stations_mission_and_the_transmitters_waypoint_in_the_same_moment(hand: Hand) -> None:
    """Whoever is stored last has the whole mission; the other is told."""
    desk = hand.desk
    for name, value in {"MAN_RC_SAFE_CH": 0, "RC7_OPTION": 7}.items():
        assert write(desk, name, value) == value
    hand.throw()
    assert desk.upload([waypoint(0), waypoint(1)]) == 0
    tick = desk.vessel.last_tick
    assert tick is not None
    desk.vessel.supervisor.mission_edits.save_waypoint(tick.nav, desk.rig.now_s)
    assert desk.upload([waypoint(0)]) == 0
    desk.tick(10)
    count = len(desk.vessel.plans.items(PlanKind.MISSION))
    assert ("Waypoint saved: item 2" in desk.texts()) is (count == 2)
    assert count in (1, 2) and not desk.vessel.supervisor.mission_edits.under_way


def waypoint(seq: int) -> Any:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, 3, 16, 0, 1, 0.0, 0.0, 0.0, float("nan"), 634400000 + seq * 1000, 103990000, 0.0, 0
    )
