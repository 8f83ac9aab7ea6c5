"""The boat's state for the transmitter's screen, in CRSF frames: place, battery, attitude, mode.

Source: TBS, "CRSF protocol" (github.com/tbs-fpv/tbs-crsf-spec), frames 0x02, 0x08, 0x1E and 0x21.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Protocol

from fastcrc import crc8

from companion.core.angles import wrap_pi
from companion.core.tick import Tick

_ADDRESS = 0xC8
_GPS, _BATTERY, _ATTITUDE, _MODE = 0x02, 0x08, 0x1E, 0x21
_PERIOD_S = 0.1  # of one frame: the radio link carries some in a second
_EARLY_S = 1e-3
_DEG = struct.Struct(">iiHHHB")
_ANGLES = struct.Struct(">hhh")
_KMPH = 3.6
_ALTITUDE_0_M = 1000
_LONGEST_NAME = 15


class WayBack(Protocol):
    """Where the frames go: a receiver's port, or the board that the receiver is wired to."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send a whole frame."""
        ...

    def fault(self) -> str | None:
        """Why nothing can be sent, or None."""
        ...


class CrsfTelemetry:
    """A `Recorder`: writes one frame in 0.1 s, each kind in its turn. What is unknown is left out. Remembers whose turn
    it is, and when."""

    def __init__(self, stream: WayBack) -> None:
        self._stream = stream
        self._turn = 0
        self._due_s = -math.inf

    def record(self, tick: Tick) -> None:
        """Write the frame that is due."""
        if tick.t_s < self._due_s - _EARLY_S or self._stream.fault() is not None:
            return
        self._due_s = tick.t_s + _PERIOD_S
        for _ in _KINDS:
            kind, payload_of = _KINDS[self._turn]
            self._turn = (self._turn + 1) % len(_KINDS)
            if (payload := payload_of(tick)) is not None:
                self._stream.write(framed(kind, payload), tick.t_s)
                return

    def close(self) -> None:
        """The driver closes the port."""


def framed(kind: int, payload: bytes) -> bytes:
    """A whole frame."""
    body = bytes((kind,)) + payload
    return bytes((_ADDRESS, len(body) + 1)) + body + bytes((crc8.dvb_s2(body),))


def _gps(tick: Tick) -> bytes | None:
    nav = tick.nav
    if not nav.position_valid:
        return None
    speed = _fitted(10.0 * _KMPH * math.hypot(nav.north_mps, nav.east_mps), 0, 0xFFFF)
    heading = _fitted(100.0 * (math.degrees(nav.yaw_rad) % 360.0), 0, 35999) if nav.heading_valid else 0
    place = (_fitted(1e7 * nav.lat_deg, -(2**31), 2**31 - 1), _fitted(1e7 * nav.lon_deg, -(2**31), 2**31 - 1))
    altitude = _fitted(nav.altitude_m + _ALTITUDE_0_M, 0, 0xFFFF)
    return _DEG.pack(*place, speed, heading, altitude, _fitted(nav.satellites or 0, 0, 255))


def _battery(tick: Tick) -> bytes | None:
    battery = tick.inputs.battery
    if battery is None:
        return None
    voltage = _fitted(10.0 * battery.voltage_v, 0, 0xFFFF)
    current = _fitted(10.0 * (battery.current_a or 0.0), 0, 0xFFFF)
    share = _fitted(100.0 * (battery.remaining or 0.0), 0, 100)
    return struct.pack(">HH", voltage, current) + bytes((0, 0, 0, share))  # the charge used is not measured


def _attitude(tick: Tick) -> bytes | None:
    nav = tick.nav
    if not nav.heading_valid:
        return None
    angles = (nav.pitch_rad, nav.roll_rad, nav.yaw_rad)
    if not all(map(math.isfinite, angles)):
        return None
    return _ANGLES.pack(*(_fitted(1e4 * wrap_pi(angle), -31416, 31416) for angle in angles))


def _mode(tick: Tick) -> bytes | None:
    """A star means disarmed, as other autopilots have it."""
    status = tick.status
    return (status.mode.value + ("" if status.armed else "*")).encode("ascii", "replace")[:_LONGEST_NAME] + b"\0"


_KINDS: tuple[tuple[int, Callable[[Tick], bytes | None]], ...] = (
    (_GPS, _gps),
    (_BATTERY, _battery),
    (_ATTITUDE, _attitude),
    (_MODE, _mode),
)


def _fitted(value: float, low: int, high: int) -> int:
    """Rounded and within the range; 0 for what is not a number."""
    return min(max(round(value), low), high) if math.isfinite(value) else 0
