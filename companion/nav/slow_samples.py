"""Samples of a slow inertial sensor (10 Hz, 20 Hz) → several short ones.

The filter takes a sample for the mean of the step that it ends, and a measurement for one of the newest sample's time.
With steps of 0.1 s neither holds: a boat that begins to turn by 0.4 rad/s seems to have turned by 1° more than it has,
and a fix is up to 0.1 s, 0.2 m of way, from the sample. In parts of some milliseconds both hold again.

What a sample says of its step depends on the device. One that integrates (an MTi: its accelerations and rates come from
its strapdown integration, by Movella's *MTi User Manual*, 4.9.3) gives the mean, which is the value in the middle: from
there they go on as from the middle before, and the sum of the parts is exact. One that sends its newest values
(HIGHRES_IMU, VNYMR) gives those of the end: between two samples they go along a straight line, which is the trapezoidal
rule.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

from companion.core.readings import Imu

_SLOW_S = 0.03  # between two samples; faster ones are short enough
_PART_S = 0.02  # longest part
_GAP_S = 0.3  # between two samples: nobody knows what was in between
_STEP_S = 0.01  # of the period: that it varies a little is no other period


class SlowSamples:
    """Call `parts` for each sample, in order of time. Remembers of each sensor the last sample and the last periods."""

    def __init__(self, averaging: Collection[str] = ()) -> None:
        """`averaging`: the sensors whose samples are means since the one before."""
        self._averaging = frozenset(averaging)
        self._last: dict[str, Imu] = {}
        self._periods_s: dict[str, tuple[float, float, float]] = {}

    def period_s(self, source: str) -> float:
        """The longest time between two of the last samples of a slow sensor, s; 0: it is none."""
        periods_s = self._periods_s.get(source)
        if periods_s is None or min(periods_s) < _SLOW_S:
            return 0.0
        return _STEP_S * math.ceil(max(periods_s) / _STEP_S - 0.1)

    def parts(self, imu: Imu) -> list[Imu]:
        """The sample, or what it says of each part of its step."""
        source, before = imu.source, self._last.get(imu.source)
        dt_s = 0.0 if before is None else imu.t_s - before.t_s
        if before is not None and dt_s <= 0.0:
            return [imu]
        self._last[source] = imu
        if before is None or dt_s > _GAP_S:
            return [imu]
        _, second, third = self._periods_s.get(source, (0.0, 0.0, 0.0))
        self._periods_s[source] = periods_s = second, third, dt_s
        if dt_s < _SLOW_S or min(periods_s) < _SLOW_S:
            return [imu]
        count = math.ceil(dt_s / _PART_S - 0.01)
        middle = 0.5 if source in self._averaging else 0.0
        return [_part(before, imu, k / count, middle + (k - 0.5) / count) for k in range(1, count + 1)]


def _part(before: Imu, imu: Imu, ends: float, share: float) -> Imu:
    """The part of a step that `ends` at that share of it, with the values at `share` of the way from one sample to the
    next, or beyond. The device's own attitude is that of its sample alone."""
    last = ends == 1.0
    return replace(
        imu,
        t_s=imu.t_s if last else before.t_s + ends * (imu.t_s - before.t_s),
        x_mps2=before.x_mps2 + share * (imu.x_mps2 - before.x_mps2),
        y_mps2=before.y_mps2 + share * (imu.y_mps2 - before.y_mps2),
        z_mps2=before.z_mps2 + share * (imu.z_mps2 - before.z_mps2),
        roll_rate_radps=before.roll_rate_radps + share * (imu.roll_rate_radps - before.roll_rate_radps),
        pitch_rate_radps=before.pitch_rate_radps + share * (imu.pitch_rate_radps - before.pitch_rate_radps),
        yaw_rate_radps=before.yaw_rate_radps + share * (imu.yaw_rate_radps - before.yaw_rate_radps),
        roll_rad=imu.roll_rad if last else None,
        pitch_rad=imu.pitch_rad if last else None,
        yaw_rad=imu.yaw_rad if last else None,
    )
