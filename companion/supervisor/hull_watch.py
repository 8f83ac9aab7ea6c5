"""Watches the hull: heel, thrust that makes no way, water that becomes too shallow."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.readings import Depth
from companion.params.store import Parameters

_BLIND_S = 1.0  # without an inertial sensor nobody knows that the boat is upright again
_LEVELS = ("IMU", "accelerometer")  # senses without which the estimate takes the boat to be level
_TILTED_S = 0.3  # a wave that slaps the hull is shorter
_BACK_SHARE = 0.7  # of FS_TILT_ANG, below which the boat is upright again
_AT_REST_MPS = 0.15  # a boat that moves faster over ground is not aground: the current may be to blame while unknown
_LEAST_MPS = 0.1  # desired speed below which no way need be made
_TURNS_RADPS = math.radians(5.0)  # a boat that turns faster is neither aground nor without propeller
_PUSH_SHARE = 0.2  # of the largest surge force: less is no push
_MADE_SHARE = 0.5  # of the desired speed that counts as way
_NEEDED_SHARE = 0.5  # of the thrust that the hull may need at its speed and FS_WAY_DRIFT, for thrust to be in vain
_STREAM_GROWS_MPS2 = 0.01  # a current estimated to grow faster while no way is made is thrust that the ground takes
_LONGEST_STEP_S = 0.5
_SHALLOW_S = 1.0
_DEPTH_AGE_S = 5.0
_DEEPER_SHARE = 1.2  # of FS_DEPTH_MIN, from which on it is deep enough again


class HullWatch:
    """`update(…)` once a tick; then `tilt_rad`, `aground_or_fouled` and `depth_m` say what is wrong.

    Heel: roll and pitch together, from the vertical; it lasts until an inertial sensor says that the boat is upright.
    Way: the boat should go ahead and pushes with at least twice the force that its hull would need at its speed over
    ground in a stream of FS_WAY_DRIFT, or in the estimated current where that is stronger, and makes less than half of
    the desired speed, for FS_WAY_T in all, and does not turn; pauses count against it. Meanwhile the current counts as
    growing slowly: the estimate of a boat held fast has a current that balances its thrust. It has made way again at
    half of the desired speed, and of the speed that was desired in vain: Hold desires little. Remembers that speed, the
    current, and for how long each has lasted.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull, self._most_n, self._parameters = config.hull, config.limits.surge_n, parameters
        self.tilt_rad: float | None = None  # while the boat is capsized
        self.aground_or_fouled = False
        self.depth_m: float | None = None  # while it is too shallow
        self._tilted_s: float | None = None
        self._vain_s = self._seen_s = self._stream_mps = 0.0
        self._vain_mps = 0.0  # desired in vain, for the last time
        self._shallow_s: float | None = None

    def update(self, nav: NavState, depth: Depth | None, desired_mps: float, surge_n: float, now_s: float) -> None:
        """`desired_mps`: speed ahead that the mode asks for, 0 where thrust is neutral or sticks steer; `surge_n`: the
        force that the thrusters give."""
        self._see_tilt(nav, now_s)
        self._see_way(nav, desired_mps, surge_n, now_s)
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

    def _see_way(self, nav: NavState, desired_mps: float, surge_n: float, now_s: float) -> None:
        asked = desired_mps >= _LEAST_MPS and nav.position_valid
        made = nav.surge_mps >= _MADE_SHARE * desired_mps
        if asked and nav.surge_mps >= _MADE_SHARE * max(desired_mps, self._vain_mps):
            self.aground_or_fouled = False
        dt_s = min(_LONGEST_STEP_S, max(0.0, now_s - self._seen_s))
        self._seen_s = now_s
        stream_mps = math.hypot(nav.current_north_mps or 0.0, nav.current_east_mps or 0.0)
        if asked and not made:
            stream_mps = min(stream_mps, self._stream_mps + _STREAM_GROWS_MPS2 * dt_s)
        self._stream_mps = stream_mps
        drift_mps = max(self._parameters["FS_WAY_DRIFT"], self._stream_mps)
        needed_n = self._hull.drag_n(max(0.0, nav.surge_mps) + drift_mps)
        in_vain = surge_n >= _PUSH_SHARE * self._most_n and _NEEDED_SHARE * surge_n > needed_n
        known = nav.current_north_mps is not None or math.hypot(nav.north_mps, nav.east_mps) < _AT_REST_MPS
        in_vain = in_vain and known and asked and not made and abs(nav.yaw_rate_radps) < _TURNS_RADPS
        self._vain_s = 0.0 if asked and made else max(0.0, self._vain_s + (dt_s if in_vain else -dt_s))
        if self._vain_s >= self._parameters["FS_WAY_T"]:
            self.aground_or_fouled, self._vain_s, self._vain_mps = True, 0.0, desired_mps

    def _see_depth(self, depth: Depth | None, now_s: float) -> None:
        least_m = self._parameters["FS_DEPTH_MIN"]
        if least_m == 0.0 or depth is None or now_s - depth.t_s > _DEPTH_AGE_S:
            self._shallow_s = self.depth_m = None
            return
        limit_m = least_m if self.depth_m is None else _DEEPER_SHARE * least_m
        if depth.below_transducer_m >= limit_m:
            self._shallow_s = self.depth_m = None
            return
        self._shallow_s = now_s if self._shallow_s is None else self._shallow_s
        if now_s - self._shallow_s >= _SHALLOW_S:
            self.depth_m = depth.below_transducer_m
