"""What a lying sensor reports, from what it measures. The lies are faults of the run: `lie_table.py` lists them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from companion.config.vessel import HomeConfig
from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.faults import Fault, Faults
from sitl.lie_table import IMU_AXES
from sitl.noise import stream
from sitl.sensors import GnssSample, ImuSample

_SQRT_HALF = math.sqrt(0.5)
_ALL = ("position", "north_mps", "east_mps", "heading_rad")
_RATES = 3  # index of the first angular rate in a sample


class GnssLies:
    """A receiver's solutions, as measured → as told. Remembers the last one before it froze, the time that it bears,
    and its place in the noise."""

    def __init__(self, faults: Faults, name: str, home: HomeConfig, seed: int) -> None:
        self._faults, self._name = faults, name
        self._frame = LocalFrame(home.lat_deg, home.lon_deg)
        self._gauss = stream(seed, f"{name} lies").gauss
        self._last: GnssSample | None = None
        self._off_s = self._told_s = 0.0
        self._told: Mapping[str, Callable[[GnssSample, float, float], GnssSample]] = {
            "gnss_jump": lambda sample, size, age_s: self._moved(sample, size, 0.0),
            "position_creep": lambda sample, size, age_s: self._moved(sample, size * age_s, 0.0),
            "gnss_spoof": lambda sample, size, age_s: self._moved(sample, size * age_s, size),
            "gnss_pull": lambda sample, size, age_s: self._moved(sample, 0.5 * size * age_s * age_s, size * age_s),
            "velocity_off": lambda sample, size, age_s: self._moved(sample, 0.0, size),
            "gnss_mirrored": lambda sample, size, age_s: _mirrored(sample),
            "altitude_off": lambda sample, size, age_s: _raised(sample, size),
            "accuracy_lie": lambda sample, size, age_s: self._noisy(sample, size),
            "heading_turned": lambda sample, size, age_s: _turned(sample, math.radians(size)),
            "heading_creep": lambda sample, size, age_s: _turned(sample, math.radians(size * age_s)),
            "heading_noise": lambda sample, size, age_s: _turned(sample, self._gauss(0.0, math.radians(size))),
        }
        self._repeated: Mapping[str, tuple[str, ...]] = {
            "gnss_frozen": _ALL,
            "gnss_stale": _ALL,
            "position_frozen": ("position",),
            "velocity_frozen": ("north_mps", "east_mps"),
            "heading_frozen": ("heading_rad",),
        }

    def told(self, sample: GnssSample, t_s: float) -> GnssSample:
        """The solution that the receiver reports at `t_s`."""
        lies = self._faults.lies(self._name)
        for lie in lies:
            if lie.name in self._told:
                sample = self._told[lie.name](sample, lie.size or 0.0, t_s - lie.start_s)
        last = self._last
        for lie in lies:
            if lie.name in self._repeated and last is not None:
                sample = replace(sample, **{field: getattr(last, field) for field in self._repeated[lie.name]})
        self._last = sample
        return sample

    def time_off_s(self, t_s: float) -> float:
        """How far the absolute time that it reports at `t_s` is ahead."""
        off_s = 0.0
        for lie in self._faults.lies(self._name):
            if lie.name == "gnss_stale":
                return self._off_s - (t_s - self._told_s)
            if lie.name == "time_jump":
                off_s += lie.size or 0.0
            elif lie.name == "time_fast":
                off_s += (lie.size or 0.0) * (t_s - lie.start_s)
        self._off_s, self._told_s = off_s, t_s
        return off_s

    def _moved(self, sample: GnssSample, distance_m: float, speed_mps: float) -> GnssSample:
        """Position and velocity moved to the north-east."""
        more_m, more_mps = _SQRT_HALF * distance_m, _SQRT_HALF * speed_mps
        return self._placed(
            replace(sample, north_mps=sample.north_mps + more_mps, east_mps=sample.east_mps + more_mps), more_m, more_m
        )

    def _noisy(self, sample: GnssSample, sigma_m: float) -> GnssSample:
        return self._placed(sample, self._gauss(0.0, sigma_m), self._gauss(0.0, sigma_m))

    def _placed(self, sample: GnssSample, north_m: float, east_m: float) -> GnssSample:
        if sample.position is None:
            return sample
        lat_deg, lon_deg, altitude_m = sample.position
        north, east = self._frame.to_ned(lat_deg, lon_deg)
        return replace(sample, position=(*self._frame.to_geodetic(north + north_m, east + east_m), altitude_m))


def _turned(sample: GnssSample, angle_rad: float) -> GnssSample:
    heading = sample.heading_rad
    return sample if heading is None else replace(sample, heading_rad=wrap_pi(heading + angle_rad))


def _mirrored(sample: GnssSample) -> GnssSample:
    if sample.position is None:
        return sample
    lat_deg, lon_deg, altitude_m = sample.position
    return replace(sample, position=(-lat_deg, lon_deg, altitude_m))


def _raised(sample: GnssSample, by_m: float) -> GnssSample:
    if sample.position is None:
        return sample
    lat_deg, lon_deg, altitude_m = sample.position
    return replace(sample, position=(lat_deg, lon_deg, altitude_m + by_m))


class HeadingLies:
    """The heading of a compass or an inertial sensor, as measured → as told. Remembers the last one, and its place in
    the noise."""

    def __init__(self, faults: Faults, name: str, seed: int = 0) -> None:
        self._faults, self._name = faults, name
        self._gauss = stream(seed, f"{name} heading lies").gauss
        self._last_rad: float | None = None

    def told(self, yaw_rad: float, t_s: float) -> float:
        """The heading that the sensor reports at `t_s`."""
        for lie in self._faults.lies(self._name):
            if lie.name == "heading_turned":
                yaw_rad = wrap_pi(yaw_rad + math.radians(lie.size or 0.0))
            elif lie.name == "heading_creep":
                yaw_rad = wrap_pi(yaw_rad + math.radians((lie.size or 0.0) * (t_s - lie.start_s)))
            elif lie.name == "heading_noise":
                yaw_rad = wrap_pi(yaw_rad + self._gauss(0.0, math.radians(lie.size or 0.0)))
            elif lie.name == "heading_frozen" and self._last_rad is not None:
                yaw_rad = self._last_rad
        self._last_rad = yaw_rad
        return yaw_rad


class ImuLies:
    """Samples of an inertial sensor, as measured → as told, and the order of their messages. Remembers the last one
    that was told, and a message that waits for the next one."""

    def __init__(self, faults: Faults, name: str, seed: int = 0) -> None:
        self._faults, self._name = faults, name
        self._heading = HeadingLies(faults, name, seed)
        self._last: ImuSample = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._begun = False
        self._waits: bytes | None = None

    def told(self, sample: ImuSample, t_s: float) -> ImuSample:
        """The sample that the sensor reports at `t_s`."""
        lies = self._faults.lies(self._name)
        if lies:
            sample = (*sample[:8], self._heading.told(sample[8], t_s))
            for lie in lies:
                sample = self._spoilt(sample, lie)
        self._last, self._begun = sample, True
        return sample

    def clock_off_s(self, t_s: float) -> float:
        """How far the sensor's own clock is ahead at `t_s`."""
        off_s = 0.0
        for lie in self._faults.lies(self._name):
            if lie.name == "imu_clock_jump":
                off_s += lie.size or 0.0
            elif lie.name == "imu_clock_fast":
                off_s += (lie.size or 0.0) * (t_s - lie.start_s)
        return off_s

    def sent(self, message: bytes) -> Sequence[bytes]:
        """The messages that are sent where that one is due, in their order."""
        names = {lie.name for lie in self._faults.lies(self._name)}
        before, self._waits = self._waits, None
        if "imu_doubled" in names:
            return message, message
        if "imu_swapped" in names and before is None:
            self._waits = message
            return ()
        return (message,) if before is None else (message, before)

    def _spoilt(self, sample: ImuSample, lie: Fault) -> ImuSample:
        last = self._last if self._begun else sample
        if lie.name == "imu_repeats":
            return last
        if lie.name == "imu_clipped":
            return _clipped(sample, lie.size or 0.0)
        _, _, rest = lie.name.partition("imu_")
        axis, _, kind = rest.partition("_")
        if axis not in IMU_AXES:
            return sample
        at = IMU_AXES.index(axis)
        size = lie.size or 0.0
        values = list(sample)
        if kind == "stuck":
            values[at] = last[at]
        elif kind == "reversed":
            values[at] = -values[at]
        elif kind == "scaled":
            values[at] *= size
        elif kind == "biased":
            values[at] += size if at < _RATES else math.radians(size)
        x, y, z, p, q, r, roll, pitch, yaw = values
        return x, y, z, p, q, r, roll, pitch, yaw


