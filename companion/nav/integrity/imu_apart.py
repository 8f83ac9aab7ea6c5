"""One inertial sensor of three or more is not as the others are.

Two tell the same: the third lies, whatever it does. Of two sensors alone neither is right by this; other hypotheses ask
receivers and the hull model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from companion.core.readings import Imu
from companion.nav.integrity.evidence import (
    IMU_AXES,
    Channel,
    Evidence,
    Hypothesis,
    LieFound,
    Sense,
    sense_of_axis,
)
from companion.nav.lever_arms import ZERO, Vector, centripetal_mps2

_LIMITS = (0.6,) * 3 + (math.radians(1.5),) * 3  # biases of calibrated units, and their places in a boat that rolls
_TIME_S = 0.5
_LASTS_S = 0.5
_FRESH_S = 0.3
_FEWEST = 3


@dataclass(slots=True)
class _Mean:
    """Of one sensor: low-passed samples, until when, since when one axis is apart."""

    t_s: float
    values: list[float]
    apart_s: float = math.inf


class ImuApart(Hypothesis):
    """Remembers the mean of each sensor, and those found."""

    def __init__(self) -> None:
        self._means: dict[str, _Mean] = {}
        self._found: dict[str, LieFound] = {}

    def clear(self) -> None:
        """Begin anew."""
        self._means.clear()
        self._found.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sensors that are not as two others."""
        self.doubt = 1.0 if self._found else 0.0
        if len({imu.source for imu in evidence.imu} | self._means.keys()) < _FEWEST:
            return ()
        for imu in evidence.imu:
            self._take(imu, evidence.levers_m.get(imu.source, ZERO))
        live = {
            name: mean
            for name, mean in self._means.items()
            if now_s - mean.t_s <= _FRESH_S and name not in self._found and not _distrusted(evidence, name)
        }
        if evidence.driven and len(live) >= _FEWEST:
            self._compare(live, now_s)
        return tuple(self._found.values())

    def _take(self, imu: Imu, lever_m: Vector) -> None:
        mean, values = self._means.get(imu.source), _values(imu, lever_m)
        if mean is None or imu.t_s - mean.t_s > _FRESH_S:
            self._means[imu.source] = _Mean(imu.t_s, list(values))
            return
        share = min(max(imu.t_s - mean.t_s, 0.0) / _TIME_S, 1.0)
        mean.t_s = imu.t_s
        mean.values = [old + share * (new - old) for old, new in zip(mean.values, values, strict=True)]

    def _compare(self, live: dict[str, _Mean], now_s: float) -> None:
        middle = [median(axis) for axis in zip(*(mean.values for mean in live.values()), strict=True)]
        for name, mean in live.items():
            shares = [abs(v - m) / limit for v, m, limit in zip(mean.values, middle, _LIMITS, strict=True)]
            worst = max(range(len(IMU_AXES)), key=shares.__getitem__)
            if shares[worst] < 1.0:
                mean.apart_s = math.inf
                continue
            mean.apart_s = min(mean.apart_s, now_s)
            self.doubt = max(self.doubt, min((now_s - mean.apart_s) / _LASTS_S, 1.0))
            if now_s - mean.apart_s >= _LASTS_S:
                channel = Channel(sense_of_axis(IMU_AXES[worst]), name)
                self._found[name] = LieFound(channel, "is not as the others", mean.apart_s - _TIME_S, lasting=True)


def _distrusted(evidence: Evidence, name: str) -> bool:
    return any(Channel(sense, name) in evidence.distrusted for sense in (Sense.IMU, Sense.ACCELEROMETER, Sense.GYRO))


def _values(imu: Imu, lever_m: Vector) -> tuple[float, ...]:
    """Of the boat's origin, as far as a turn goes."""
    rates = imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps
    if lever_m == ZERO:
        return imu.x_mps2, imu.y_mps2, imu.z_mps2, *rates
    x, y, z = centripetal_mps2(rates, lever_m)
    return imu.x_mps2 - x, imu.y_mps2 - y, imu.z_mps2 - z, *rates
