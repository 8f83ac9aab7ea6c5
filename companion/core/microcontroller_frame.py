"""The frame between the companion and a microcontroller that drives thrusters: a pure codec, used by the driver of the
bridge and by the emulated board.

On the wire, over any byte stream (115200 baud 8N1 is usual), both directions:

    00 | COBS(message) | 00

COBS (Cheshire and Baker, 1999) takes all zero bytes out of the message: the message is cut at its zeros, and before
each piece goes one byte, the piece's length + 1. Messages are at most 253 bytes, so the length byte 0xFF never occurs.
A receiver collects bytes up to a 00 and ignores what does not decode; two 00 in a row are an empty frame, which has no
meaning. With a 00 at both ends, garbage between two frames spoils neither.

A message is, all numbers little endian, bit 0 the least significant:

    0      version   u8    1. Messages of another version are ignored
    1      type      u8    see below
    2 …              …     body of the type
    last 2 crc       u16   CRC-16/CCITT-FALSE of all bytes before it: polynomial 0x1021, start 0xFFFF, no reflection,
                           no final inversion ("123456789" gives 0x29B1)

Type 1, COMMAND, host → board, once a control step:

    2      sequence  u8    counts up by one, wraps
    3      flags     u8    bit 0: armed. Bit 1: lower the retractable thrusters, bit 2: retract them; neither: leave
                           them where they are; never both. Others 0
    4      lights    u8    bits 0–1 red, 2–3 yellow, 4–5 green: 0 off, 1 steady, 2 blink. Others 0
    5      n         u8    thrusters, 0…16
    6+4i   throttle  i16   of thruster i, −10000…10000 ↔ −1…1
    8+4i   azimuth   i16   −31416…31416, 1e-4 rad: the direction in which the thruster pushes the boat, clockwise from
                           the bow (senders write astern as 31416, receivers accept both ends); −32768: it does not turn

    A board drives its thrusters neutral unless the last valid COMMAND was armed and is less than 0.5 s old, whatever
    else it holds. An azimuth drive without stops takes the shorter way round; one with stops takes the nearest turn
    within its stops. Retractable thrusters move whether armed or not, complete a travel once begun, and run only when
    lowered. Without commands for 0.5 s, also after power-up, the green light is steady; the other lights stay as they
    were. A COMMAND for another number of thrusters than the board has is not valid.

Type 2, STATUS, board → host, 20 times a second:

    2      sequence  u8    of the last valid COMMAND
    3      flags     u8    bit 0: neutral because commands stopped. bit 1: leak sensor wet. bit 2: RC receiver present.
                           bit 3: RC receiver has no signal. bit 4: the transmitter's safe switch is on: the thrusters
                           follow its sticks or stand still, whatever the COMMAND. bit 5: takes RADIO. Others 0
    4      battery   u16   mV; 65535: not measured
    6      current   i32   mA out of the battery; −2147483648: not measured
    10     remaining u8    0…254 ↔ 0…1 of the battery's charge; 255: unknown
    11     RC        8×u16 pulse widths in µs, channel 1 first; 0: no such channel
    27     n         u8    thrusters, 0…16
    28+5i  throttle  i16   measured throttle of thruster i, scaled as in COMMAND
    30+5i  azimuth   i16   measured azimuth, scaled as in COMMAND
    32+5i  state     u8    bit 0: the thruster works. bits 1–2: 0 it does not retract or its position is unknown,
                           1 retracted, 2 moving, 3 lowered. Others 0

Type 3, IDENT_REQUEST, host → board: no body. The board answers with IDENT.

Type 4, IDENT, board → host, at power-up and on request:

    2      firmware  3×u8  major, minor, patch
    5      n         u8    thrusters that the board drives
    6      length    u8    of the name, 0…32
    7      name      ASCII

Types 5 and 6, outputs beside the thrusters: `companion.core.microcontroller_auxiliary`.

Type 7, RADIO, host → board, while STATUS says that the board takes it: 1…64 bytes for the RC receiver on the board, as
they are. A board that has not sent the last yet sends the newest only.

Version 1 of the frame gained it, and the bit of STATUS, after types 1 to 6.
"""

from __future__ import annotations

import math
import struct
from binascii import crc_hqx
from dataclasses import dataclass

from companion.core.actuation import Deployment, Light
from companion.core.angles import wrap_pi
from companion.core.microcontroller_auxiliary import (
    AUXILIARY,
    AUXILIARY_STATUS,
    AuxiliaryDemand,
    AuxiliaryState,
    decode_outputs,
    encode_outputs,
)

VERSION = 1
MAX_THRUSTERS = 16
RC_CHANNELS = 8
MAX_RADIO_BYTES = 64
WATCHDOG_S = 0.5  # a board without a valid command for this long goes neutral

