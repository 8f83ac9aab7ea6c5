"""What others send to others, between the links of a hub."""

from __future__ import annotations

import itertools
import random
from typing import Any

import pytest

from companion.core.decision import TextKind
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.router import FORGET_S
from companion.io.mavlink.wire.signing import Signing, SigningState
from tests.remembered import remembered
from tests.unit.io.mavlink.hub.conftest import Rig

GIMBAL = 154
NOW_NS = 1_780_000_000_000_000_000


def packet(message: Any, system: int, component: int, sequence: int = 0) -> bytes:
    return frame(pack(message), sequence, system, component)


def heartbeat(kind: int = 6) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 4, 3)


def command(system: int, component: int) -> Any:
    return mavlink.MAVLink_command_long_message(system, component, 205, 0, 0, 0, 0, 0, 0, 0, 0)


class Wires:
    """Links 0, 1, 2 … of a hub; what is put on one, and what comes out of the others that is not the vessel's own."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig

    def put(self, link: int, *packets: bytes) -> list[list[bytes]]:
        for desk in self.rig.desks:
            desk.hear()
        for data in packets:
            self.rig.desks[link].link.to_vessel(data)
        self.rig.serve()
        return [
            [bytes(m.get_msgbuf()) for m in desk.hear() if (m.get_srcSystem(), m.get_srcComponent()) != (1, 1)]
            for desk in self.rig.desks
        ]


@pytest.fixture
def wires(make_rig: type[Rig]) -> Wires:
    return Wires(make_rig(["memory:a", "memory:b", "memory:c"]))


def test_a_broadcast_goes_to_all_others_untouched_and_never_back(wires: Wires) -> None:
    data = packet(heartbeat(), 255, 190, 7)
    assert wires.put(0, data) == [[], [data], [data]]
    unknown = bytearray(packet(heartbeat(), 255, 190, 8))
    unknown[7:10] = (60_000).to_bytes(3, "little")
    assert wires.put(1, bytes(unknown)) == [[], [], [bytes(unknown)]], "not where its sender was heard"
    old = bytes.fromhex("fe0900ffbe000000000006080000042e") + b"\x00"
    assert all(not out for out in wires.put(2, old[:-3])), "no whole frame"


def test_an_addressed_packet_goes_where_its_target_was_heard(wires: Wires) -> None:
    assert wires.put(0, packet(command(1, GIMBAL), 255, 190)) == [[], [], []], "nobody knows where"
    wires.put(2, packet(heartbeat(26), 1, GIMBAL))
    data = packet(command(1, GIMBAL), 255, 190, 1)
    assert wires.put(0, data) == [[], [], [data]]
    ack = packet(mavlink.MAVLink_command_ack_message(205, 0, 0, 0, 255, 190), 1, GIMBAL, 2)
    assert wires.put(2, ack) == [[ack], [], []]
    data = packet(command(1, 0), 255, 190, 3)
    assert wires.put(0, data) == [[], [], [data]], "all components of our system, of which we are one"
    assert wires.put(0, packet(command(1, 1), 255, 190, 4)) == [[], [], []], "ours alone"
    sticks = packet(mavlink.MAVLink_manual_control_message(42, 0, 0, 0, 0, 0), 255, 190, 5)
    assert wires.put(0, sticks) == [[], [], []]
    wires.put(1, packet(heartbeat(11), 42, 1))
    assert wires.put(0, sticks) == [[], [sticks], []]


def test_who_is_silent_is_forgotten(wires: Wires) -> None:
    wires.put(2, packet(heartbeat(26), 1, GIMBAL))
    wires.rig.now_s += FORGET_S + 1.0
    assert wires.put(0, packet(command(1, GIMBAL), 255, 190)) == [[], [], []]


def test_two_ways_to_one_station_make_no_echo_and_no_circle(wires: Wires) -> None:
    """Each packet of it comes in twice; and a router between links 1 and 2 sends round whatever it is sent."""
    first = packet(heartbeat(), 255, 190, 0)
    assert wires.put(0, first) == [[], [first], [first]]
    assert wires.put(1, first) == [[], [], []]
    count, rounds = 0, [packet(heartbeat(), 255, 190, 1)]
    for _ in range(20):
        out = wires.put(1, *rounds)
        rounds = out[2]
        count += len(rounds)
        out = wires.put(2, *rounds)
        rounds = out[1]
        count += len(rounds)
    assert count <= 2


def test_our_own_packets_that_come_round_go_no_further(wires: Wires) -> None:
    assert wires.put(0, packet(heartbeat(11), 1, 1)) == [[], [], []]


def test_another_vehicle_with_our_system_id_is_told_of(wires: Wires) -> None:
    """Its packets go no further either; ours that come round are no other vehicle."""
    rig = wires.rig
    for ahead_ms, texts in ((0, []), (90_000, ["Another vehicle has system id 1: set MAV_SYS_ID"])):
        for n in range(40):
            rig.now_s = round(rig.now_s + 0.2, 9)
            boot_ms = int(rig.now_s * 1000.0) + ahead_ms
            place = mavlink.MAVLink_global_position_int_message(boot_ms, 634_389_000, 103_990_000, 0, 0, 0, 0, 0, 0)
            assert wires.put(0, packet(place, 1, 1, n)) == [[], [], []]
        assert [event.text for event in rig.vessel.events.drain()] == texts


def test_a_client_with_our_address_is_told_of_once_and_not_obeyed(wires: Wires) -> None:
    """Of what comes back of our own (here: requests and answers to somebody aboard) nothing is said."""
    rig = wires.rig
    for own in (
        mavlink.MAVLink_command_long_message(1, 100, 512, 0, 259.0, 0, 0, 0, 0, 0, 0),
        mavlink.MAVLink_command_ack_message(400, 0, target_system=1, target_component=0),
        mavlink.MAVLink_mission_count_message(1, 0, 3, 0),
        mavlink.MAVLink_mission_request_int_message(1, 0, 0, 0),
        mavlink.MAVLink_param_value_message(b"WP_SPEED", 0.5, 9, 400, 7),
    ):
        wires.put(0, packet(own, 1, 1))
    assert [event.text for event in rig.vessel.events.drain()] == []
    for n in range(5):
        rig.now_s += 1.0
        arm = mavlink.MAVLink_command_long_message(1, 0, 400, n, 1.0, 0, 0, 0, 0, 0, 0)
        listing = mavlink.MAVLink_param_request_list_message(1, 1)
        wires.put(0, packet(arm, 1, 1, n), packet(listing, 1, 1, n))
    assert [event.text for event in rig.vessel.events.drain()] == ["Client with our ids 1/1 ignored: give it others"]
    assert rig.supervisor.asked == []


def test_keys_and_the_modems_own_word_stay_where_they_came_in(wires: Wires) -> None:
    wires.put(1, packet(heartbeat(11), 42, 1))
    key = mavlink.MAVLink_setup_signing_message(42, 1, list(range(32)), 5)
    everybody = mavlink.MAVLink_setup_signing_message(0, 0, list(range(32)), 5)
    radio = mavlink.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7)
    assert wires.put(0, packet(key, 255, 190), packet(everybody, 255, 190, 1), packet(radio, 51, 68)) == [[], [], []]


def test_signed_packets_pass_with_their_signatures_and_refused_ones_do_not(make_rig: type[Rig]) -> None:
    wires = Wires(make_rig(["memory:?signing=require", "memory:"]))
    key = bytes(range(32))
    ours, theirs = (Signing(lambda: NOW_NS, SigningState(key, 0), lambda state: None) for _ in range(2))
    wires.rig.desks[0].link.guard.signing = ours
    packed = pack(heartbeat())
    signed = theirs.sign(frame(packed, 3, 255, 190), packed.crc_extra, 9)
    assert wires.put(0, frame(packed, 2, 255, 190), signed) == [[], [signed]]
    stranger = Signing(lambda: NOW_NS, SigningState(bytes(range(1, 33)), 0), lambda state: None)
    other = stranger.sign(frame(packed, 4, 100, 190), packed.crc_extra, 9)
    assert wires.put(1, other)[0] == [other], "whose key that is, the receiver knows"


@pytest.mark.parametrize(
    ("options", "out", "back"),
    [
        ("", 1, 1),
        ("?route=from", 1, 0),
        ("?route=no", 0, 0),
        ("?telemetry=leader", 1, 0),
        ("?telemetry=high_latency", 0, 0),
    ],
)
def test_a_link_chooses_what_passes(make_rig: type[Rig], options: str, out: int, back: int) -> None:
    wires = Wires(make_rig([f"memory:{options}", "memory:"]))
    assert len(wires.put(0, packet(heartbeat(18), 42, 191))[1]) == out
    assert len(wires.put(1, packet(heartbeat(), 255, 190))[0]) == back


def on_the_radio(rig: Rig, flood: int) -> tuple[float, float, int, list[float]]:
    """20 s of a 57,600 baud link beside one on which others say `flood` things a tick: (ours, theirs in bytes a second,
    addressed ones, heartbeats)."""
    radio, other, draws = rig.desks[0], rig.desks[1], random.Random(3)
    radio.send(heartbeat())
    ours, theirs, addressed, heartbeats = 0, 0, 0, []
    for n in range(200):
        for k in range(flood):
            other.link.to_vessel(
                packet(mavlink.MAVLink_attitude_message(draws.randrange(2**31), 0, 0, 0, 0, 0, 0), 42, 1, k)
            )
        if flood and n % 10 == 0:
            other.link.to_vessel(packet(mavlink.MAVLink_command_ack_message(n, 0, 0, 0, 255, 190), 42, 1, 200))
        rig.tick()
        other.hear()
        for message in radio.hear():
            size, own = len(message.get_msgbuf()), message.get_srcSystem() == 1
            ours, theirs = (ours + size, theirs) if own else (ours, theirs + size)
            addressed += message.get_type() == "COMMAND_ACK"
            if own and message.get_type() == "HEARTBEAT":
                heartbeats.append(rig.now_s)
    return ours / 20.0, theirs / 20.0, addressed, heartbeats


def test_a_flood_from_others_leaves_a_slow_line_to_us(make_rig: type[Rig]) -> None:
    """A quarter of it at most is others'; we say as much as without them, and what is addressed gets through beside
    their streams."""
    alone, _, _, _ = on_the_radio(make_rig(["memory:?rate=5760", "memory:"]), 0)
    rig = make_rig(["memory:?rate=5760", "memory:"])
    ours, theirs, addressed, heartbeats = on_the_radio(rig, 100)
    print(f"ours {ours:.0f} bytes/s, alone {alone:.0f}, others {theirs:.0f}")
    assert ours > 0.98 * alone and theirs < 0.27 * 5760 and addressed == 20
    assert max(b - a for a, b in itertools.pairwise(heartbeats)) < 1.15
    assert rig.desks[0].endpoint.traffic.held_back > 15_000


def test_only_heard_addresses_are_kept_and_few(wires: Wires) -> None:
    kept = []
    for n in range(3000):
        wires.put(0, packet(heartbeat(), 2 + n % 250, n // 250, n & 0xFF))
        if n % 1000 == 999:
            kept.append(remembered(wires.rig.hub, "companion.io.mavlink.wire"))
    assert len(kept) == 3 and kept[2] <= kept[1], kept


# --- high latency --------------------------------------------------------------------------------------------------


def test_a_costly_link_carries_one_message_every_five_seconds_and_no_heartbeat(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:?telemetry=high_latency", "memory:"])
    costly = rig.desks[0]
    rig.run(20.0)
    rig.supervisor.change(armed=True)
    rig.vessel.events.say(rig.now_s, TextKind.ATTENTION, "test", "something for everybody")
    rig.run(0.5)
    heard = [m.get_type() for m in costly.hear()]
    assert set(heard) == {"HIGH_LATENCY2"} and 4 <= len(heard) <= 5
    assert "HIGH_LATENCY2" not in {m.get_type() for m in rig.desks[1].hear()}
    rig.ask(heartbeat(), desk=0)
    assert costly.hear() == [], "no greeting either"


def test_it_is_switched_off_and_on_from_any_link(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:?telemetry=high_latency", "memory:"])
    assert [m.result for m in rig.command(2600, 0.0, desk=1) if m.get_type() == "COMMAND_ACK"] == [0]
    rig.run(15.0)
    assert rig.desk.hear() == []
    rig.command(2600, 1.0, desk=1)
    rig.run(6.0)
    assert {m.get_type() for m in rig.desk.hear()} == {"HIGH_LATENCY2"}
    assert [m.result for m in rig.command(2600, 7.0, desk=1) if m.get_type() == "COMMAND_ACK"] == [2]


@pytest.mark.parametrize(("persona", "mode"), [("px4", 0x0304), ("ardupilot", 4)])
def test_what_it_says(make_rig: type[Rig], persona: str, mode: int) -> None:
    """Hold, armed, at 63.44 N 10.4 E, heading 57°, 0.5 m/s over ground."""
    rig = make_rig([f"memory:?telemetry=high_latency&dialect={persona}"])
    rig.supervisor.change(armed=True)
    rig.run(6.0)
    message = [m for m in rig.desk.hear() if m.get_type() == "HIGH_LATENCY2"][-1]
    assert (message.latitude, message.longitude) == (634_400_000, 104_000_000)
    assert message.heading == 57 // 2 and message.groundspeed == round(0.5 * 5) and message.type == 11
    assert message.custom_mode == mode and message.custom0 & 0x80 and message.failure_flags == 0
    assert len(Framer().feed(message.get_msgbuf())) == 1
