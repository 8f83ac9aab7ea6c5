"""A radar that tracks targets and prints NMEA 0183 TTM, one sentence a target: vessels and round obstacles."""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import KNOTS_PER_MPS, sentence
from sitl.memory import MemoryDevice
from sitl.noise import stream

_NOISE_M, _NOISE_RAD = 1.0, math.radians(0.5)
_LEAST_M, _MOST_M = 5.0, 3000.0
_MILE_M = 1852.0


class RadarEmulator:
    """Reports each target by true bearing and distance from the boat, with true course and speed."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._around = config, port, around
        self._gauss = stream(around.seed, f"{config.name} white").gauss

    def speak(self, t_s: float) -> None:
        """Print all targets in reach."""
        hull = self._around.hull
        targets = [(*one.at(t_s), one.north_mps, one.east_mps) for one in self._around.obstacles.round]
        for vessel in self._around.traffic.vessels:
            motion = vessel.at(t_s)
            north_mps, east_mps = (
                motion.speed_mps * math.cos(motion.course_rad),
                motion.speed_mps * math.sin(motion.course_rad),
            )
            targets.append((motion.north_m, motion.east_m, north_mps, east_mps))
        for number, (north_m, east_m, north_mps, east_mps) in enumerate(targets, start=1):
            off_m = math.hypot(north_m - hull.north_m, east_m - hull.east_m) + self._gauss(0.0, _NOISE_M)
            bearing = math.atan2(east_m - hull.east_m, north_m - hull.north_m) + self._gauss(0.0, _NOISE_RAD)
            if _LEAST_M <= off_m <= _MOST_M:
                self._print(number, off_m, bearing, (north_mps, east_mps), t_s)

    def _print(self, number: int, off_m: float, bearing: float, velocity: tuple[float, float], t_s: float) -> None:
        knots = math.hypot(*velocity) * KNOTS_PER_MPS
        course_deg = math.degrees(math.atan2(velocity[1], velocity[0])) % 360.0
        body = (
            f"RATTM,{number:02d},{off_m / _MILE_M:.4f},{math.degrees(bearing) % 360.0:.1f},T,{knots:.2f},"
            f"{course_deg:.1f},T,,,N,,T,,,A"
        )
        self._port.send(sentence(body).encode("ascii"), t_s + self._config.latency_s)
