"""Reference for dynamic positioning by velocities: from the boat's present motion to a requested motion.

As in `reference.py` there are two stages. The velocity of the core approaches the requested one within the DP_ACC_*
limits. A moving average over SMOOTHING_S then makes the acceleration continuous and keeps position, velocity and
acceleration consistent.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.guidance.motion_request import MotionRequest, Pair
from companion.guidance.pose_setpoint import pose_setpoint
from companion.guidance.stopping import BRAKE_SHARE, SMOOTHING_S
from companion.params.store import Parameters

SafeSpeed = Callable[[Pair, Pair, float], float]
"""(place, velocity, deceleration in m/s²) → the highest speed in the direction of `velocity` from which the boat can
still stop inside the fence."""

_LEASH_LENGTHS = 0.75
_LEASH_LEAST_M = 1.0
_LEASH_RAD = math.radians(45.0)
_COURSE_MPS = 0.02  # a slower request has no course


class MotionReference:
    """Call `start(nav)`, then `update` every tick, with the same `dt_s` each time.

    If the boat does not keep up, the reference waits: it never leads by more than three quarters of the boat's length,
    or by 45°. MPC_XY_VEL_MAX limits the speed, DP_SPEED_* the speeds sideways and astern, DP_YAW_RATE the yaw rate.
    Remembers the core's pose and velocity, and the samples of the last SMOOTHING_S.
    """

    def __init__(self, length_m: float, parameters: Parameters, safe_speed_mps: SafeSpeed) -> None:
        self._parameters = parameters
        self._safe_speed = safe_speed_mps
        self._leash_m = max(_LEASH_LEAST_M, _LEASH_LENGTHS * length_m)
        self._north = self._east = self._yaw = 0.0
        self._velocity = (0.0, 0.0)
        self._rate = 0.0
        self._window: deque[tuple[float, ...]] = deque()

    def start(self, nav: NavState) -> None:
        """Begin at the boat's motion."""
        self._north, self._east, self._yaw = nav.north_m, nav.east_m, nav.yaw_rad
        self._velocity, self._rate = body_to_ned(nav.surge_mps, nav.sway_mps, nav.yaw_rad), nav.yaw_rate_radps
        self._window.clear()

    def update(self, request: MotionRequest, nav: NavState, dt_s: float) -> PoseSetpoint:
        """The reference `dt_s` after the last."""
        if not self._window:
            self._fill(dt_s)
        before, rate_before = self._velocity, self._rate
        requested = self._requested(request, dt_s)
        self._turn(request, requested, dt_s)
        turned = 0.5 * (rate_before + self._rate) * dt_s
        if request.body:
            c, s = math.cos(turned), math.sin(turned)
            self._velocity = (c * before[0] - s * before[1], s * before[0] + c * before[1])
            requested = (c * requested[0] - s * requested[1], s * requested[0] + c * requested[1])
        self._yaw += turned
        self._speed_up(self._allowed(requested), dt_s)
        vn, ve = self._velocity
        self._north += 0.5 * (before[0] + vn) * dt_s
        self._east += 0.5 * (before[1] + ve) * dt_s
        acceleration = ((vn - before[0]) / dt_s, (ve - before[1]) / dt_s, (self._rate - rate_before) / dt_s)
        self._window.popleft()
        self._window.append((self._north, self._east, self._yaw, vn, ve, self._rate, *acceleration))
        share = 1.0 / len(self._window)
        mean = [share * sum(column) for column in zip(*self._window, strict=True)]
        self._hold_back(mean, nav)
        target = (mean[0], mean[1]) if request.point is None else request.point
        return pose_setpoint(mean[:3], mean[3:6], mean[6:], target)

    # --- the request ---

    def _requested(self, request: MotionRequest, dt_s: float) -> Pair:
        """The requested velocity over ground (north, east)."""
        if request.velocity is not None:
            north, east = body_to_ned(*request.velocity, self._yaw) if request.body else request.velocity
        elif request.acceleration is not None:
            gain = body_to_ned(*request.acceleration, self._yaw) if request.body else request.acceleration
            north, east = self._velocity[0] + gain[0] * dt_s, self._velocity[1] + gain[1] * dt_s
        else:
            north = east = 0.0
        if request.point is not None:
            off_n, off_e = request.point[0] - self._north, request.point[1] - self._east
            distance = math.hypot(off_n, off_e)
            if distance > 0.0:
                closing = (
                    min(self._parameters["MPC_XY_VEL_MAX"], _to_rest(distance, BRAKE_SHARE * self._least_acc, dt_s))
                    / distance
                )
                north, east = north + closing * off_n, east + closing * off_e
        return north, east

    @property
    def _least_acc(self) -> float:
        return min(self._parameters["DP_ACC_SURGE"], self._parameters["DP_ACC_SWAY"])

    def _turn(self, request: MotionRequest, requested: Pair, dt_s: float) -> None:
        """Advance the core's yaw rate by one step."""
        most, acceleration = math.radians(self._parameters["DP_YAW_RATE"]), math.radians(self._parameters["DP_ACC_YAW"])
        heading, rate = request.yaw_rad, request.yaw_rate_radps
        if heading is None and request.along:
            heading = math.atan2(requested[1], requested[0]) if math.hypot(*requested) > _COURSE_MPS else None
            rate = 0.0
        if heading is not None:
            error = wrap_pi(heading - self._yaw)
            rate = math.copysign(_to_rest(abs(error), BRAKE_SHARE * acceleration, dt_s), error)
        rate = min(most, max(-most, rate))
        self._rate += min(acceleration * dt_s, max(-acceleration * dt_s, rate - self._rate))

    # --- the limits ---

    def _allowed(self, requested: Pair) -> Pair:
        """The requested velocity in its direction, within the speed limits and slow enough to stop inside the fence."""
        p, place, braking = self._parameters, (self._north, self._east), BRAKE_SHARE * self._least_acc
        if math.hypot(*self._velocity) > self._safe_speed(place, self._velocity, braking):
            return 0.0, 0.0
        speed = math.hypot(*requested)
        if speed == 0.0:
            return requested
        x, y = ned_to_body(requested[0] / speed, requested[1] / speed, self._yaw)
        most = min(p["MPC_XY_VEL_MAX"], self._safe_speed(place, requested, braking))
        most = min(most, p["DP_SPEED_SWAY"] / max(1.0e-9, abs(y)), p["DP_SPEED_ASTERN"] / max(1.0e-9, -x))
        share = min(1.0, most / speed)
        return share * requested[0], share * requested[1]

    def _speed_up(self, allowed: Pair, dt_s: float) -> None:
        """Advance the core's velocity by one step towards `allowed`, within the acceleration limits."""
        north, east = allowed[0] - self._velocity[0], allowed[1] - self._velocity[1]
        x, y = ned_to_body(north, east, self._yaw)
        excess = max(abs(x) / self._parameters["DP_ACC_SURGE"], abs(y) / self._parameters["DP_ACC_SWAY"]) / dt_s
        share = 1.0 / max(1.0, excess)
        self._velocity = (self._velocity[0] + share * north, self._velocity[1] + share * east)

    def _hold_back(self, mean: list[float], nav: NavState) -> None:
        """Shift core and samples towards the boat, if they lead by too much."""
        north, east = mean[0] - nav.north_m, mean[1] - nav.east_m
        distance = math.hypot(north, east)
        beyond = max(0.0, 1.0 - self._leash_m / distance) if distance > 0.0 else 0.0
        lead = wrap_pi(mean[2] - nav.yaw_rad)
        too_far = lead - min(_LEASH_RAD, max(-_LEASH_RAD, lead))
        if beyond == 0.0 and too_far == 0.0:
            return
        shift = (-beyond * north, -beyond * east, -too_far)
        self._north, self._east, self._yaw = self._north + shift[0], self._east + shift[1], self._yaw + shift[2]
        self._window = deque((s[0] + shift[0], s[1] + shift[1], s[2] + shift[2], *s[3:]) for s in self._window)
        mean[:3] = [mean[i] + shift[i] for i in range(3)]

    def _fill(self, dt_s: float) -> None:
        """Fill the window with samples of uniform motion whose mean is the state at the start."""
        count = max(1, round(SMOOTHING_S / dt_s))
        vn, ve = self._velocity
        for k in range(count):
            t = (k - 0.5 * (count - 1)) * dt_s
            pose = (self._north + vn * t, self._east + ve * t, self._yaw + self._rate * t)
            self._window.append((*pose, vn, ve, self._rate, 0.0, 0.0, 0.0))
        self._north, self._east, self._yaw = self._window[-1][:3]


def _to_rest(way: float, deceleration: float, dt_s: float) -> float:
    """The speed from which braking at `deceleration` ends at rest after `way`; the last step ends exactly there."""
    half = 0.5 * dt_s
    return min(way / dt_s, deceleration * (math.sqrt(half * half + 2.0 * way / deceleration) - half))