def _clipped(sample: ImuSample, most_mps2: float) -> ImuSample:
    x, y, z, *rest = sample
    p, q, r, roll, pitch, yaw = rest
    x, y, z = (max(-most_mps2, min(most_mps2, force)) for force in (x, y, z))
    return x, y, z, p, q, r, roll, pitch, yaw


class WindLies:
    """Winds as measured → as told. Remembers the last one."""

    def __init__(self, faults: Faults, name: str) -> None:
        self._faults, self._name = faults, name
        self._last: tuple[float, float] | None = None

    def told(self, speed_mps: float, angle_rad: float) -> tuple[float, float]:
        """(speed_mps, angle_rad) that the sensor reports."""
        lies = self._faults.lies(self._name)
        for lie in lies:
            if lie.name == "wind_scaled":
                speed_mps *= lie.size or 0.0
            elif lie.name == "wind_turned":
                angle_rad = wrap_pi(angle_rad + math.radians(lie.size or 0.0))
        frozen = any(lie.name == "wind_frozen" for lie in lies)
        if not frozen or self._last is None:
            self._last = speed_mps, angle_rad
        return self._last


class DepthLies:
    """Depths as measured → as told. Remembers the last one."""

    def __init__(self, faults: Faults, name: str) -> None:
        self._faults, self._name = faults, name
        self._last_m: float | None = None

    def told(self, depth_m: float) -> float:
        """The depth that the sounder reports."""
        lies = self._faults.lies(self._name)
        for lie in lies:
            if lie.name == "depth_scaled":
                depth_m *= lie.size or 0.0
        if self._last_m is None or all(lie.name != "depth_frozen" for lie in lies):
            self._last_m = depth_m
        return self._last_m
