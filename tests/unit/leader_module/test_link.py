"""A leader module's links: towards the follower, and to a ground station on board."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from typing import Any

import pytest

from companion.core.readings import ManualInput, Wish
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer
from companion.io.mavlink.wire.links import MemoryLink, StreamLink
from companion.io.mavlink.wire.personas import PX4
from companion.leader_module.app import status_line
from companion.leader_module.crew_wish import CrewWish
from companion.leader_module.ground_station import LeadGroundStation
from companion.leader_module.link import Broadcast, LeadLink
from sitl.memory import MemoryStream
from tests.protocol.desk import Sender
from tests.unit.io.mavlink.services.test_leader import NAV


class Lead:
    """A module's link whose far end is ours: the follower is system 1."""

    def __init__(self) -> None:
        self.memory, self.said = MemoryLink("memory:lead"), []
        self.link = LeadLink(self.memory, 42, 1, 20.0, False, lambda now_s, text: self.said.append(text))
        self._sender, self._framer, self.now_s = Sender(1, 1), Framer(), 10.0

    def tell(self, *messages: Any, sender: Sender | None = None) -> list[Any]:
        for message in messages:
            self.memory.to_vessel((sender or self._sender).packed(message))
        self.link.serve(self.now_s)
        return self._framer.feed(self.memory.from_vessel())

    def line(self, **nav: Any) -> str:
        return status_line(
            Broadcast(replace(NAV, t_s=self.now_s, **nav), True, Wish.AUTONOMOUS, 1, None),
            self.link.follower,
            self.link.counter,
        )


@pytest.fixture
def lead() -> Lead:
    return Lead()


def test_what_the_follower_reports_is_shown(lead: Lead) -> None:
    assert lead.line().startswith("follower not heard yet | ")
    lead.tell(
        mavlink.MAVLink_heartbeat_message(11, 12, 0x81, 0x08040000, 4, 3),
        mavlink.MAVLink_global_position_int_message(1, 576300000, 115496650, 0, 0, 0, 400, 0, 9000),
        mavlink.MAVLink_debug_vect_message(b"follow", 1, 0.47, -12.0, 5.0),
        mavlink.MAVLink_debug_vect_message(b"other", 1, 0.9, 0.9, 0.9),
    )
    assert lead.line() == (
        "follower Follow armed gap 20 m throttle 47 % nozzle -12 | link 0 | asks Autonomous [m r a] | FIX_3D 8.0 m/s 120 57.63000 11.55000"
    )
    assert "| link 0 |" in lead.line()[:79], "the end is cut off on a terminal of 80 columns"
    assert " 000 57" in lead.line(yaw_rad=math.radians(359.7))
    lead.now_s += 1.0
    assert "gap 16 m" in lead.line(), "it comes nearer by 4 m a second"
    lead.now_s += 10.0
    assert lead.line().startswith("follower silent for 11 s | ")


def test_modes_of_other_personas_and_of_none(lead: Lead) -> None:
    lead.tell(mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 1, 6, 4, 3))
    assert lead.link.follower.mode == "Follow"
    lead.tell(mavlink.MAVLink_heartbeat_message(11, 12, 1, 77, 4, 3))
    assert lead.link.follower.mode == "mode 77"


def test_others_are_not_the_follower(lead: Lead) -> None:
    beat = mavlink.MAVLink_heartbeat_message(11, 12, 0x81, 0x08040000, 4, 3)
    lead.tell(beat, sender=Sender(2, 1))
    lead.tell(beat, sender=Sender(1, 154))
    assert lead.link.follower.heard_s is None


def test_texts_in_chunks_and_with_commands_for_the_terminal(lead: Lead) -> None:
    lead.tell(mavlink.MAVLink_statustext_message(4, b"short", 0, 0))
    lead.tell(
        mavlink.MAVLink_statustext_message(4, b"a" * 50, 7, 0), mavlink.MAVLink_statustext_message(4, b"b" * 3, 7, 1)
    )
    lead.tell(mavlink.MAVLink_statustext_message(4, b"\x1b[2Jwiped\x07", 0, 0))
    assert lead.said == ["short", "a" * 50 + "bbb", "[2Jwiped"]


def test_it_tells_its_time_to_who_asks(lead: Lead) -> None:
    (answer,) = lead.tell(mavlink.MAVLink_timesync_message(0, 123, 42, 191))
    assert (answer.tc1, answer.ts1, answer.target_system, answer.target_component) == (10_000_000_000, 123, 1, 1)
    assert (
        lead.tell(mavlink.MAVLink_timesync_message(5, 123, 42, 191), mavlink.MAVLink_timesync_message(0, 123, 9, 1))
        == []
    )


def test_a_line_that_is_too_slow_carries_fewer_positions_but_no_old_ones() -> None:
    """9600 baud take half of what 20 Hz are."""
    stream, framer = MemoryStream("radio"), Framer()
    link = LeadLink(StreamLink("serial:radio:9600", stream, PX4, 960.0), 42, 1, 20.0, True, lambda now_s, text: None)
    ages, count = [], 0
    for n in range(600):
        now_s = 0.05 * n
        link.publish(Broadcast(replace(NAV, t_s=now_s), True, Wish.AUTONOMOUS, 1, None))
        for _, data in stream.to_device.take(now_s):
            for message in framer.feed(data):
                if message.get_type() == "FOLLOW_TARGET":
                    count += 1
                    ages.append(now_s - message.timestamp * 1e-3)
    assert count / 30.0 == pytest.approx(10.0, abs=1.0)
    assert max(ages[20:]) <= 0.16


