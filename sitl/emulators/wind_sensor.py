"""A masthead wind sensor that prints NMEA 0183 MWV: apparent wind, relative to the bow."""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from companion.core.frames import ned_to_body
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import sentence
from sitl.lies import WindLies
from sitl.memory import MemoryDevice
from sitl.noise import stream
from sitl.sensor_errors import distorted_wind

_SPEED_MPS = 0.15
_ANGLE_RAD = math.radians(2.0)


class WindEmulator:
    """Measures the air that moves over the boat, with white noise of speed and angle."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._around = config, port, around
        self._lies = WindLies(around.faults, config.name)
        self._gauss = stream(around.seed, f"{config.name} white").gauss

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        hull, wind = self._around.hull, self._around.wind
        x_mps, y_mps = ned_to_body(hull.north_mps - wind.north_mps, hull.east_mps - wind.east_mps, hull.yaw_rad)
        speed_mps, angle = math.hypot(x_mps, y_mps), math.atan2(y_mps, x_mps)
        if self._around.aboard is not None:
            speed_mps, angle = distorted_wind(self._around.aboard.errors, speed_mps, angle)
        speed_mps = max(0.0, speed_mps + self._gauss(0.0, _SPEED_MPS))
        angle = angle - self._config.heading_offset_rad + self._gauss(0.0, _ANGLE_RAD)
        speed_mps, angle = self._lies.told(speed_mps, angle)
        text = sentence(f"WIMWV,{math.degrees(angle) % 360.0:.1f},R,{speed_mps:.2f},M,A")
        self._port.send(text.encode("ascii"), t_s + self._config.latency_s)
