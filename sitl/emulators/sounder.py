"""An echo sounder that prints NMEA 0183 DPT: the depth of the water below it, or ahead where it looks ahead."""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import sentence
from sitl.lies import DepthLies
from sitl.memory import MemoryDevice
from sitl.noise import stream

_NOISE_M, _RANGE_M = 0.03, 100.0
_SHALLOW_M = 0.5  # below the transducer, under the fault of that name


class SounderEmulator:
    """Measures the depth below the transducer, which is `z_m` below the origin; the origin is at the surface."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._around = config, port, around
        self._lies = DepthLies(around.faults, config.name)
        self._gauss = stream(around.seed, f"{config.name} white").gauss

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        hull, ahead_m = self._around.hull, self._config.depth_ahead_m or self._config.x_m
        place = hull.north_m + ahead_m * math.cos(hull.yaw_rad), hull.east_m + ahead_m * math.sin(hull.yaw_rad)
        shallow = "shallow" in self._around.faults.active
        depth_m = _SHALLOW_M if shallow else max(0.0, self._around.obstacles.depth_m(*place) - self._config.z_m)
        below_m = self._lies.told(depth_m + self._gauss(0.0, _NOISE_M))
        text = sentence(f"SDDPT,{below_m:.2f},{self._config.z_m:.2f},{_RANGE_M:.0f}")
        self._port.send(text.encode("ascii"), t_s + self._config.latency_s)
