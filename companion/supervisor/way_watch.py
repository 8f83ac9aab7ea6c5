"""Watches that thrust makes way: a boat that pushes and stays where it is lies aground, or its propeller is fouled."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.params.store import Parameters

_AT_REST_MPS = 0.15  # a boat that moves faster over ground is not aground: the current may be to blame while unknown
_HELD_MPS = 0.05  # a boat that moves faster over ground is not held fast
_LEAST_MPS = 0.1  # desired speed below which no way need be made
# A boat that turns faster is neither aground nor without propeller: this, or a share of PATH_YAW_RATE if that is less.
_TURNS_RADPS, _TURNS_SHARE = math.radians(5.0), 0.5
_TURN_S = 3.0  # time constant of that turn: a boat that swings to and fro does not turn
_PUSH_SHARE = 0.2  # of the largest surge force: less is no push
_MADE_SHARE = 0.5  # of the desired speed that counts as way
_NEEDED_SHARE = 0.5  # of the thrust that the hull may need at its speed and FS_WAY_DRIFT, for thrust to be in vain
_STREAM_GROWS_MPS2 = 0.01  # a current estimated to grow faster while no way is made is thrust that the ground takes
_LONGEST_STEP_S = 0.5


class WayWatch:
    """`update(…)` once a tick; then `in_vain`.

    The boat should go ahead and pushes with at least twice the force that its hull would need at its speed over ground
    in a stream of FS_WAY_DRIFT, or in the estimated current where that is stronger, and makes less than half of the
    desired speed, for FS_WAY_T in all, and does not turn; pauses count against it. While the boat lies still, the
    current counts as growing slowly: the estimate of a boat held fast has a current that balances its thrust. It has
    made way again at half of the desired speed, and of the speed that was desired in vain: Hold desires little.

    A mode that asks for forces desires no speed. What the model would have reached stands for it, and the boat must lie
    still; it may push astern as well, and pauses between its pushes do not count.

    Remembers the speed desired in vain, the speed by the model, the current, the mean turn, and for how long thrust has
    been in vain.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull, self._most_n, self._parameters = config.hull, config.limits.surge_n, parameters
        self.in_vain = False
        self._vain_s = self._seen_s = self._stream_mps = self._model_mps = self._turn_radps = 0.0
        self._vain_mps = 0.0  # desired in vain, for the last time

    def update(self, nav: NavState, desired_mps: float | None, surge_n: float, now_s: float) -> None:
        """As `HullWatch.update`."""
        dt_s = min(_LONGEST_STEP_S, max(0.0, now_s - self._seen_s))
        self._seen_s = now_s
        self._turn_radps += dt_s / (dt_s + _TURN_S) * (nav.yaw_rate_radps - self._turn_radps)
        still = math.hypot(nav.north_mps, nav.east_mps) < _AT_REST_MPS
        if desired_mps is None:
            ahead = math.copysign(1.0, surge_n)
            self._judge_push(nav, ahead * nav.surge_mps, ahead * surge_n, still, dt_s)
            return
        desired_mps = desired_mps if nav.position_valid else 0.0
        hindered = self._hindered(nav, nav.surge_mps, desired_mps)
        in_vain = self._exceeds_need(nav, nav.surge_mps, surge_n, dt_s, hindered) and self._pushes(surge_n)
        in_vain = in_vain and hindered and (still or nav.current_north_mps is not None)
        self._count(nav.surge_mps, desired_mps, dt_s if in_vain else -dt_s)

    def _judge_push(self, nav: NavState, speed_mps: float, push_n: float, still: bool, dt_s: float) -> None:
        """Speed and force ahead, or astern where it pushes there."""
        if not self._pushes(push_n):
            self._model_mps = 0.0
            return
        reached_mps = self._reached_mps(speed_mps, push_n, dt_s)
        hindered = self._hindered(nav, speed_mps, reached_mps)
        in_vain = self._exceeds_need(nav, speed_mps, push_n, dt_s, hindered) and hindered and still
        at_begin = reached_mps < _LEAST_MPS
        self._count(speed_mps, reached_mps, dt_s if in_vain else 0.0 if at_begin else -dt_s)

    def _pushes(self, push_n: float) -> bool:
        return push_n >= _PUSH_SHARE * self._most_n

    def _hindered(self, nav: NavState, speed_mps: float, desired_mps: float) -> bool:
        asked = desired_mps >= _LEAST_MPS and nav.position_valid
        turns_radps = min(_TURNS_RADPS, _TURNS_SHARE * math.radians(self._parameters["PATH_YAW_RATE"]))
        return asked and speed_mps < _MADE_SHARE * desired_mps and abs(self._turn_radps) < turns_radps

    def _count(self, speed_mps: float, desired_mps: float, vain_s: float) -> None:
        """Sum up for how long thrust was in vain, or see that way is made again."""
        self._vain_s = max(0.0, self._vain_s + vain_s)
        if desired_mps >= _LEAST_MPS and speed_mps >= _MADE_SHARE * desired_mps:
            self._vain_s = 0.0
            self.in_vain = self.in_vain and speed_mps < _MADE_SHARE * self._vain_mps
        if self._vain_s >= self._parameters["FS_WAY_T"]:
            self.in_vain, self._vain_s, self._vain_mps = True, 0.0, desired_mps

    def _exceeds_need(self, nav: NavState, speed_mps: float, push_n: float, dt_s: float, hindered: bool) -> bool:
        """Whether the thrust is more than the hull needs in the current there may be."""
        stream_mps = math.hypot(nav.current_north_mps or 0.0, nav.current_east_mps or 0.0)
        if hindered and math.hypot(nav.north_mps, nav.east_mps) < _HELD_MPS:
            stream_mps = min(stream_mps, self._stream_mps + _STREAM_GROWS_MPS2 * dt_s)
        self._stream_mps = stream_mps
        drift_mps = max(self._parameters["FS_WAY_DRIFT"], stream_mps)
        return _NEEDED_SHARE * push_n > self._hull.drag_n(max(0.0, speed_mps) + drift_mps)

    def _reached_mps(self, speed_mps: float, push_n: float, dt_s: float) -> float:
        """Speed by the model under this push; it begins anew where the boat is as fast."""
        mps = max(self._model_mps, speed_mps, 0.0)
        self._model_mps = mps + (push_n - self._hull.drag_n(mps)) / self._hull.m11_kg * dt_s
        return self._model_mps