_COMMAND, _STATUS, _IDENT_REQUEST, _IDENT, _RADIO = 1, 2, 3, 4, 7
_MAX_NAME = 32
_MAX_MESSAGE = 253  # shorter than the 254 from which COBS would need its long blocks
_MAX_ENCODED = _MAX_MESSAGE + 1
_CRC_START = 0xFFFF
_THROTTLE_SCALE = 10000
_AZIMUTH_SCALE = 1e4
_NO_AZIMUTH = -32768
_MAX_AZIMUTH = 31416
_NO_VOLTAGE = 0xFFFF
_NO_CURRENT = -(2**31)
_NO_REMAINING = 255

_COMMAND_HEAD = struct.Struct("<BBBBBB")
_COMMAND_THRUSTER = struct.Struct("<hh")
_STATUS_HEAD = struct.Struct("<BBBBHiB8HB")
_STATUS_THRUSTER = struct.Struct("<hhB")
_IDENT_HEAD = struct.Struct("<BBBBBBB")
_CRC = struct.Struct("<H")
_LIGHTS = tuple(Light)
_BYTES = tuple([bytes((number,)) for number in range(256)])


@dataclass(frozen=True, slots=True)
class ThrusterDemand:
    """Throttle −1…1; azimuth None where the thruster does not turn."""

    throttle: float
    azimuth_rad: float | None = None


@dataclass(frozen=True, slots=True)
class ThrusterState:
    """Measured state of a thruster. `deployment` None: it does not retract, or the board does not report it."""

    throttle: float
    azimuth_rad: float | None = None
    ok: bool = True
    deployment: Deployment | None = None


@dataclass(frozen=True, slots=True)
class BoardCommand:
    """COMMAND: what the board must do. `lower`: True lowers the retractable thrusters, False retracts them, None leaves
    them."""

    sequence: int
    armed: bool
    thrusters: tuple[ThrusterDemand, ...]
    lower: bool | None = None
    red: Light = Light.OFF
    yellow: Light = Light.OFF
    green: Light = Light.OFF


@dataclass(frozen=True, slots=True)
class BoardStatus:
    """STATUS: state of the board. `remaining` 0…1. `rc_us`: eight pulse widths, 0 for a missing channel. `safe_mode`:
    the transmitter's safe switch is on, and the board ignores COMMAND. `takes_radio`: it passes RADIO on."""

    sequence: int
    neutral_by_watchdog: bool
    leak_wet: bool
    rc_present: bool
    rc_lost: bool
    voltage_v: float | None
    current_a: float | None
    remaining: float | None
    rc_us: tuple[int, ...]
    thrusters: tuple[ThrusterState, ...]
    safe_mode: bool = False
    takes_radio: bool = False


@dataclass(frozen=True, slots=True)
class IdentRequest:
    """IDENT_REQUEST: asks the board to identify itself."""


@dataclass(frozen=True, slots=True)
class Ident:
    """IDENT: firmware version (major, minor, patch), number of thrusters, name."""

    firmware: tuple[int, int, int]
    thrusters: int
    name: str


@dataclass(frozen=True, slots=True)
class Radio:
    """RADIO: 1 to 64 bytes for the RC receiver on the board."""

    data: bytes


Message = BoardCommand | BoardStatus | IdentRequest | Ident | AuxiliaryDemand | AuxiliaryState | Radio


def encode(message: Message) -> bytes:
    """The bytes of one frame that holds `message`, both delimiters included.

    Values out of range are limited; a throttle that is NaN becomes 0, an azimuth that is not finite "does not turn".
    Raises ValueError for more than 16 thrusters, servos or relays, and for RADIO of no byte or more than 64.
    """
    if isinstance(message, BoardCommand):
        body = _encode_command(message)
    elif isinstance(message, BoardStatus):
        body = _encode_status(message)
    elif isinstance(message, Ident):
        name = message.name.encode("ascii", "replace")[:_MAX_NAME]
        body = _IDENT_HEAD.pack(VERSION, _IDENT, *message.firmware, message.thrusters, len(name)) + name
    elif isinstance(message, AuxiliaryDemand | AuxiliaryState):
        kind = AUXILIARY if isinstance(message, AuxiliaryDemand) else AUXILIARY_STATUS
        body = bytes((VERSION, kind)) + encode_outputs(message)
    elif isinstance(message, Radio):
        body = bytes((VERSION, _RADIO)) + _fitting(message.data)
    else:
        body = bytes((VERSION, _IDENT_REQUEST))
    return frame(body + _CRC.pack(crc_hqx(body, _CRC_START)))


