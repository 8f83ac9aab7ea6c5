"""An Xsens MTi that prints MTData2 in the NED frame, with axes forward, starboard, down.

It measures with every step of the world, and sends what its strapdown integration makes of them (Movella, *MTi User
Manual*, 4.9.3). North is magnetic where the vessel's file calls its heading "magnetic". Source: MT Low-Level
Communication Protocol. FA FF 36 LEN DATA CS: all bytes after FA add up to 0 modulo 256; numbers are big-endian. DATA is
a row of (identifier u16, size u8, value). In the low nibble of an identifier 0 means 32-bit floats and 4 the NED frame.
"""

from __future__ import annotations

import math
import struct

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.xsens_settings import XsensSettings
from sitl.lies import HeadingLies, ImuLies
from sitl.magnetometer import MagnetometerModel
from sitl.memory import MemoryDevice
from sitl.sensors import ImuModel, StrapdownMean, imu_errors, north_of

_PACKET_COUNTER = 0x1020
_SAMPLE_TIME_FINE = 0x1060
_QUATERNION_NED = 0x2014
_ACCELERATION = 0x4020
_RATE_OF_TURN = 0x8020
_MAGNETIC_FIELD = 0xC020
_STATUS_WORD = 0xE020
_STATUS_GOOD = 0x00000003  # self-test passed, filter valid
_TICKS_PER_S = 10_000

_MESSAGE = struct.Struct(">BBBB HBH HBI HB4f HB3f HB3f HBI".replace(" ", ""))
_FIELD = struct.Struct(">HB3f")
_LENGTH = _MESSAGE.size - 4
_FIELD_HZ = 50.0


class XsensEmulator:
    """Prints what its inertial model measures, `latency_s` after it is valid; for an AHRS vessel also the magnetic
    field.

    If the driver configures it, it accepts the commands for that, and is mounted as the vessel's file says.
    """

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        sent_hz = min(config.rate_hz, around.step_hz)
        self.rate_hz = around.step_hz
        self._share, self._due = sent_hz / around.step_hz, 0.0
        dt_s = 1.0 / self.rate_hz
        self._mean = StrapdownMean(dt_s)
        errors = imu_errors(around.aboard, config.name, around.home, around.epoch_unix_ns, dt_s, around.seed)
        self.model = ImuModel(config, around.home, dt_s, around.seed, errors)
        self._lies, self._field_lies = (
            ImuLies(around.faults, config.name, around.seed),
            HeadingLies(around.faults, config.name, around.seed),
        )
        self._port = port
        self._around = around
        self._latency_s = config.latency_s
        self._north_rad = north_of(around.home, around.epoch_unix_ns) if config.heading == "magnetic" else 0.0
        self._counter = 0
        self._magnetometer = (
            MagnetometerModel(config, around.home, around.epoch_unix_ns, around.seed, around.aboard)
            if config.heading == "ahrs"
            else None
        )
        self._field_every = max(1, round(sent_hz / _FIELD_HZ))
        self._settings = (
            XsensSettings(config.rotation_rad, sent_hz) if config.configure or config.rotation_rad is not None else None
        )

    def speak(self, t_s: float) -> None:
        """Answer commands, measure now, and send what is due."""
        around, settings = self._around, self._settings
        self._mean.take(self.model.sample(around.hull, around.waves))
        self._due += self._share
        if self._due < 1.0 - 1e-9:
            return
        self._due = max(self._due - 1.0, 0.0)
        sample = self._lies.told(self._mean.taken(), t_s)
        if "imu_lost" in around.faults.active:
            return
        field = None
        if self._magnetometer is not None and self._counter % self._field_every == 0:
            yaw_rad = self._field_lies.told(around.hull.yaw_rad, t_s)
            field = self._magnetometer.sample(around.waves.roll_rad, around.waves.pitch_rad, yaw_rad)
        if settings is not None:
            answers = settings.hear(b"".join(data for _, data in self._port.receive(t_s)))
            self._port.send(answers, t_s)
            if not settings.measuring:
                return
        own_s = t_s + self._lies.clock_off_s(t_s)
        data = self.message(sample, own_s, field) if settings is None else self._as_set(settings, sample, own_s, field)
        for message in self._lies.sent(data):
            self._port.send(message, t_s + self._latency_s)

    def _as_set(
        self, settings: XsensSettings, sample: tuple[float, ...], t_s: float, field: tuple[float, float, float] | None
    ) -> bytes:
        """The message with the outputs and axes that the settings ask for."""
        x, y, z, p, q, r, roll, pitch, yaw = sample
        counter, self._counter = self._counter, (self._counter + 1) & 0xFFFF
        items = {
            _PACKET_COUNTER: struct.pack(">H", counter),
            _SAMPLE_TIME_FINE: struct.pack(">I", round(t_s * _TICKS_PER_S) & 0xFFFFFFFF),
            _QUATERNION_NED: struct.pack(">4f", *settings.attitude(_quaternion(roll, pitch, yaw - self._north_rad))),
            _ACCELERATION: struct.pack(">3f", *settings.turned((x, y, z))),
            _RATE_OF_TURN: struct.pack(">3f", *settings.turned((p, q, r))),
            _STATUS_WORD: struct.pack(">I", _STATUS_GOOD),
        }
        if field is not None:
            items[_MAGNETIC_FIELD] = struct.pack(">3f", *settings.turned(field))
        asked = settings.outputs
        data = b"".join(
            struct.pack(">HB", data_id, len(value)) + value
            for data_id, value in items.items()
            if asked is None or (data_id in asked and counter % asked[data_id] == 0)
        )
        body = bytes((0xFF, 0x36, len(data))) + data
        return b"\xfa" + body + bytes((-sum(body) & 0xFF,))

    def message(self, sample: tuple[float, ...], t_s: float, field: tuple[float, float, float] | None = None) -> bytes:
        """One MTData2 message with the usual outputs."""
        more = b"" if field is None else _FIELD.pack(_MAGNETIC_FIELD, 12, *field)
        x, y, z, p, q, r, roll, pitch, yaw = sample
        counter, self._counter = self._counter, (self._counter + 1) & 0xFFFF
        ticks = round(t_s * _TICKS_PER_S) & 0xFFFFFFFF
        w, i, j, k = _quaternion(roll, pitch, yaw - self._north_rad)
        # fmt: off
        raw = _MESSAGE.pack(
            0xFA, 0xFF, 0x36, _LENGTH + len(more),
            _PACKET_COUNTER, 2, counter,
            _SAMPLE_TIME_FINE, 4, ticks,
            _QUATERNION_NED, 16, w, i, j, k,
            _ACCELERATION, 12, x, y, z,
            _RATE_OF_TURN, 12, p, q, r,
            _STATUS_WORD, 4, _STATUS_GOOD,
        )
        # fmt: on
        raw += more
        return raw + bytes(((0xFA - sum(raw)) & 0xFF,))


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Body → NED, scalar first."""
    c1, s1 = math.cos(0.5 * roll), math.sin(0.5 * roll)
    c2, s2 = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    c3, s3 = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        c1 * c2 * c3 + s1 * s2 * s3,
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
    )
