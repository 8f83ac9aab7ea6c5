"""The lockstep ground station reads whole packets, of both versions, and decodes the newest of a type when asked."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sitl.scenarios.ground_station import GroundStation


class _Rig:
    """Gives the station what is put into `pieces`, one piece a step."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.pieces: list[bytes] = []

    def send(self, data: bytes) -> None:
        pass

    def step(self) -> None:
        self.now_s += 0.1

    def receive(self) -> bytes:
        return self.pieces.pop(0) if self.pieces else b""


def _packet(message: Any, *, first_version: bool = False, key: bytes | None = None) -> bytes:
    codec = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    if key is not None:
        codec.signing.secret_key, codec.signing.sign_outgoing = key, True
    return bytes(message.pack(codec, force_mavlink1=first_version))


def _beat(custom_mode: int) -> Any:
    return mavlink.MAVLink_heartbeat_message(10, 12, 0, custom_mode, 4, 3)


def _station(*pieces: bytes) -> GroundStation:
    rig: Any = _Rig()
    rig.pieces += pieces
    station = GroundStation(rig)
    for _ in pieces:
        station.step()
    return station


def test_the_newest_of_a_type_counts() -> None:
    station = _station(_packet(_beat(7)) + _packet(mavlink.MAVLink_system_time_message(1, 2)) + _packet(_beat(8)))
    assert station.last["HEARTBEAT"].custom_mode == 8 and station.last.get("SYSTEM_TIME").time_boot_ms == 2
    assert station.last.get("ATTITUDE") is None
    with pytest.raises(KeyError):
        station.last["ATTITUDE"]
    station.last.drop("HEARTBEAT")
    assert station.last.get("HEARTBEAT") is None


@pytest.mark.parametrize("form", [{}, {"first_version": True}, {"key": bytes(range(32))}])
def test_packets_in_pieces_and_among_garbage(form: dict[str, Any]) -> None:
    text = mavlink.MAVLink_statustext_message(6, b"all well")
    data = b"noise" + _packet(_beat(7), **form) + b"\x00" + _packet(text, **form) + _packet(_beat(9), **form)
    for cut in range(1, len(data)):
        station = _station(data[:cut], data[cut:])
        assert station.texts == ["all well"] and station.last["HEARTBEAT"].custom_mode == 9


def test_a_station_made_of_it_hears_more() -> None:
    class Listener(GroundStation):
        hears = frozenset({mavlink.MAVLINK_MSG_ID_SYSTEM_TIME})

        def _take(self, message: Any) -> None:
            self.texts.append(message.get_type())

    rig: Any = _Rig()
    rig.pieces.append(_packet(mavlink.MAVLink_system_time_message(1, 2)) + _packet(_beat(7)))
    listener = Listener(rig)
    listener.step()
    assert listener.texts == ["SYSTEM_TIME"]
