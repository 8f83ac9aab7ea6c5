"""The lead boat: whose messages count, and where it is now."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from companion.core.types import Leader, LeaderState
from companion.params import Parameters

_SLOW_MPS = 0.5  # below this the course tells no heading
_COUNTER_MOST = 40
_FORGET_S = 30.0
_SIGMA_M = 3.0  # of a leader that does not say how good its position is


class LeaderTracker:
    """`take(state, frame)` each message, `leader(frame, now_s)` → Leader, or None while none has been heard.

    One leader counts: the system in FOLL_SYSID, or the first one heard until it has been silent for 30 s. Remembers its last position and motion.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._state: LeaderState | None = None
        self._fixed: LeaderState | None = None  # the last one with a position
        self._interval_s = 0.0
        self._counter = 0
        self._yaw_rad: float | None = None

    def take(self, state: LeaderState) -> bool:
        """One message. Those of others than the leader, and those that are older than what is known, are left out; True where it is the leader's."""
        chosen = int(self._parameters["FOLL_SYSID"])
        before = self._state
        if chosen and state.system_id != chosen:
            return False
        if before is not None and state.system_id != before.system_id and not chosen and state.heard_s - before.heard_s < _FORGET_S:
            return False
        if before is not None and state.system_id != before.system_id:
            self._fixed = self._yaw_rad = None
            self._counter = 0
        self._state = state
        self._counter = min(_COUNTER_MOST, max(0, self._counter - 1 + state.lost))
        if state.lat_deg is None or (self._fixed is not None and state.t_s <= self._fixed.t_s):
            return True
        if self._fixed is not None:
            self._interval_s = state.t_s - self._fixed.t_s
        self._fixed = state
        if state.yaw_rad is not None:
            self._yaw_rad = state.yaw_rad
        elif state.north_mps is not None and state.east_mps is not None and math.hypot(state.north_mps, state.east_mps) > _SLOW_MPS:
            self._yaw_rad = math.atan2(state.east_mps, state.north_mps)
        return True

    def leader(self, frame: LocalFrame, now_s: float) -> Leader | None:
        """Where it is now, dead-reckoned from its last position."""
        state, fixed = self._state, self._fixed
        if state is None or fixed is None or fixed.lat_deg is None or fixed.lon_deg is None:
            return None
        north_m, east_m = frame.to_ned(fixed.lat_deg, fixed.lon_deg)
        north_mps, east_mps = fixed.north_mps or 0.0, fixed.east_mps or 0.0
        age_s = max(0.0, now_s - fixed.t_s)
        rate = fixed.yaw_rate_radps or 0.0
        yaw = None if self._yaw_rad is None else wrap_pi(self._yaw_rad + rate * age_s)
        sigma_m = _SIGMA_M if fixed.accuracy_m is None else fixed.accuracy_m
        return Leader(
            state.system_id, north_m + north_mps * age_s, east_m + east_mps * age_s, north_mps, east_mps, yaw, rate, sigma_m, age_s,
            self._interval_s, state.wish, self._counter,
        )  # fmt: skip
