"""A satellite receiver that prints NMEA 0183: GGA, HDT, VTG, ZDA with two antennas; GGA, RMC, VTG with one. With
`moving_base` it prints UBX-NAV-RELPOSNED besides."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import KNOTS_PER_MPS, sentence
from sitl.lies import GnssLies
from sitl.memory import MemoryDevice
from sitl.moving_base import PROCESSING_S, RelativeReceiver
from sitl.receiver_troubles import ReceiverTroubles
from sitl.sensors import GnssModel, GnssSample

_MODES = {1: "A", 2: "D", 4: "R", 5: "F"}
_GEOID_M = 40.0  # printed height of the geoid; altitudes are above mean sea level


class GnssEmulator:
    """Prints what its receiver model measures, `latency_s` after it is valid."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._port = port
        self._around = around
        self._latency_s = config.latency_s
        self._single = config.antennas == 1
        self._model = GnssModel(config, around.home, around.gnss, 1.0 / self.rate_hz, around.seed, around.common)
        self._lies = GnssLies(around.faults, config.name, around.home, around.seed)
        self._troubles = ReceiverTroubles(around.faults, config.name, around.home, 1.0 / self.rate_hz, around.seed)
        self.relative = RelativeReceiver(around.seed, config.name) if config.moving_base else None
        self._date_of: tuple[int, str] = (-1, "")

    @property
    def slow_m(self) -> tuple[float, float]:
        """The slow error of its newest position, north and east."""
        return self._model.slow_m

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        around = self._around
        measured = self._troubles.sent(self._model.sample(around.hull, around.waves, around.faults.active), t_s)
        if measured is None:
            return
        sample = self._lies.told(measured, t_s)
        text = self.sentences(sample, t_s + self._lies.time_off_s(t_s))
        arrives_s = self._troubles.arrival_s(t_s + self._latency_s)
        self._port.send(text.encode("ascii"), arrives_s)
        if self.relative is not None:
            self.relative.hear(self._port.receive(t_s), t_s)
            antenna = self._model.antenna(around.hull, around.waves)
            has_fix = sample.position is not None
            for data in self.relative.solutions(antenna, around.epoch_unix_ns, t_s, has_fix):
                self._port.send(data, arrives_s + PROCESSING_S)

    def sentences(self, sample: GnssSample, t_s: float) -> str:
        """The sentences of one solution, valid at `t_s` by the receiver's clock."""
        clock, date = self._utc(t_s)
        if self._single:
            return "".join(map(sentence, (_gga(sample, clock), _rmc(sample, clock, date), _vtg(sample))))
        heading = "" if sample.heading_rad is None else f"{math.degrees(sample.heading_rad) % 360.0:.2f}"
        return "".join(
            (
                sentence(_gga(sample, clock)),
                sentence(f"GPHDT,{heading},T"),
                sentence(_vtg(sample)),
                sentence(f"GPZDA,{clock},{date},00,00"),
            )
        )

    def _utc(self, t_s: float) -> tuple[str, str]:
        """(hhmmss.ss, dd,mm,yyyy) of simulated time."""
        centiseconds = (self._around.epoch_unix_ns + round(t_s * 1e9) + 5_000_000) // 10_000_000
        days, of_day = divmod(centiseconds, 8_640_000)
        if days != self._date_of[0]:
            self._date_of = days, datetime.fromtimestamp(days * 86400, UTC).strftime("%d,%m,%Y")
        minutes, rest = divmod(of_day, 6000)
        return f"{minutes // 60:02d}{minutes % 60:02d}{rest // 100:02d}.{rest % 100:02d}", self._date_of[1]


def _gga(sample: GnssSample, clock: str) -> str:
    grade = sample.grade
    if sample.position is None:
        return f"GNGGA,{clock},,,,,0,00,99.9,,M,,M,,"
    lat_deg, lon_deg, altitude_m = sample.position
    correction = "1.0,0001" if grade.quality != 1 else ","
    return (
        f"GNGGA,{clock},{_place(lat_deg, lon_deg)},{grade.quality},{grade.satellites:02d},{grade.hdop:.1f},"
        f"{altitude_m:.3f},M,{_GEOID_M:.1f},M,{correction}"
    )


def _place(lat_deg: float, lon_deg: float) -> str:
    latitude, longitude = degrees_minutes(lat_deg, 2), degrees_minutes(lon_deg, 3)
    return f"{latitude},{'N' if lat_deg >= 0.0 else 'S'},{longitude},{'E' if lon_deg >= 0.0 else 'W'}"


def _rmc(sample: GnssSample, clock: str, date: str) -> str:
    """The RMC sentence. `date`: dd,mm,yyyy, as in ZDA."""
    day, month, year = date.split(",")
    if sample.position is None:
        return f"GNRMC,{clock},V,,,,,,,{day}{month}{year[2:]},,,N"
    speed_kn, course_deg = _over_ground(sample)
    place, mode = _place(sample.position[0], sample.position[1]), _MODES[sample.grade.quality]
    return f"GNRMC,{clock},A,{place},{speed_kn:.3f},{course_deg:.2f},{day}{month}{year[2:]},,,{mode}"


def _over_ground(sample: GnssSample) -> tuple[float, float]:
    """(speed in knots, course in degrees)."""
    speed_mps = math.hypot(sample.north_mps, sample.east_mps)
    return speed_mps * KNOTS_PER_MPS, math.degrees(math.atan2(sample.east_mps, sample.north_mps)) % 360.0


def degrees_minutes(angle_deg: float, digits: int) -> str:
    """(d)ddmm.mmmmmmm, rounded to 1e-7 minutes, 0.2 mm."""
    degrees, minutes = divmod(round(abs(angle_deg) * 600_000_000.0), 600_000_000)
    return f"{degrees:0{digits}d}{minutes // 10_000_000:02d}.{minutes % 10_000_000:07d}"


def _vtg(sample: GnssSample) -> str:
    if sample.position is None:
        return "GNVTG,,T,,M,,N,,K,N"
    speed_kn, course_deg = _over_ground(sample)
    speed_kmph, mode = speed_kn / KNOTS_PER_MPS * 3.6, _MODES[sample.grade.quality]
    return f"GNVTG,{course_deg:.2f},T,,M,{speed_kn:.3f},N,{speed_kmph:.3f},K,{mode}"
