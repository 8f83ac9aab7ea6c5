"""AIS receivers and transponders: NMEA 0183 VDM sentences of other vessels, over serial or network.

Source: ITU-R M.1371-5 as pyais decodes it; E. S. Raymond, "AIVDM/AIVDO protocol decoding", for the sentences. Position
reports of class A (1, 2, 3, 27) and class B (18, 19) and the ships' own data (5, 19, 24) are read; the rest is only
counted. The boat's own reports (VDO) are not traffic. Sentences without a checksum are rejected.
"""

from __future__ import annotations

import math
import re
from typing import Any

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import AisTarget, Reading
from companion.io.sensors.driver import StreamDriver
from companion.io.sensors.message_timing import MessageTiming
from companion.io.sensors.nmea0183_fields import checksum

_LONGEST = 100  # of a sentence between ! and *
_SENTENCE = re.compile(
    rb"!([A-Z]{2}VDM,([1-9]),([1-9]),([0-9]?),([^,*!]{0,2}),[0-W`-w]{1,%d},[0-5])\*([0-9A-Fa-f]{2})" % _LONGEST
)
_KEPT_BYTES = _LONGEST + 30
_FRAGMENTS_S = 4.0  # between the parts of one message
_MOST_UNFINISHED = 16
_KNOT_MPS = 1852.0 / 3600.0
_MOTION, _SHIP = frozenset({1, 2, 3, 18, 19, 27}), frozenset({5, 19, 24})
_COARSE = 27  # whole knots and degrees, 63 and 511 for none
_NO_COURSE, _NO_SPEED_KN, _NO_SPEED_27_KN = 360.0, 102.25, 63.0
_NO_STATUS = 15
_MOST_TURN_DEG_MIN = 709.0  # ±127: it turns at an unknown rate


class AisReceiver(StreamDriver):
    """VDM sentences → `AisTarget`. Times are those of arrival of a message's first part, less the configured latency.

    Remembers the unfinished sentence and the parts of unfinished messages. Silence is no fault: there may be no vessel.
    """

    messages = "AIS sentences"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        import pyais  # 0.2 s and 10 MB: for vessels that have a receiver
        from pyais.exceptions import AISBaseException

        self._decode = pyais.decode
        self._decoding_errors = (AISBaseException, ValueError, TypeError, LookupError, ArithmeticError, AttributeError)
        self._pace = MessageTiming(0.0)  # other vessels have no fixed rate
        self._tail = b""
        self._unfinished: dict[tuple[bytes, ...], tuple[float, dict[int, bytes]]] = {}

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s)
        silent = self._stream.fault() is None and complaint.startswith(("silent", "nothing received"))
        return "" if silent else complaint

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        buffer, done = self._tail + data, 0
        for match in _SENTENCE.finditer(buffer):
            done = match.end()
            if checksum(match[1]) != int(match[6], 16):
                self._bad += 1
                continue
            self._count_valid(arrival_s)
            self._sentence(match, arrival_s, readings)
        begin = buffer.rfind(b"!", done)
        self._tail = buffer[begin:] if begin >= 0 and len(buffer) - begin <= _KEPT_BYTES else b""

    def _sentence(self, match: re.Match[bytes], arrival_s: float, readings: list[Reading]) -> None:
        total, number = int(match[2]), int(match[3])
        if total == 1:
            self._message([match[0]], arrival_s, readings)
            return
        key = (match[2], match[4], match[5])
        began_s, parts = self._unfinished.pop(key, (arrival_s, {}))
        if number == 1 or arrival_s - began_s > _FRAGMENTS_S:
            began_s, parts = arrival_s, {}
        if number > total or (not parts and number != 1):
            self._bad += 1
            return
        parts[number] = match[0]
        if len(parts) == total:
            self._message([parts[n] for n in sorted(parts)], began_s, readings)
            return
        if len(self._unfinished) >= _MOST_UNFINISHED:
            del self._unfinished[next(iter(self._unfinished))]
        self._unfinished[key] = began_s, parts

    def _message(self, sentences: list[bytes], arrival_s: float, readings: list[Reading]) -> None:
        try:
            message = self._decode(*sentences)
            target = _target(message, arrival_s - self._config.latency_s, self.name)
        except self._decoding_errors:  # bits that are no message: the radio's fault, or somebody's
            self._bad += 1
            return
        if target is not None:
            readings.append(target)


def _target(message: Any, t_s: float, source: str) -> AisTarget | None:
    """The vessel that a decoded message is about; None for messages about none."""
    values: dict[str, Any] = {}
    if message.msg_type in _MOTION:
        values |= _motion(message)
    if message.msg_type in _SHIP:
        values |= _ship(message)
    return AisTarget(t_s, source, int(message.mmsi), **values) if values else None


def _motion(message: Any) -> dict[str, Any]:
    lat_deg, lon_deg = float(message.lat), float(message.lon)
    if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0):  # 91, 181: not known
        return {}
    nothing_kn = _NO_SPEED_27_KN if message.msg_type == _COARSE else _NO_SPEED_KN
    course_deg, heading_deg, turn = (
        float(message.course),
        getattr(message, "heading", None),
        getattr(message, "turn", None),
    )
    return {
        "lat_deg": lat_deg,
        "lon_deg": lon_deg,
        "course_rad": math.radians(course_deg) if 0.0 <= course_deg < _NO_COURSE else None,
        "speed_mps": float(message.speed) * _KNOT_MPS if 0.0 <= message.speed < nothing_kn else None,
        "heading_rad": math.radians(heading_deg) if heading_deg is not None and 0 <= heading_deg < 360 else None,
        "turn_rate_radps": _turn_rate_radps(turn),
        "status": _status(getattr(message, "status", None)),
    }


def _turn_rate_radps(turn: Any) -> float | None:
    """`turn` in degrees a minute, or one of pyais's words for a missing value."""
    if type(turn) is not float or abs(turn) >= _MOST_TURN_DEG_MIN:
        return None
    return math.radians(turn) / 60.0


def _status(status: Any) -> int | None:
    return None if status is None or int(status) == _NO_STATUS else int(status)


def _ship(message: Any) -> dict[str, Any]:
    """Size, type and names, as far as this message (or this half of a 24) brings them."""
    kind = getattr(message, "ship_type", None)
    values: dict[str, Any] = {
        "callsign": _text(message, "callsign"),
        "name": _text(message, "shipname"),
        "kind": int(kind) if kind else None,
    }
    sizes = [float(getattr(message, name, None) or 0.0) for name in ("to_bow", "to_stern", "to_port", "to_starboard")]
    if any(sizes):
        values |= dict(zip(("bow_m", "stern_m", "port_m", "starboard_m"), sizes, strict=True))
    return {name: value for name, value in values.items() if value is not None}


def _text(message: Any, name: str) -> str | None:
    text = getattr(message, name, None)
    shown = "".join(c for c in text if c.isprintable()).strip(" @") if isinstance(text, str) else ""
    return shown or None
