"""An echo sounder that prints NMEA 0183 DPT. The water has the same depth everywhere, until it becomes
shallow."""

from __future__ import annotations

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import sentence
from sitl.memory import MemoryDevice
from sitl.noise import stream

_DEPTH_M, _NOISE_M, _RANGE_M = 6.0, 0.03, 100.0
_SHALLOW_M = 0.5  # below the transducer, under the fault of that name


class SounderEmulator:
    """Measures the depth below the transducer, which is `z_m` below the origin; the origin is at the surface."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._faults = config, port, around.faults
        self._gauss = stream(around.seed, f"{config.name} white").gauss

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        depth_m = _SHALLOW_M if "shallow" in self._faults.active else _DEPTH_M - self._config.z_m
        below_m = depth_m + self._gauss(0.0, _NOISE_M)
        text = sentence(f"SDDPT,{below_m:.2f},{self._config.z_m:.2f},{_RANGE_M:.0f}")
        self._port.send(text.encode("ascii"), t_s + self._config.latency_s)
