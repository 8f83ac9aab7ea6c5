"""What speaks on a line: bytes → the protocol whose checksums hold, and the driver for it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.core.microcontroller_frame import FrameDecoder
from companion.io.mavlink.framer import Framer, UnknownMessage
from companion.io.rtcm import RtcmFramer
from companion.io.sensors.nmea0183_fields import checksum

_sentences = re.compile(rb"([$!])([ -#%%-)+-~]{6,200})\*([0-9A-Fa-f]{2})").finditer
_MTDATA2 = b"\xfa\xff"
_UBX = b"\xb5\x62"


@dataclass(frozen=True, slots=True)
class Voice:
    """A protocol heard: its name for people, the driver that reads it (None: none here does), and what of it was heard."""

    protocol: str
    driver: str | None
    details: str = ""

    @property
    def text(self) -> str:
        heard = f"{self.protocol} ({self.details})" if self.details else self.protocol
        return f'{heard}: driver = "{self.driver}"' if self.driver is not None else heard


def recognise(data: bytes) -> Voice | None:
    """The first protocol of which a whole message with a good checksum is in `data`; None for bytes that make no sense."""
    for look in _LOOKS:
        voice = look(data)
        if voice is not None:
            return voice
    return None


def _text(data: bytes) -> Voice | None:
    bodies = [(m[1], m[2].decode("ascii")) for m in _sentences(data) if checksum(m[2]) == int(m[3], 16)]
    plain = sorted({body[:5] for start, body in bodies if start == b"$"})
    if "VNYMR" in plain:
        return Voice("VectorNav ASCII", "vectornav")
    if plain:
        return Voice("NMEA 0183", "nmea0183", ", ".join(plain))
    return Voice("AIS", "ais") if bodies else None


def _xsens(data: bytes) -> Voice | None:
    at = -1
    while (at := data.find(_MTDATA2, at + 1)) >= 0:
        if at + 4 <= len(data):
            end = at + 5 + data[at + 3]
            if data[at + 3] > 0 and end <= len(data) and sum(data[at + 1 : end]) & 0xFF == 0:
                return Voice("Xsens MTData2", "mtdata2") if data[at + 2] == 0x36 else Voice("Xsens messages", "mtdata2", "not MTData2")
    return None


def _mavlink(data: bytes) -> Voice | None:
    framer = Framer()
    kinds = sorted({message.get_type() for message in framer.feed(data) if not isinstance(message, UnknownMessage)})
    return Voice("MAVLink", "mavlink_imu", ", ".join(kinds[:4])) if kinds else None


def _microcontroller(data: bytes) -> Voice | None:
    return Voice("the microcontroller protocol of this project", None, "an [[actuator]]") if FrameDecoder().feed(data) else None


def _rtcm(data: bytes) -> Voice | None:
    return Voice("RTCM 3", None, "[[corrections]]") if RtcmFramer().feed(data) else None


def _ubx(data: bytes) -> Voice | None:
    at = -1
    while (at := data.find(_UBX, at + 1)) >= 0:
        if at + 8 > len(data):
            continue
        end = at + 6 + (data[at + 4] | data[at + 5] << 8)
        if end + 2 <= len(data) and _fletcher(data[at + 2 : end]) == data[end : end + 2]:
            return Voice("u-blox UBX", None, "switch its NMEA output on")
    return None


def _fletcher(data: bytes) -> bytes:
    a = b = 0
    for byte in data:
        a = a + byte & 0xFF
        b = b + a & 0xFF
    return bytes((a, b))


_LOOKS: Sequence[Callable[[bytes], Voice | None]] = (_text, _xsens, _mavlink, _microcontroller, _rtcm, _ubx)
