"""Moving base: what the lead boat's receiver sends as RTCM 3, and what the follower's makes of it.

The observations themselves are not simulated. One frame with the number 4072 holds the time of the epoch and where the
base's antenna truly is: what a receiver would get out of them. Frames as long as those of four constellations in MSM4
go with it, so that the radio carries what it would carry. The follower's receiver knows of the base what arrives.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from collections.abc import Sequence

from sitl.noise import GaussMarkov, Normals, stream

PROCESSING_S = 0.05
_LENGTHS = ((1074, 150), (1084, 110), (1094, 150), (1124, 200))  # RTCM message, bytes of data with 8 to 12 satellites
_BASE = 4072
_OWN = struct.Struct(">Hddd")
_CM = {"white_m": 0.004, "slow_m": 0.008}  # of a fixed solution on each axis: 10 mm (ZED-F9P data sheet, moving base)
_FLOAT_M, _FLOAT_TAU_S = 0.4, 60.0
_FLOAT_S = 8.0  # of observations without a gap, until the integers are fixed
_GAP_S = 3.0
_FURTHEST_M = 20_000.0
_KEPT = 40
_UNIX_GPS_S, _LEAP_S, _WEEK_S = 315_964_800, 18, 604_800


def _crc(data: bytes) -> int:
    """CRC-24Q, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte << 16
        for _ in range(8):
            crc = (crc << 1) ^ (0x1864CFB if crc & 0x800000 else 0)
    return crc


def _frame(data: bytes) -> bytes:
    body = b"\xd3" + len(data).to_bytes(2, "big") + data
    return body + _crc(body).to_bytes(3, "big")


class MovingBase:
    """`frames(t_s, place)` with every fix → the RTCM of a new second, else nothing. Remembers the second."""

    def __init__(self) -> None:
        self._second = -1

    def frames(self, t_s: float, true_m: tuple[float, float]) -> list[bytes]:
        """`true_m`: north and east of home of the antenna at `t_s`."""
        if math.floor(t_s + 1e-6) == self._second:
            return []
        self._second = math.floor(t_s + 1e-6)
        fill = [
            _frame((number << 4).to_bytes(2, "big") + bytes([self._second & 0xFF]) * (n - 2)) for number, n in _LENGTHS
        ]
        return [*fill, _frame(_OWN.pack(_BASE << 4, t_s, *true_m))]


