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
from companion.nav.lever_arms import ZERO, Vector, centripetal_mps2, cross

_LIMITS = (0.6,) * 3 + (math.radians(1.5),) * 3  # biases of calibrated units, and what their places leave
_TIME_S = 0.5
_LASTS_S = 0.5
_FRESH_S = 0.3
_FEWEST = 3


@dataclass(slots=True)
class _Mean:
    """Of one sensor: low-passed samples, until when, where it sits, the angular acceleration (low-passed alike), since
    when one axis is apart."""

    t_s: float
    values: list[float]
    lever_m: Vector
    angular_radps2: Vector = ZERO
    apart_s: float = math.inf

    def at_the_origin(self, angular_radps2: Vector) -> tuple[float, ...]:
        """The samples without what that angular acceleration adds at the sensor's place."""
        if self.lever_m == ZERO:
            return tuple(self.values)
        x, y, z = cross(angular_radps2, self.lever_m)
        return self.values[0] - x, self.values[1] - y, self.values[2] - z, *self.values[3:]


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
            self._means[imu.source] = _Mean(imu.t_s, list(values), lever_m)
            return
        share = min(max(imu.t_s - mean.t_s, 0.0) / _TIME_S, 1.0)
        mean.t_s = imu.t_s
        # what a low-pass lacks is its time times the slope of what it takes, low-passed alike
        p, q, r = ((new - old) / _TIME_S for old, new in zip(mean.values[3:], values[3:], strict=True))
        mean.angular_radps2 = p, q, r
        mean.values = [old + share * (new - old) for old, new in zip(mean.values, values, strict=True)]

    def _compare(self, live: dict[str, _Mean], now_s: float) -> None:
        p, q, r = (median(axis) for axis in zip(*(mean.angular_radps2 for mean in live.values()), strict=True))
        felt = {name: mean.at_the_origin((p, q, r)) for name, mean in live.items()}
        middle = [median(axis) for axis in zip(*felt.values(), strict=True)]
        for name, mean in live.items():
            shares = [abs(v - m) / limit for v, m, limit in zip(felt[name], middle, _LIMITS, strict=True)]
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
