"""How wrong the measurements of each sensor may be, by what they claim and by the vessel's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from companion.config.devices import SensorConfig
from companion.core.readings import FixType, GnssFix, GroundVelocity
from companion.nav.error_state import FilterNoise

_UNKNOWN_M, _UNKNOWN_MPS = 3.0, 0.1
_CORRELATED_FACTOR = 3.0  # errors of fixes without carrier phase are correlated: each counts as that much noisier
_CORRELATED_SHARE = 0.7  # the share of their sigma that averaging does not remove
_CARRIER_WANDER_M = 0.008  # slow error of fixes with carrier phase
_VELOCITY_SHARES: Mapping[FixType, float] = {  # of the velocity error of a plain fix
    FixType.DGPS: 0.5,
    FixType.RTK_FLOAT: 0.3,
    FixType.RTK_FIXED: 0.3,
}


class SensorAccuracies:
    """One sigma of each measurement, on each axis."""

    def __init__(self, sensors: Sequence[SensorConfig]) -> None:
        self._sensors = {row.name: row for row in sensors}

    def position_m(self, fix: GnssFix) -> float:
        """As the receiver claims, m."""
        row = self._sensors.get(fix.source)
        return max(fix.position_accuracy_m or _UNKNOWN_M, row.accuracy_floor_m if row is not None else 0.0)

    def fused_m(self, fix: GnssFix, sigma_m: float) -> float:
        """As the filter should take a fix of `sigma_m`, m."""
        return sigma_m if fix.fix >= FixType.RTK_FLOAT else _CORRELATED_FACTOR * sigma_m

    def slow_m(self, fix: GnssFix, sigma_m: float) -> float:
        """Of the receiver's slow error, m."""
        row = self._sensors.get(fix.source)
        if row is not None and row.position_wander_m is not None:
            return row.position_wander_m
        return _CARRIER_WANDER_M if fix.fix >= FixType.RTK_FLOAT else _CORRELATED_SHARE * sigma_m

    def velocity_mps(self, velocity: GroundVelocity, fix: FixType | None) -> float:
        """Of a velocity, m/s. `fix`: of its receiver; None: none came yet."""
        row = self._sensors.get(velocity.source)
        sigma_mps = row.velocity_accuracy_mps if row is not None else _UNKNOWN_MPS
        return sigma_mps if fix is None else sigma_mps * _VELOCITY_SHARES.get(fix, 1.0)

    def imu(self, source: str) -> FilterNoise:
        """Of an inertial sensor."""
        row = self._sensors.get(source)
        if row is None:
            return FilterNoise()
        return FilterNoise(row.accelerometer_noise_mps2_rthz, row.gyro_noise_radps_rthz)
