"""A VectorNav VN-100 that prints VNYMR, mounted forward, starboard, down.

Source: VectorNav, VN-100 User Manual, register 27: yaw, pitch, roll in degrees, magnetic field in Gauss, acceleration
in m/s², angular rates in rad/s. It answers a written register with the same text under VNWRG, and a command that it
cannot carry out with VNERR.
"""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import checksum_text, sentence
from sitl.lies import HeadingLies, ImuLies
from sitl.magnetometer import MagnetometerModel
from sitl.memory import MemoryDevice
from sitl.sensors import ImuModel, imu_errors, north_of

_TAKEN = {"06": {"14"}, "07": {"1", "2", "4", "5", "10", "20", "25", "40", "50", "100", "200"}}
_INVALID_PARAMETER = 6


class VectorNavEmulator:
    """Prints what its inertial model measures, `latency_s` after it is valid. If the driver configures it, it sends
    VNYMR only after that."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        dt_s = 1.0 / self.rate_hz
        errors = imu_errors(around.aboard, config.name, around.home, around.epoch_unix_ns, dt_s, around.seed)
        self._model = ImuModel(config, around.home, dt_s, around.seed, errors)
        self._field = MagnetometerModel(config, around.home, around.epoch_unix_ns, around.seed, around.aboard)
        self._lies, self._field_lies = (
            ImuLies(around.faults, config.name, around.seed),
            HeadingLies(around.faults, config.name, around.seed),
        )
        self._config, self._port, self._around = config, port, around
        self._north_rad = north_of(around.home, around.epoch_unix_ns) if config.heading == "magnetic" else 0.0
        self._registers = {} if config.configure else {"06": "14", "07": "100"}

    def speak(self, t_s: float) -> None:
        """Answer commands, measure now, and send."""
        around = self._around
        x, y, z, p, q, r, roll, pitch, yaw = self._lies.told(self._model.sample(around.hull, around.waves), t_s)
        for _, data in self._port.receive(t_s):
            for line in data.decode("ascii").splitlines():
                self._hear(line, t_s)
        if "imu_lost" in around.faults.active or len(self._registers) < len(_TAKEN):
            return
        yaw_rad = self._field_lies.told(around.hull.yaw_rad, t_s)
        mx, my, mz = self._field.sample(around.waves.roll_rad, around.waves.pitch_rad, yaw_rad)
        heading = math.degrees(math.remainder(yaw - self._north_rad, math.tau))
        text = (
            f"VNYMR,{heading:+08.3f},{math.degrees(pitch):+08.3f},{math.degrees(roll):+08.3f},{mx:+08.4f},{my:+08.4f},{mz:+08.4f},"
            f"{x:+07.3f},{y:+07.3f},{z:+07.3f},{p:+010.6f},{q:+010.6f},{r:+010.6f}"
        )
        for message in self._lies.sent(sentence(text).encode("ascii")):
            self._port.send(message, t_s + self._config.latency_s)

    def _hear(self, line: str, t_s: float) -> None:
        body, _, text = line.removeprefix("$").partition("*")
        if checksum_text(body) != text:
            return
        name, register, value, *_ = (*body.split(","), "", "")
        if name == "VNWRG" and value in _TAKEN.get(register, ()):
            self._registers[register] = value
            self._port.send(sentence(body).encode("ascii"), t_s)
        else:
            self._port.send(sentence(f"VNERR,{_INVALID_PARAMETER:02d}").encode("ascii"), t_s)