def frame(message: bytes) -> bytes:
    """Up to 253 bytes COBS-encoded, between delimiters."""
    return b"\0" + b"".join([_BYTES[len(piece) + 1] + piece for piece in message.split(b"\0")]) + b"\0"


def unframe(encoded: bytes) -> bytes | None:
    """The message whose COBS encoding stood between two delimiters; None for an invalid encoding."""
    pieces: list[bytes] = []
    at, end = 0, len(encoded)
    while at < end:
        following = at + encoded[at]
        if following > end or following == at:
            return None
        pieces.append(encoded[at + 1 : following])
        at = following
    return b"\0".join(pieces)


class FrameDecoder:
    """Received bytes → messages. Remembers the incomplete frame (of bounded length); counts `frames` and `errors`."""

    def __init__(self) -> None:
        self.frames = 0
        self.errors = 0
        self._buffer = bytearray()
        self._overrun = False

    def feed(self, data: bytes) -> list[Message]:
        """The messages that `data` completes, in order. Garbage spoils at most the frame that it hits."""
        messages: list[Message] = []
        *complete, rest = data.split(b"\0")
        for part in complete:
            self._collect(part)
            if self._buffer or self._overrun:
                message = None if self._overrun else decode(bytes(self._buffer))
                if message is None:
                    self.errors += 1
                else:
                    self.frames += 1
                    messages.append(message)
            self._buffer.clear()
            self._overrun = False
        self._collect(rest)
        return messages

    def _collect(self, part: bytes) -> None:
        if len(self._buffer) + len(part) > _MAX_ENCODED:
            self._overrun = True
            self._buffer.clear()
        elif not self._overrun:
            self._buffer += part


def decode(encoded: bytes) -> Message | None:
    """The message between two delimiters; None if it is damaged, unknown, of another version, or holds invalid
    values."""
    raw = unframe(encoded)
    if raw is None or len(raw) < 4 or raw[0] != VERSION:
        return None
    body = raw[:-2]
    if crc_hqx(body, _CRC_START) != _CRC.unpack_from(raw, len(body))[0]:
        return None
    kind = body[1]
    if kind == _COMMAND:
        return _decode_command(body)
    if kind == _STATUS:
        return _decode_status(body)
    if kind == _IDENT:
        return _decode_ident(body)
    if kind in (AUXILIARY, AUXILIARY_STATUS):
        return decode_outputs(kind, body[2:])
    if kind == _RADIO:
        return Radio(body[2:]) if 1 <= len(body) - 2 <= MAX_RADIO_BYTES else None
    return IdentRequest() if kind == _IDENT_REQUEST and len(body) == 2 else None


def _encode_command(message: BoardCommand) -> bytes:
    lights = message.red | message.yellow << 2 | message.green << 4
    flags = message.armed | (0 if message.lower is None else 2 if message.lower else 4)
    parts = [_COMMAND_HEAD.pack(VERSION, _COMMAND, message.sequence & 0xFF, flags, lights, _count(message.thrusters))]
    parts += [_COMMAND_THRUSTER.pack(_throttle(t.throttle), _azimuth(t.azimuth_rad)) for t in message.thrusters]
    return b"".join(parts)


def _decode_command(body: bytes) -> BoardCommand | None:
    if len(body) < _COMMAND_HEAD.size:
        return None
    _, _, sequence, flags, lights, n = _COMMAND_HEAD.unpack_from(body)
    red, yellow, green = lights & 3, lights >> 2 & 3, lights >> 4
    if n > MAX_THRUSTERS or len(body) != _COMMAND_HEAD.size + n * _COMMAND_THRUSTER.size:
        return None
    if flags > 5 or max(red, yellow, green) > Light.BLINK:
        return None
    demands = list(_COMMAND_THRUSTER.iter_unpack(body[_COMMAND_HEAD.size :]))
    for throttle, azimuth in demands:
        if not _sensible(throttle, azimuth):
            return None
    thrusters = tuple(
        [ThrusterDemand(throttle / _THROTTLE_SCALE, _azimuth_rad(azimuth)) for throttle, azimuth in demands]
    )
    lower = None if flags < 2 else flags < 4
    return BoardCommand(sequence, bool(flags & 1), thrusters, lower, _LIGHTS[red], _LIGHTS[yellow], _LIGHTS[green])


def _fitting(data: bytes) -> bytes:
    if not 1 <= len(data) <= MAX_RADIO_BYTES:
        raise ValueError(f"{len(data)} bytes for the RC receiver; a frame holds 1 to {MAX_RADIO_BYTES}")
    return data


