"""VectorNav VN-100 and VN-200 inertial sensors: their ASCII message VNYMR over serial.

Source: VectorNav, VN-100 User Manual (UM001), "Yaw, Pitch, Roll, Magnetic, Acceleration, and Angular Rates", registers
6 (type of the asynchronous output, 14 is VNYMR) and 7 (its rate). Degrees, Gauss, m/s² and rad/s in the sensor's axes,
forward, starboard, down; the specific force of a level device at rest is −9.8 m/s² downwards. Messages bear an 8-bit
checksum and no time.
"""

from __future__ import annotations

import math
import re

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.ports import ByteStream
from companion.core.readings import Imu, MagneticField, Reading
from companion.io.sensors.driver import StreamDriver
from companion.io.sensors.nmea0183_fields import checksum, number
from companion.io.sensors.own_yaw import OwnYaw
from companion.io.sensors.setup import DeviceSetup, Step

_LONGEST = 200
_MESSAGE = re.compile(rb"\$(VN[ -#%%-)+-~]{3,%d})\*([0-9A-Fa-f]{2})" % _LONGEST)
_KEPT_BYTES = _LONGEST + 4
_VALUES = 12
_YMR = 14
_OFF_S, _OFF_PERIODS = 0.5, 3.0  # a longer gap, of time and of its messages, and it may have been without power
_RATES_HZ = (1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200)  # that register 7 takes


class VectorNavSensor(StreamDriver):
    """VNYMR → `Imu`; `MagneticField` for our own AHRS; `Heading` from the device's yaw where `heading` in the vessel's
    file allows it.

    Times are those of arrival of a message's first byte, less the configured latency. With `configure` the device gets
    the command at the start, and after a gap in its messages, to send VNYMR at the rate nearest to `rate_hz`. Remembers
    the unfinished message, and what else the device sends.
    """

    messages = "VectorNav messages"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._tail = b""
        self._tail_arrival_s = 0.0
        self._other = "nothing"
        self._setup = _setup(config.rate_hz) if config.configure else None
        self._gap_s = max(_OFF_S, _OFF_PERIODS / config.rate_hz)
        self._own_yaw = OwnYaw(config)
        self._gives_field = config.heading == "ahrs"

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        kept = len(self._tail)
        buffer, done = self._tail + data, 0
        for match in _MESSAGE.finditer(buffer):
            done = match.end()
            if checksum(match[1]) != int(match[2], 16):
                self._bad += 1
                continue
            began_s = self._tail_arrival_s if match.start() < kept else arrival_s
            self._message(match[1].decode("ascii"), began_s - self._config.latency_s, arrival_s, readings)
        begin = buffer.rfind(b"$", done)
        unfinished = begin >= 0 and len(buffer) - begin <= _KEPT_BYTES
        if unfinished and begin >= kept:
            self._tail_arrival_s = arrival_s
        self._tail = buffer[begin:] if unfinished else b""

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s)
        if complaint or not self._is_useless:
            return complaint
        return f"sends {self._other}, not VNYMR: configure = true, or set its register 6 to {_YMR}"

    def _message(self, body: str, t_s: float, arrival_s: float, readings: list[Reading]) -> None:
        self._mind_gap(arrival_s)
        self._count_valid(arrival_s, body[2:5])
        used = body.startswith("VNYMR,")
        self._count_use(arrival_s, used)
        if used:
            try:
                values = [number(text) for text in body[6:].split(",")]
            except ValueError:
                values = []
            if len(values) != _VALUES or None in values:
                self._bad += 1
                return
            self._emit(t_s, [value for value in values if value is not None], readings)
        elif self._setup is not None and body.startswith("VNWRG,"):
            self._setup.heard(",".join(body.split(",")[1:3]))
        elif self._setup is not None and body.startswith("VNERR"):
            self._setup.refused(f"error {body[6:]}", arrival_s)
        else:
            self._other = body[:5]

    def _mind_gap(self, arrival_s: float) -> None:
        """A device that was without power for a moment sends what is stored in it, at the rate that is."""
        last_s, setup = self._last_valid_s, self._setup
        if setup is not None and setup.done and last_s is not None and arrival_s - last_s > self._gap_s:
            setup.restart()

    def _emit(self, t_s: float, values: list[float], readings: list[Reading]) -> None:
        yaw_deg, pitch_deg, roll_deg, mx, my, mz, x, y, z, p, q, r = values
        yaw = math.radians(yaw_deg)
        if self._gives_field:
            readings.append(MagneticField(t_s, self.name, mx, my, mz))
        readings.append(
            Imu(t_s, self.name, x, y, z, p, q, r, math.radians(roll_deg), math.radians(pitch_deg), wrap_pi(yaw))
        )
        if (heading := self._own_yaw.heading(t_s, yaw)) is not None:
            readings.append(heading)


def _setup(rate_hz: float) -> DeviceSetup:
    nearest = min(_RATES_HZ, key=lambda hz: abs(hz - rate_hz))
    commands = (("output type", f"06,{_YMR}"), ("output rate", f"07,{nearest}"))
    return DeviceSetup(
        [
            Step(name, b"$%s*%02X\r\n" % (body, checksum(body)), text)
            for name, text in commands
            if (body := f"VNWRG,{text}".encode())
        ]
    )
