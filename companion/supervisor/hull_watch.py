"""Watches the hull: heel, thrust that makes no way, water that becomes too shallow."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.readings import Depth
from companion.params.store import Parameters
from companion.supervisor.way_watch import WayWatch

_BLIND_S = 1.0  # without an inertial sensor nobody knows that the boat is upright again
_LEVELS = ("IMU", "accelerometer")  # senses without which the estimate takes the boat to be level
_TILTED_S = 0.3  # a wave that slaps the hull is shorter
_BACK_SHARE = 0.7  # of FS_TILT_ANG, below which the boat is upright again
_SHALLOW_S = 1.0  # for that long, and by two readings, before it counts: fish and bubbles
_ALONE_S = 2.0  # a shallow reading after which none came for that long counts, too: there the sounder finds no bottom
_DEPTH_AGE_S = 5.0
_DEEPER_SHARE = 1.2  # of FS_DEPTH_MIN, from which on it is deep enough again


class HullWatch:
    """`update(…)` once a tick; then `tilt_rad`, `aground_or_fouled` and `depth_m` say what is wrong.

    Heel: roll and pitch together, from the vertical; it lasts until an inertial sensor says that the boat is upright.
    Way: as `WayWatch`. Depth: too shallow lasts until a sounder measures more. Remembers for how long each has lasted.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters, self._way = parameters, WayWatch(config, parameters)
        self.tilt_rad: float | None = None  # while the boat is capsized
        self.depth_m: float | None = None  # while it is too shallow
        self._tilted_s: float | None = None
        self._shallow_s: float | None = None
        self._first_s = -math.inf  # of the first shallow reading

    @property
    def aground_or_fouled(self) -> bool:
        """Thrust makes no way."""
        return self._way.in_vain

    def update(
        self, nav: NavState, depth: Depth | None, desired_mps: float | None, surge_n: float, now_s: float
    ) -> None:
        """`desired_mps`: speed ahead that the mode asks for, 0 where thrust is neutral or sticks steer, None where it
        asks for forces; `surge_n`: the force that the thrusters give."""
        self._see_tilt(nav, now_s)
        self._way.update(nav, desired_mps, surge_n, now_s)
        self._see_depth(depth, now_s)

    def _see_tilt(self, nav: NavState, now_s: float) -> None:
        limit_rad = math.radians(self._parameters["FS_TILT_ANG"])
        cosine = math.cos(nav.roll_rad) * math.cos(nav.pitch_rad)
        tilt_rad = math.acos(min(1.0, max(-1.0, cosine)))
        blind = nav.imu_age_s > _BLIND_S or any(one.sense in _LEVELS and one.excluded for one in nav.distrusted)
        limit_now_rad = limit_rad if self.tilt_rad is None else _BACK_SHARE * limit_rad
        if limit_rad == 0.0 or (tilt_rad < limit_now_rad and not (blind and self.tilt_rad is not None)):
            self._tilted_s = self.tilt_rad = None
            return
        self._tilted_s = now_s if self._tilted_s is None else self._tilted_s
        if now_s - self._tilted_s >= _TILTED_S and not blind:
            self.tilt_rad = tilt_rad

    def _see_depth(self, depth: Depth | None, now_s: float) -> None:
        least_m = self._parameters["FS_DEPTH_MIN"]
        if least_m == 0.0:
            self._shallow_s = self.depth_m = None
            return
        if depth is None or now_s - depth.t_s > _DEPTH_AGE_S:  # in very shallow water sounders find no bottom
            self._shallow_s = None
            return
        limit_m = least_m if self.depth_m is None else _DEEPER_SHARE * least_m
        if depth.below_transducer_m >= limit_m:
            self._shallow_s = self.depth_m = None
            return
        if self._shallow_s is None:
            self._shallow_s, self._first_s = now_s, depth.t_s
        lasted_s = now_s - self._shallow_s
        if lasted_s >= (_SHALLOW_S if depth.t_s > self._first_s else _ALONE_S):
            self.depth_m = depth.below_transducer_m