def _encode_status(message: BoardStatus) -> bytes:
    flags = (
        message.neutral_by_watchdog
        | message.leak_wet << 1
        | message.rc_present << 2
        | message.rc_lost << 3
        | message.safe_mode << 4
        | message.takes_radio << 5
    )
    voltage = _NO_VOLTAGE if message.voltage_v is None else _scaled(message.voltage_v, 1e3, 0, _NO_VOLTAGE - 1)
    current = _NO_CURRENT if message.current_a is None else _scaled(message.current_a, 1e3, _NO_CURRENT + 1, 2**31 - 1)
    remaining = _NO_REMAINING if message.remaining is None else _scaled(message.remaining, 254.0, 0, 254)
    rc_us = [us if 0 <= us <= 65535 else min(max(us, 0), 65535) for us in message.rc_us[:RC_CHANNELS]]
    rc_us += [0] * (RC_CHANNELS - len(rc_us))
    n = _count(message.thrusters)
    parts = [
        _STATUS_HEAD.pack(VERSION, _STATUS, message.sequence & 0xFF, flags, voltage, current, remaining, *rc_us, n)
    ]
    parts += [
        _STATUS_THRUSTER.pack(_throttle(t.throttle), _azimuth(t.azimuth_rad), t.ok | (t.deployment or 0) << 1)
        for t in message.thrusters
    ]
    return b"".join(parts)


def _decode_status(body: bytes) -> BoardStatus | None:
    if len(body) < _STATUS_HEAD.size:
        return None
    _, _, sequence, flags, voltage, current, remaining, *rc_us, n = _STATUS_HEAD.unpack_from(body)
    if n > MAX_THRUSTERS or len(body) != _STATUS_HEAD.size + n * _STATUS_THRUSTER.size or flags > 63:
        return None
    states = list(_STATUS_THRUSTER.iter_unpack(body[_STATUS_HEAD.size :]))
    for throttle, azimuth, state in states:
        if not _sensible(throttle, azimuth) or state > 7:
            return None
    return BoardStatus(
        sequence=sequence,
        neutral_by_watchdog=bool(flags & 1),
        leak_wet=bool(flags & 2),
        rc_present=bool(flags & 4),
        rc_lost=bool(flags & 8),
        voltage_v=None if voltage == _NO_VOLTAGE else voltage / 1e3,
        current_a=None if current == _NO_CURRENT else current / 1e3,
        remaining=None if remaining == _NO_REMAINING else remaining / 254.0,
        rc_us=tuple(rc_us),
        thrusters=tuple(
            [
                ThrusterState(
                    throttle / _THROTTLE_SCALE,
                    _azimuth_rad(azimuth),
                    bool(state & 1),
                    Deployment(state >> 1) if state > 1 else None,
                )
                for throttle, azimuth, state in states
            ]
        ),
        safe_mode=bool(flags & 16),
        takes_radio=bool(flags & 32),
    )


def _decode_ident(body: bytes) -> Ident | None:
    if len(body) < _IDENT_HEAD.size:
        return None
    _, _, major, minor, patch, thrusters, length = _IDENT_HEAD.unpack_from(body)
    name = body[_IDENT_HEAD.size :]
    if length != len(name) or length > _MAX_NAME or not name.isascii():
        return None
    return Ident((major, minor, patch), thrusters, name.decode("ascii"))


def _sensible(throttle: int, azimuth: int) -> bool:
    return abs(throttle) <= _THROTTLE_SCALE and (abs(azimuth) <= _MAX_AZIMUTH or azimuth == _NO_AZIMUTH)


def _count(thrusters: tuple[ThrusterDemand, ...] | tuple[ThrusterState, ...]) -> int:
    if len(thrusters) > MAX_THRUSTERS:
        raise ValueError(f"{len(thrusters)} thrusters; a frame holds {MAX_THRUSTERS}")
    return len(thrusters)


def _scaled(value: float, scale: float, low: int, high: int) -> int:
    """round(value·scale) held within [low, high]; 0 for NaN."""
    scaled = value * scale
    if low <= scaled <= high:
        return round(scaled)
    return 0 if math.isnan(value) else low if scaled < low else high


def _throttle(throttle: float) -> int:
    return _scaled(throttle, _THROTTLE_SCALE, -_THROTTLE_SCALE, _THROTTLE_SCALE)


def _azimuth(azimuth_rad: float | None) -> int:
    if azimuth_rad is None or not math.isfinite(azimuth_rad):
        return _NO_AZIMUTH
    azimuth = round(wrap_pi(azimuth_rad) * _AZIMUTH_SCALE)
    return _MAX_AZIMUTH if azimuth == -_MAX_AZIMUTH else azimuth


def _azimuth_rad(azimuth: int) -> float | None:
    return None if azimuth == _NO_AZIMUTH else azimuth / _AZIMUTH_SCALE
