"""An echo sounder that prints NMEA 0183 DPT: water of one depth everywhere, for no chart is simulated."""

from __future__ import annotations

from companion.config import SensorConfig
from sitl.emulators.device import Surroundings
from sitl.emulators.nmea import sentence
from sitl.memory import MemoryDevice
from sitl.noise import stream

_DEPTH_M, _NOISE_M, _RANGE_M = 6.0, 0.03, 100.0


class SounderEmulator:
    """Measures from the transducer, `z_m` below the origin (which floats at the surface), to the ground."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: Surroundings) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port = config, port
        self._gauss = stream(around.seed, f"{config.name} white").gauss

    def speak(self, t_s: float) -> None:
        below_m = _DEPTH_M - self._config.z_m + self._gauss(0.0, _NOISE_M)
        text = sentence(f"SDDPT,{below_m:.2f},{self._config.z_m:.2f},{_RANGE_M:.0f}")
        self._port.send(text.encode("ascii"), t_s + self._config.latency_s)
