"""The accelerometers do not feel gravity: its size is wrong, or it comes from above. Then the whole sensor is mounted
upside down, and its gyro turns the other way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.readings import Imu
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, Sense

_GRAVITY_MPS2 = 9.81
_TIME_S = 2.0  # over which waves and slamming average out
_SHARE = 0.15  # of gravity, by which the mean may be off
_LEAST_S = 2.0
_GAP_S = 0.5


@dataclass(slots=True)
class _Sensor:
    """Means of the length of the force and of the force downwards, since when, and until when."""

    length: float
    down: float
    from_s: float
    t_s: float


class ImuGravity(Hypothesis):
    """Remembers the mean force of each sensor."""

    def __init__(self) -> None:
        self._sensors: dict[str, _Sensor] = {}

    def clear(self) -> None:
        """Begin the means anew."""
        self._sensors.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sensors whose mean force is not gravity, or points up."""
        self.doubt = 0.0
        for imu in evidence.imu:
            self._take(imu, math.hypot(evidence.north_mps, evidence.east_mps))
        if not evidence.driven:
            return ()
        found = []
        for source, sensor in self._sensors.items():
            if now_s - sensor.from_s < _LEAST_S:
                continue
            wrong = abs(sensor.length - _GRAVITY_MPS2) / (_SHARE * _GRAVITY_MPS2)
            upside_down = 0.0 if sensor.down < 0.0 else 1.0
            self.doubt = max(self.doubt, wrong, upside_down)
            if max(wrong, upside_down) >= 1.0:
                sense, fault = Sense.IMU, "is upside down"
                if wrong >= 1.0:
                    sense, fault = Sense.ACCELEROMETER, "force is not gravity"
                found.append(LieFound(Channel(sense, source), fault, now_s - _TIME_S))
        return found

    def _take(self, imu: Imu, speed_mps: float) -> None:
        length = _without_turn(imu, speed_mps)
        sensor = self._sensors.get(imu.source)
        if sensor is None or imu.t_s - sensor.t_s > _GAP_S:
            self._sensors[imu.source] = _Sensor(length, imu.z_mps2, imu.t_s, imu.t_s)
            return
        share = min(max(imu.t_s - sensor.t_s, 0.0) / _TIME_S, 1.0)
        sensor.t_s = imu.t_s
        sensor.length += share * (length - sensor.length)
        sensor.down += share * (imu.z_mps2 - sensor.down)


def _without_turn(imu: Imu, speed_mps: float) -> float:
    """The size of the force in m/s², less what a turn at that speed may add to gravity."""
    length = math.sqrt(imu.x_mps2 * imu.x_mps2 + imu.y_mps2 * imu.y_mps2 + imu.z_mps2 * imu.z_mps2)
    added = math.hypot(_GRAVITY_MPS2, speed_mps * imu.yaw_rate_radps) - _GRAVITY_MPS2
    return length if length <= _GRAVITY_MPS2 else max(_GRAVITY_MPS2, length - added)
