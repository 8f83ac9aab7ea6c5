"""GPS_RTCM_DATA as the ground stations cut it, to the receiver's port byte for byte."""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass
from typing import Any

import pytest

from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.assembly import default_services
from companion.io.mavlink.services.corrections import Assembler, RtcmService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Hub, Peer
from tests.unit.io.mavlink.hub.conftest import Rig
from tests.unit.io.test_rtcm import STATION, frame
from tests.wires import Listening

LENGTHS = (25, 179, 180, 181, 359, 360, 361, 540, 719, 720, 721, 800, 1029)


def qgroundcontrol(message: bytes, sequence: int) -> list[tuple[int, bytes]]:
    """As RTCMMavlink.cc: unmasked numbers of fragments, no empty one at the end."""
    if len(message) < 180:
        return [((sequence & 0x1F) << 3, message)]
    return [
        (1 | n << 1 & 0xFF | (sequence & 0x1F) << 3, message[180 * n : 180 * n + 180])
        for n in range((len(message) + 179) // 180)
    ]


def closed(message: bytes, sequence: int) -> list[tuple[int, bytes]]:
    """As MAVProxy's DGPS module: four fragments at most, the last one short, if need be empty."""
    if len(message) > 720:
        return qgroundcontrol(message, sequence)
    pieces = [message[k : k + 180] for k in range(0, len(message), 180)]
    if len(pieces) == 1 and len(message) < 180:
        return [((sequence & 0x1F) << 3, message)]
    if len(message) % 180 == 0 and len(pieces) < 4:
        pieces.append(b"")
    return [(1 | n << 1 | (sequence & 0x1F) << 3, piece) for n, piece in enumerate(pieces)]


def not_counting(message: bytes, sequence: int) -> list[tuple[int, bytes]]:
    return closed(message, 0)


@pytest.mark.parametrize("cut", [qgroundcontrol, closed, not_counting])
def test_every_length_at_every_sequence_number(cut: Any) -> None:
    assembler = Assembler()
    for sequence, size in enumerate(LENGTHS * 8):
        message = frame(size, sequence)
        found = list(
            itertools.chain.from_iterable(assembler.take(flags, data) for flags, data in cut(message, sequence))
        )
        assert found == [message], (size, sequence)


@pytest.mark.parametrize("cut", [qgroundcontrol, closed, not_counting])
@pytest.mark.parametrize("size", [1, 179, 180, 181, 360, 720, 800])
def test_a_stream_cut_without_regard_for_its_messages(cut: Any, size: int) -> None:
    messages = [
        frame(length, k)
        for k, length in enumerate((60, 179, 180, 181, 360, 720, 800, 25, 1029) * (1 if size == 1 else 4))
    ]
    stream, assembler, found = b"".join(messages), Assembler(), []
    for sequence, k in enumerate(range(0, len(stream), size)):
        for flags, data in cut(stream[k : k + size], sequence):
            found += assembler.take(flags, data)
    assert found == messages


def test_fragments_out_of_order_and_doubled() -> None:
    for order in itertools.permutations(range(4)):
        assembler = Assembler()
        pieces = qgroundcontrol(frame(700), 3)
        found = [one for n in order for one in assembler.take(*pieces[n]) + assembler.take(*pieces[n])]
        assert found == [frame(700)], order


def test_a_lost_fragment_costs_its_own_message_only() -> None:
    generator = random.Random(1)
    for lost in range(4):
        assembler, found = Assembler(), []
        for sequence in range(20):
            message = frame(700, sequence) if sequence % 3 else frame(100, sequence)
            pieces = qgroundcontrol(message, sequence)
            if sequence == 7:
                del pieces[lost]
            for piece in pieces:
                found += assembler.take(*piece)
        assert found == [frame(700 if s % 3 else 100, s) for s in range(20) if s != 7]
    assert generator.random() < 1.0


def test_flags_and_bytes_at_random_harm_nothing() -> None:
    generator, assembler = random.Random(2), Assembler()
    for _ in range(5000):
        found = assembler.take(generator.randrange(256), generator.randbytes(generator.randrange(181)))
        assert all(one[0] == 0xD3 for one in found)
    assembler.take(0, STATION)
    assert assembler.take(0, STATION) == [STATION]


def relaying() -> tuple[Rig, Listening]:
    """A hub with a relay to a receiver, and the receiver's port."""
    port = Listening()

    def services(hub: Hub) -> list[Any]:
        relay = CorrectionsRelay({"gnss": port}, (), hub.vessel.events.say)
        return [*default_services(hub), RtcmService(relay)]

    return Rig(["memory:"], services=services), port


@dataclass(frozen=True)
class Port:
    """As much of an endpoint as the service needs."""

    name: str


def test_frames_of_a_leader_module_go_to_the_receiver_for_a_moving_base_alone() -> None:
    """Corrections of two bases must not be mixed, whichever comes first."""
    fixed, moving = Listening(), Listening()
    relay = CorrectionsRelay({"gnss": fixed}, (), lambda *said: None, [moving])
    service = RtcmService(relay, lambda: 42)
    handle = service.handles[mavlink.MAVLINK_MSG_ID_GPS_RTCM_DATA]
    endpoint: Any = Port("udp")
    for system, component, size in ((42, 191, 300), (1, 190, 400), (42, 1, 100), (41, 191, 500)):
        for flags, data in qgroundcontrol(frame(size), 1):
            message = mavlink.MAVLink_gps_rtcm_data_message(flags, len(data), list(data.ljust(180, b"\x00")))
            handle(message, Peer(endpoint, system, component), 1.0)
    assert b"".join(sent for _, sent in moving.sent) == frame(300)
    assert b"".join(sent for _, sent in fixed.sent) == frame(400)


def test_through_the_hub() -> None:
    rig, port = relaying()
    rig.run(0.5)
    for sequence, size in enumerate(LENGTHS):
        for flags, data in qgroundcontrol(frame(size, sequence), sequence):
            rig.ask(mavlink.MAVLink_gps_rtcm_data_message(flags, len(data), list(data.ljust(180, b"\x00"))))
    assert b"".join(sent for _, sent in port.sent) == b"".join(
        frame(size, sequence) for sequence, size in enumerate(LENGTHS)
    )


def test_the_older_message() -> None:
    rig, port = relaying()
    rig.run(0.5)
    message = frame(300) + STATION
    for k in range(0, len(message), 110):
        piece = message[k : k + 110]
        rig.ask(mavlink.MAVLink_gps_inject_data_message(1, 1, len(piece), list(piece.ljust(110, b"\x00"))))
    assert b"".join(sent for _, sent in port.sent) == message


def test_a_length_that_lies() -> None:
    rig, port = relaying()
    rig.run(0.5)
    rig.ask(mavlink.MAVLink_gps_rtcm_data_message(0, 255, list(STATION.ljust(180, b"\x00"))))
    assert b"".join(sent for _, sent in port.sent) == STATION