class RelativeReceiver:
    """The follower's receiver: `hear` what came in, then `solutions` → UBX-NAV-RELPOSNED of each epoch of the base.

    Solutions are float at first and after a gap, then fixed; none without observations. Remembers where its antenna
    was, the last epoch, since when there is no gap, and its errors. For tests: `frozen` repeats the last vector,
    `off_m` (north, east) is added, `deaf` hears nothing.
    """

    def __init__(self, seed: int, name: str) -> None:
        rng = self._rng = Normals(stream(seed, f"{name} relative"))
        self._slow = [GaussMarkov(rng, _CM["slow_m"], 60.0) for _ in range(2)]
        self._float = [GaussMarkov(rng, _FLOAT_M, _FLOAT_TAU_S) for _ in range(2)]
        self._buffer = b""
        self._epochs: list[tuple[float, float, float]] = []
        self._way: deque[tuple[float, float, float]] = deque(maxlen=_KEPT)
        self._last_s, self._since_s = -math.inf, math.inf
        self._vector = (0.0, 0.0)
        self.frozen = False
        self.off_m = (0.0, 0.0)
        self.deaf = False

    def hear(self, chunks: Sequence[tuple[float, bytes]], t_s: float) -> None:
        """Bytes from the host."""
        for _, data in () if self.deaf else chunks:
            self._buffer += data
        while (at := self._buffer.find(b"\xd3")) >= 0:
            self._buffer = self._buffer[at:]
            size = 6 + int.from_bytes(self._buffer[1:3], "big") % 1024
            if len(self._buffer) < size:
                break
            frame = self._buffer[:size]
            whole = _crc(frame[:-3]) == int.from_bytes(frame[-3:], "big")
            self._buffer = self._buffer[size if whole else 1 :]
            if whole and len(frame) == 6 + _OWN.size and int.from_bytes(frame[3:5], "big") >> 4 == _BASE:
                _, epoch_s, north_m, east_m = _OWN.unpack(frame[3:-3])
                self._epochs.append((epoch_s, north_m, east_m))

    def solutions(self, antenna_m: tuple[float, float], epoch_unix_ns: int, t_s: float, has_fix: bool) -> list[bytes]:
        """Messages for the epochs of the base that have come in. `antenna_m`: north and east of its antenna now."""
        self._way.append((t_s, *antenna_m))
        epochs, self._epochs = self._epochs, []
        return [self._solution(*epoch, epoch_unix_ns, has_fix) for epoch in epochs if epoch[0] >= self._way[0][0]]

    def _solution(self, epoch_s: float, north_m: float, east_m: float, epoch_unix_ns: int, has_fix: bool) -> bytes:
        if epoch_s - self._last_s > _GAP_S:
            self._since_s = epoch_s
        dt_s, self._last_s = min(60.0, epoch_s - self._last_s), epoch_s
        own_north, own_east = self._at(epoch_s)
        fixed = epoch_s - self._since_s >= _FLOAT_S
        slow = [process.update(dt_s) for process in (self._slow if fixed else self._float)]
        vector = tuple(
            own - base + error + off + self._rng.gauss(0.0, _CM["white_m"])
            for own, base, error, off in zip((own_north, own_east), (north_m, east_m), slow, self.off_m, strict=True)
        )
        self._vector = self._vector if self.frozen else (vector[0], vector[1])
        good = has_fix and math.hypot(*self._vector) < _FURTHEST_M
        state = 0 if not good else 2 if fixed else 1
        return _relposned(epoch_unix_ns * 1e-9 + epoch_s, self._vector, 0.012 if fixed else _FLOAT_M, state)

    def _at(self, t_s: float) -> tuple[float, float]:
        """Where its antenna was."""
        later = next((place for place in self._way if place[0] >= t_s - 1e-6), self._way[-1])
        before = next((place for place in reversed(self._way) if place[0] <= t_s + 1e-6), self._way[0])
        share = (t_s - before[0]) / (later[0] - before[0]) if later[0] > before[0] else 0.0
        return before[1] + share * (later[1] - before[1]), before[2] + share * (later[2] - before[2])


def _relposned(unix_s: float, vector_m: tuple[float, float], accuracy_m: float, carrier: int) -> bytes:
    """UBX-NAV-RELPOSNED, version 1. `carrier`: 0 no solution, 1 float, 2 fixed."""
    itow_ms = round(1000.0 * (unix_s - _UNIX_GPS_S + _LEAP_S)) % (1000 * _WEEK_S)
    whole = [round(part * 1e4) for part in (*vector_m, 0.0, math.hypot(*vector_m))]
    coarse = [int(part / 100) for part in whole]
    fine = [part - 100 * rough for part, rough in zip(whole, coarse, strict=True)]
    heading = round(1e5 * (math.degrees(math.atan2(vector_m[1], vector_m[0])) % 360.0))
    flags = 0x20 | (0x07 | carrier << 3 | 0x100 if carrier else 0x01)
    tenths = round(accuracy_m * 1e4)
    payload = struct.pack(
        "<BBHI4iiI4b6II",
        *(1, 0, 0, itow_ms, *coarse, heading, 0, *fine, *(tenths,) * 4, 100_000, 0, flags),
    )
    body = b"\x01\x3c" + len(payload).to_bytes(2, "little") + payload
    a = b = 0
    for byte in body:
        a = (a + byte) % 256
        b = (b + a) % 256
    return b"\xb5\x62" + body + bytes((a, b))
