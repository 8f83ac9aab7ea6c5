"""A fluxgate compass that prints NMEA 0183 HDG: magnetic heading, with an empty variation."""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import sentence
from sitl.lies import HeadingLies
from sitl.memory import MemoryDevice
from sitl.sensor_errors import current_field
from sitl.sensors import CompassModel


class CompassEmulator:
    """Prints what its compass model measures, `latency_s` after it is valid."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._around = config, port, around
        field = current_field(around.aboard, config.name, around.home, around.epoch_unix_ns, around.seed)
        self._model = CompassModel(config, around.home, around.epoch_unix_ns, 1.0 / self.rate_hz, around.seed, field)
        self._lies = HeadingLies(around.faults, config.name, around.seed)

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        measured_rad = self._model.sample(self._around.hull.yaw_rad) - self._config.heading_offset_rad
        heading_rad = self._lies.told(measured_rad, t_s)
        text = sentence(f"HCHDG,{math.degrees(heading_rad) % 360.0:.1f},,,,")
        self._port.send(text.encode("ascii"), t_s + self._config.latency_s)
