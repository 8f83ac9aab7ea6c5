"""How wrong the measurements of each sensor may be, by what they claim and by the vessel's file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from companion.config.devices import FixErrors, SensorConfig
from companion.config.sensors import is_averaging
from companion.core.readings import FixType, GnssFix, GroundVelocity
from companion.nav.error_state import FilterNoise
from companion.nav.measured_off import Wander

_UNKNOWN_M, _UNKNOWN_MPS = 3.0, 0.1
_CORRELATED_FACTOR = 3.0  # without an inertial sensor nothing tells slow errors from noise: a fix counts as noisier
NOISE_SHARE, _WANDER_SHARE = 0.3, 0.7  # of the sigma of a fix whose ambiguities are not fixed
_CARRIER_WANDER_M = 0.008  # slow error of fixes with carrier phase
_WANDER_S, _CARRIER_WANDER_S = 300.0, 100.0  # time constants: of code multipath and ionosphere, of carrier multipath
_LASTS_S = 0.5  # an error of velocity without carrier phase: receivers smooth over about that time
_VELOCITY_SHARES: Mapping[FixType, float] = {  # of the velocity error of a plain fix
    FixType.DGPS: 0.5,
    FixType.RTK_FLOAT: 0.3,
    FixType.RTK_FIXED: 0.3,
}
_NOTHING_TOLD = FixErrors()
_FOLDS_HZ = 50.0  # newest values that come less often hold the noise of the band above as well


class SensorAccuracies:
    """One sigma of each measurement, on each axis.

    The error of a fix is noise and a slow part, a first-order Gauss–Markov process. Published time constants: 10 to 900
    s of multipath, 5 to 20 min of differences between receivers with carrier phase (Joerger & Pervan 2020; Howind et
    al. 1999), 300 s and more of ionosphere and orbits.
    """

    def __init__(self, sensors: Sequence[SensorConfig]) -> None:
        self._sensors = {row.name: row for row in sensors}
        self._plain = {
            row.name: FixErrors(row.position_noise_m, row.position_wander_m, row.position_wander_s) for row in sensors
        }

    def position_m(self, fix: GnssFix) -> float:
        """As the receiver claims, m."""
        row = self._sensors.get(fix.source)
        return max(fix.position_accuracy_m or _UNKNOWN_M, row.accuracy_floor_m if row is not None else 0.0)

    def fused_m(self, fix: GnssFix, sigma_m: float) -> float:
        """As a filter without an inertial sensor should take a fix of `sigma_m`, m."""
        return sigma_m if fix.fix >= FixType.RTK_FLOAT else _CORRELATED_FACTOR * sigma_m

    def noise_m(self, fix: GnssFix, sigma_m: float, share: float = NOISE_SHARE) -> float:
        """Of the noise of a fix of `sigma_m`, which averaging removes, m. `share`: of it, where nothing else is told of
        a fix whose ambiguities are not fixed."""
        row, told_m = self._sensors.get(fix.source), self._told(fix.source, fix.fix).noise_m
        if told_m is not None:
            return told_m
        if fix.fix is FixType.RTK_FIXED:
            return sigma_m
        return max(share * sigma_m, row.accuracy_floor_m if row is not None else 0.0)

    def slow_m(self, fix: GnssFix, sigma_m: float) -> float:
        """Of the receiver's slow error, m."""
        told_m = self._told(fix.source, fix.fix).wander_m
        if told_m is not None:
            return told_m
        return _CARRIER_WANDER_M if fix.fix is FixType.RTK_FIXED else _WANDER_SHARE * sigma_m

    def wander(self, fix: GnssFix, slow_m: float) -> Wander:
        """The slow error of that size, with its time constant."""
        told_s = self._told(fix.source, fix.fix).wander_s
        default_s = _CARRIER_WANDER_S if fix.fix >= FixType.RTK_FLOAT else _WANDER_S
        return Wander(slow_m, default_s if told_s is None else told_s)

    def latency_s(self, source: str) -> float:
        """Of how late a receiver is beyond what its row says, s."""
        row = self._sensors.get(source)
        return 0.0 if row is None else row.latency_accuracy_s

    def walk_mps_rthz(self, velocity: GroundVelocity, fix: FixType | None, sigma_mps: float) -> float:
        """The random walk of a position that measured velocities of `sigma_mps` carry on, beside that of their noise.
        `fix`: of their receiver."""
        row = self._sensors.get(velocity.source)
        lasts_s = None if row is None else row.velocity_lasts_s
        if lasts_s is None:
            lasts_s = 0.0 if fix is not None and fix >= FixType.RTK_FLOAT else _LASTS_S
        return sigma_mps * math.sqrt(2.0 * lasts_s)

    def velocity_mps(self, velocity: GroundVelocity, fix: FixType | None) -> float:
        """Of a velocity, m/s. `fix`: of its receiver; None: none came yet."""
        row = self._sensors.get(velocity.source)
        told_mps = None if fix is None else self._told(velocity.source, fix).velocity_mps
        if told_mps is not None:
            return told_mps
        sigma_mps = row.velocity_accuracy_mps if row is not None else _UNKNOWN_MPS
        return sigma_mps if fix is None else sigma_mps * _VELOCITY_SHARES.get(fix, 1.0)

    def imu(self, source: str) -> FilterNoise:
        """Of an inertial sensor. The densities of its row hold where it integrates: newest values that come seldom
        have the noise of the whole band in theirs (aliasing)."""
        row = self._sensors.get(source)
        if row is None:
            return FilterNoise()
        folded = 1.0 if is_averaging(row) else math.sqrt(max(_FOLDS_HZ / row.rate_hz, 1.0))
        noise = FilterNoise(folded * row.accelerometer_noise_mps2_rthz, folded * row.gyro_noise_radps_rthz)
        if (told_mps2 := row.accelerometer_bias_mps2) is not None:
            noise = replace(noise, accelerometer_switch_on_mps2=told_mps2, accelerometer_bias_mps2=told_mps2)
        if (told_radps := row.gyro_bias_radps) is not None:
            noise = replace(noise, gyro_switch_on_radps=told_radps, gyro_bias_radps=told_radps)
        if row.bias_s is not None:
            noise = replace(noise, accelerometer_bias_time_s=row.bias_s, gyro_bias_time_s=row.bias_s)
        return noise

    def _told(self, source: str, fix: FixType) -> FixErrors:
        """What the file tells of that kind of fix. What it tells of plain fixes says nothing of fixes with carrier
        phase, nor the other way round."""
        if fix < FixType.RTK_FLOAT:
            return self._plain.get(source, _NOTHING_TOLD)
        row = self._sensors.get(source)
        told = None if row is None else row.rtk_fixed if fix is FixType.RTK_FIXED else row.rtk_float
        return told or _NOTHING_TOLD
