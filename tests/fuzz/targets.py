"""What a fuzzer drives: one function for each reader of bytes from outside, from any bytes to a verdict.

A target raises for a breach only: an exception that the reader must not raise, or a promise that it does not keep. The
first byte often says whether what follows is raw, or the content of a frame whose checksum is made here: a fuzzer does
not guess checksums.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from fastcrc import crc8

from companion.config.devices import SensorConfig
from companion.config.vessel import ConfigError, parse
from companion.core.readings import FixType, GnssFix
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.transfer.file_tree import FileTree
from companion.io.mavlink.transfer.ftp_service import FtpService
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, Packed, frame, pack
from companion.io.sensors import open_sensor
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.mission.plan_file import PlanFileError
from companion.mission.validation import check_plan
from tests.remembered import remembered
from tests.unit.io.mavlink.conftest import Desk
from tests.wires import Wire

GOOD = frame(pack(mavlink.MAVLink_ping_message(424242, 7, 0, 0)), 1, 255, 190)
_IDS = sorted(mavlink.MESSAGES)
_SUFFIXES = tuple(files.FORMATS)
_MOST_BYTES = 10_000  # that a driver keeps of an unfinished message
_FTP_BYTES = 251


class Breach(AssertionError):
    """A promise that a reader did not keep."""


def require(holds: bool, text: str) -> None:
    """Raises Breach with `text` where something does not hold."""
    if not holds:
        raise Breach(text)


def _pieces(data: bytes) -> Iterator[bytes]:
    """`data` in pieces whose lengths it says itself: one byte of length before each."""
    at = 0
    while at < len(data):
        size = data[at] & 0x3F
        yield data[at + 1 : at + 1 + size]
        at += 1 + size


def _keeps_little(data: bytes, reader: object, most: int) -> None:
    """Of one input in 64, because counting takes longer than reading."""
    require(zlib.crc32(data) % 64 != 0 or remembered(reader) < most, "it keeps too much")


# --- MAVLink -------------------------------------------------------------------------------------------------------


def framer(data: bytes) -> None:
    """Bytes in any pieces give the same frames, and the next good frame is heard."""
    if data[:1] and data[0] & 1:
        stream = b"".join(_framed(piece) for piece in _pieces(data[1:]))
        pieces = [stream[at : at + 31] for at in range(0, len(stream), 31)]
    else:
        pieces = list(_pieces(data[1:]))
        stream = b"".join(pieces)
    whole, cut = Framer(), Framer()
    once = [bytes(message.get_msgbuf()) for message in whole.feed(stream) + whole.flush()]
    parts = [bytes(message.get_msgbuf()) for piece in pieces for message in cut.feed(piece)]
    parts += [bytes(message.get_msgbuf()) for message in cut.flush()]
    require(once == parts, "frames depend on how the bytes come")
    require(sum(map(len, once)) <= len(stream), "more bytes came out than went in")
    require([m.get_type() for m in whole.feed(GOOD)] == ["PING"], "a good frame after it is not heard")


def _framed(piece: bytes) -> bytes:
    """A frame of a known id with this payload, or the raw bytes."""
    if len(piece) < 3 or piece[0] & 0x80:
        return piece[1:]
    number = _IDS[(piece[0] << 8 | piece[1]) % len(_IDS)]
    extra = bytes([mavlink.MESSAGES[number].crc_extra])
    return frame(Packed(number, extra, piece[2:].rstrip(b"\0") or b"\0"), piece[1], 255, 190)


@cache
def _desk() -> Desk:
    return Desk()


def mission_transfer(data: bytes) -> None:
    """Whatever clients send, only whole and valid plans are in force, and the service keeps little."""
    desk = _desk()
    for kind in PlanKind:
        desk.plans.replace(kind, ())
    desk.hub.sent.clear()
    service: Any = desk.serve(MissionService(desk.hub, desk.vessel))
    for piece in _pieces(data):
        if piece:
            _mission_step(desk, service, piece)
    desk.events.drain()
    for kind in PlanKind:
        items = desk.plans.items(kind)
        require(not items or check_plan(kind, items, 0, 0) is None, "an invalid plan is in force")
        require([item.seq for item in items] == list(range(len(items))), "items have other numbers than their places")
    require(len(desk.hub.sent) <= 4 * len(data) + 64, "more answers than questions")


_PEERS = ("qgc", "other", "rover")
_MISSION_IDS = (44, 38, 73, 39, 47, 43, 37, 51, 40, 45, 41, 73, 73)


def _mission_step(desk: Desk, service: Any, piece: bytes) -> None:
    if piece[0] >= 0xF0:
        desk.wait(0.1 * (piece[0] & 0x0F))
        return
    number = _MISSION_IDS[piece[0] % len(_MISSION_IDS)]
    payload = piece[1:].ljust(mavlink.MESSAGES[number].unpacker.size, b"\0")
    extra = bytes([mavlink.MESSAGES[number].crc_extra])
    found = Framer().feed(frame(Packed(number, extra, payload[:255].rstrip(b"\0") or b"\0"), 0, 255, 190))
    require(len(found) == 1, "a whole frame is not read")
    service.handles[number](found[0], desk.peer(_PEERS[piece[0] % 3]), desk.now_s)


@cache
def _tree() -> FileTree:
    desk = _desk()
    return FileTree(desk.vessel, 1, 1, Descriptions(desk.parameters, ArmingEvents((), ())), None)


def ftp(data: bytes) -> None:
    """Whatever clients ask, each request has at most one answer and a burst, and nothing stays open."""
    desk = _desk()
    desk.hub.sent.clear()
    service: Any = desk.serve(FtpService(desk.hub, _tree()))
    for piece in _pieces(data):
        if not piece:
            continue
        if piece[0] >= 0xF0:
            desk.now_s += piece[0] & 0x0F
            service.update(desk.now_s)
            continue
        content = piece[1:].ljust(_FTP_BYTES, b"\0")[:_FTP_BYTES]
        message = mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(content))
        (read,) = Framer().feed(frame(pack(message), 0, 255, 190))
        service.handles[110](read, desk.peer(_PEERS[piece[0] % 3]), desk.now_s)
    _keeps_little(data, service, 400_000)
    service.close()
    for _, answer in desk.hub.sent:
        require(answer.get_type() == "FILE_TRANSFER_PROTOCOL", "another answer than FTP's")


# --- sensors -------------------------------------------------------------------------------------------------------


def _sensor(driver: str, pieces: list[bytes]) -> None:
    wire = Wire()
    sensor = open_sensor(SensorConfig("sensor", driver, "serial:/dev/x:9600"), wire)
    for number, piece in enumerate(pieces):
        wire.chunks = [(0.01 * number, piece)]
        for reading in sensor.read(0.01 * number):
            _sane(reading)
    _keeps_little(b"".join(pieces), sensor, _MOST_BYTES)
    sensor.health(60.0)


def _sane(reading: Any) -> None:
    """Every number of a reading is finite, and a place is on Earth. A receiver without a fix has no place."""
    require(is_dataclass(reading), "a reading is a dataclass")
    if isinstance(reading, GnssFix) and reading.fix is FixType.NONE:
        return
    for field in fields(reading):
        value = getattr(reading, field.name)
        if isinstance(value, float):
            require(math.isfinite(value), f"{type(reading).__name__}.{field.name} is {value}")
    lat_deg, lon_deg = getattr(reading, "lat_deg", None), getattr(reading, "lon_deg", None)
    require(lat_deg is None or -90.0 <= lat_deg <= 90.0, f"latitude {lat_deg}")
    require(lon_deg is None or -180.0 <= lon_deg <= 180.0, f"longitude {lon_deg}")


def nmea(data: bytes) -> None:
    """Sentences: raw, or with the checksum made here."""
    if data[:1] and data[0] & 1:
        lines = data[1:].split(b"\n")
        _sensor("nmea0183", [b"$%b*%02X\r\n" % (line, _xor(line)) for line in lines])
    else:
        _sensor("nmea0183", list(_pieces(data[1:])))


def _xor(line: bytes) -> int:
    total = 0
    for byte in line:
        total ^= byte
    return total


def mtdata2(data: bytes) -> None:
    """Messages: raw, or with length and checksum made here."""
    if data[:1] and data[0] & 1:
        messages = []
        for piece in _pieces(data[1:]):
            body = b"\xff\x36" + bytes([len(piece)]) + piece
            messages.append(b"\xfa" + body + bytes([-sum(body) & 0xFF]))
        _sensor("mtdata2", messages)
    else:
        _sensor("mtdata2", list(_pieces(data[1:])))


def sbus(data: bytes) -> None:
    """Frames: raw, or with header and end made here. Channels stay within what a transmitter can send."""
    pieces = list(_pieces(data[1:]))
    if data[:1] and data[0] & 1:
        pieces = [b"\x0f" + piece[:23].ljust(23, b"\0") + b"\0" for piece in pieces]
    _sensor("sbus", pieces)


def crsf(data: bytes) -> None:
    """Frames: raw, or with address, length and checksum made here."""
    pieces = list(_pieces(data[1:]))
    if data[:1] and data[0] & 1:
        pieces = [bytes((0xC8, len(piece) + 1)) + piece + bytes((crc8.dvb_s2(piece),)) for piece in pieces]
    _sensor("crsf", pieces)


# --- files ---------------------------------------------------------------------------------------------------------


def plan_file(data: bytes) -> None:
    """A plan that is read can be written, and what is written can be read. Anything else is a PlanFileError."""
    if not data:
        return
    name = f"plan{_SUFFIXES[data[0] % len(_SUFFIXES)]}"
    try:
        plan = files.read(name, data[1:].decode("utf-8", "replace"))
    except PlanFileError as error:
        require(bool(error.problems), "a refusal without a reason")
        return
    try:
        text = files.write(name, plan)
    except PlanFileError:
        return
    files.read(name, text)


def vessel_file(data: bytes) -> None:
    """A vessel's file is taken, or refused with reasons that are one line each."""
    try:
        parse(data.decode("utf-8", "replace"), "boat.toml")
    except ConfigError as error:
        require(bool(error.problems), "a refusal without a reason")
        require(all("\n" not in problem for problem in error.problems), "a problem of several lines")


TARGETS: Mapping[str, Callable[[bytes], None]] = {
    "framer": framer,
    "mission_transfer": mission_transfer,
    "ftp": ftp,
    "nmea": nmea,
    "mtdata2": mtdata2,
    "sbus": sbus,
    "crsf": crsf,
    "plan_file": plan_file,
    "vessel_file": vessel_file,
}