def test_sticks_are_sent_only_for_remote() -> None:
    memory, framer, sticks = MemoryLink("memory:lead"), Framer(), ManualInput(0.0, "joystick", 0.5, None, -1.0)
    link = LeadLink(memory, 42, 3, 20.0, False, lambda now_s, text: None)
    sent = {}
    for wish in Wish:
        for n in range(40):
            link.publish(Broadcast(replace(NAV, t_s=100.0 * wish + 0.05 * n), True, wish, 1, sticks))
        messages = [m for m in framer.feed(memory.from_vessel()) if m.get_type() == "MANUAL_CONTROL"]
        sent[wish] = len(messages)
    assert sent == {Wish.NONE: 0, Wish.MANUAL: 0, Wish.REMOTE: 20, Wish.AUTONOMOUS: 0}
    link.publish(Broadcast(replace(NAV, t_s=900.0), True, Wish.REMOTE, 1, sticks))
    (message,) = (m for m in framer.feed(memory.from_vessel()) if m.get_type() == "MANUAL_CONTROL")
    assert (message.target, message.x, message.y, message.z, message.r) == (3, 500, 0, 500, -1000)


class Board:
    """A ground station on the lead boat."""

    def __init__(self) -> None:
        self.memory, self.crew, self.said = MemoryLink("memory:local"), CrewWish(), []
        self.station = LeadGroundStation(self.memory, 42, self.crew, lambda now_s, text: self.said.append(text))
        self._sender, self._framer = Sender(255), Framer()

    def ask(self, message: Any) -> list[Any]:
        self.memory.to_vessel(self._sender.packed(message))
        self.station.serve(1.0)
        return self._framer.feed(self.memory.from_vessel())


def test_a_station_can_finish_its_first_look() -> None:
    """What QGroundControl asks of a vehicle of PX4's kind, in its order."""
    board = Board()

    def request(*params: float) -> list[Any]:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        return board.ask(mavlink.MAVLink_command_long_message(42, 1, 512, 0, *padded))

    assert [m.result for m in request(148.0)] == [3]
    names = []
    for index in (1.0, 2.0, 3.0):
        ack, mode = request(435.0, index)
        assert (ack.result, mode.number_modes, mode.mode_index) == (0, 3, index)
        names.append((mode.mode_name, mode.custom_mode))
    assert names == [("Manual", 0x00010000), ("Remote", 0x00060000), ("Follow", 0x08040000)]
    assert [m.result for m in request(435.0, 4.0)] == [2] and len(request(435.0, 0.0)) == 4
    assert [m.result for m in request(397.0)] == [3]
    values = board.ask(mavlink.MAVLink_param_request_list_message(42, 0))
    assert [v.param_index for v in values] == list(range(values[0].param_count))
    (own,) = (v for v in values if v.param_id == "MAV_SYS_ID")
    assert struct.unpack("<i", struct.pack("<f", own.param_value)) == (42,)
    assert (
        board.ask(mavlink.MAVLink_param_request_read_message(42, 1, b"MAV_SYS_ID", -1))[0].param_index
        == own.param_index
    )
    assert board.ask(mavlink.MAVLink_param_set_message(42, 1, b"MAV_SYS_ID", 9.0, 6))[0].param_value == own.param_value
    assert (
        board.ask(mavlink.MAVLink_param_request_read_message(42, 1, b"", own.param_index))[0].param_id == "MAV_SYS_ID"
    )
    assert board.ask(mavlink.MAVLink_param_request_read_message(42, 1, b"", 500)) == []
    for kind in (0, 1, 2):
        (count,) = board.ask(mavlink.MAVLink_mission_request_list_message(42, 1, kind))
        assert (count.count, count.mission_type) == (0, kind)
    assert board.ask(mavlink.MAVLink_mission_count_message(42, 1, 5, 0))[0].type == mavlink.MAV_MISSION_UNSUPPORTED
    assert board.ask(mavlink.MAVLink_mission_request_list_message(1, 1, 0)) == [], "the follower's"


def test_modes_that_the_crew_cannot_ask_for_are_refused() -> None:
    board = Board()
    board.ask(mavlink.MAVLink_set_mode_message(42, 1, 0x04040000))
    assert board.crew.wish is Wish.NONE and "not Manual, Remote or Follow" in board.said[-1]


def test_lent_sticks_are_let_go_after_half_a_second() -> None:
    board = Board()
    board.ask(mavlink.MAVLink_manual_control_message(42, 100, 0x7FFF, 0, -100, 0))
    sticks = board.station.sticks(1.4)
    assert sticks is not None and (sticks.surge, sticks.sway, sticks.yaw) == (0.1, None, -0.1)
    assert board.station.sticks(1.6) is None
    board.ask(mavlink.MAVLink_manual_control_message(1, 900, 0, 0, 0, 0))
    assert board.station.sticks(1.6) is None, "for the follower"
