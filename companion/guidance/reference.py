"""Reference for dynamic positioning: from the boat's present motion to a pose at rest, within speed and acceleration
limits.

There are two stages. The *core* moves the pose (north, east, yaw) along a straight line to the target, with all three
axes in step: at the highest rate that the body-frame limits allow, then on the braking curve that ends exactly at the
target (a trapezoid of speed). A moving average over SMOOTHING_S then makes the acceleration continuous. It keeps
position, velocity and acceleration consistent, keeps the limits (a mean never exceeds its terms), does not overshoot,
and arrives exactly, SMOOTHING_S later.
"""

from __future__ import annotations

import math
from collections import deque

from companion.core.angles import nearest_turn, wrap_pi
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.guidance.pose_setpoint import pose_setpoint
from companion.guidance.stopping import BRAKE_SHARE, stopping_time_s
from companion.guidance.stopping import SMOOTHING_S as SMOOTHING_S
from companion.params.store import Parameters

_QUARTER_TURN = 0.5 * math.pi
# How much faster than DP_YAW_RATE a reference turns that hurries, and to which rate at most: the bow of a boat that
# its weather drives off. At DP_YAW_RATE it would be carried away beam on for the better part of a minute.
_HURRY, _HURRY_MOST_RADPS = 2.7, math.radians(8.0)
_BEYOND = 1.001  # of its limit at full pace: what turns or slides faster did not learn it from the reference
_AT_REST = 1.0e-9  # m and rad, and a hundred times that per second: within this the core is set to the target

Sample = tuple[float, float, float, float, float, float, float, float, float]
"""Pose, velocity and acceleration, each (north, east, yaw)."""


class Limits:
    """Body-frame limits of the reference by the parameters; `speed_mps` lowers those of speed, `hurries` raises that of
    yaw rate, and `pace` is the share of all speeds that the boat keeps up with."""

    __slots__ = (
        "acc_surge",
        "acc_sway",
        "acc_yaw",
        "ahead",
        "astern",
        "damping_1ps",
        "damping_sway_1ps",
        "slide",
        "sway",
        "turn",
        "yaw",
    )

    def __init__(
        self, parameters: Parameters, speed_mps: float | None, hurries: bool = False, pace: float = 1.0
    ) -> None:
        cap = math.inf if speed_mps is None else max(speed_mps, 0.01)
        self.ahead = pace * min(parameters["DP_SPEED_AHEAD"], cap)
        self.astern = pace * min(parameters["DP_SPEED_ASTERN"], cap)
        self.sway = pace * min(parameters["DP_SPEED_SWAY"], cap)
        self.yaw = pace * math.radians(parameters["DP_YAW_RATE"])
        if hurries:
            self.yaw = max(self.yaw, min(_HURRY * self.yaw, _HURRY_MOST_RADPS))
        self.turn = _BEYOND * max(self.yaw, math.radians(parameters["DP_YAW_RATE"]))
        self.slide = _BEYOND * parameters["DP_SPEED_SWAY"]
        self.acc_surge = parameters["DP_ACC_SURGE"]
        self.acc_sway = parameters["DP_ACC_SWAY"]
        self.acc_yaw = math.radians(parameters["DP_ACC_YAW"])
        self.damping_1ps = 2.0 * parameters["DP_BW_YAW"]
        self.damping_sway_1ps = 2.0 * parameters["DP_BW_SWAY"]

    def braking_radps2(self, yaw_rate_radps: float) -> float:
        """Largest yaw acceleration at that rate. A boat may turn much faster than the reference ever does, out of a
        bend or adrift in wind and current: that is braked as the yaw loop brakes it, or the boat would be led half a
        turn on."""
        return max(self.acc_yaw, self.damping_1ps * (abs(yaw_rate_radps) - self.yaw))

    def braking_mps2(self, sway_mps: float) -> float:
        """Largest sway acceleration at that speed. A boat that came out of a bend slides much faster than the reference
        ever does: that is braked as the sway loop brakes it, or the boat would be led on sideways for lengths."""
        return max(self.acc_sway, self.damping_sway_1ps * (abs(sway_mps) - self.slide))

    def along(self, north: float, east: float, yaw: float, headings_rad: tuple[float, ...]) -> tuple[float, float]:
        """The largest (rate in 1/s, acceleration in 1/s²) of a motion along (north, east, yaw) that keeps the limits at
        all `headings_rad`."""
        rate = self.yaw / abs(yaw) if yaw != 0.0 else math.inf
        acceleration = self.acc_yaw / abs(yaw) if yaw != 0.0 else math.inf
        for heading in headings_rad:
            x, y = ned_to_body(north, east, heading)
            if abs(x) > 1.0e-12:
                rate = min(rate, (self.ahead if x > 0.0 else self.astern) / abs(x))
                acceleration = min(acceleration, self.acc_surge / abs(x))
            if abs(y) > 1.0e-12:
                rate = min(rate, self.sway / abs(y))
                acceleration = min(acceleration, self.acc_sway / abs(y))
        return rate, acceleration


def _headings_between(from_rad: float, to_rad: float, course_rad: float) -> tuple[float, ...]:
    """Both ends, and the headings between them at which `course_rad` is ahead, abeam or astern: the limits are tightest
    there."""
    low, high = min(from_rad, to_rad), max(from_rad, to_rad)
    first = course_rad + _QUARTER_TURN * math.ceil((low - course_rad) / _QUARTER_TURN)
    count = int((high - first) // _QUARTER_TURN) + 1 if high >= first else 0
    return (from_rad, to_rad, *(first + _QUARTER_TURN * i for i in range(min(count, 4))))


class _Core:
    """The trapezoid: pose, velocity and target in (north, east, yaw), yaw unwrapped."""

    __slots__ = ("acceleration", "pose", "resting", "target", "velocity")

    def __init__(
        self, pose: tuple[float, float, float], velocity: tuple[float, float, float], target: tuple[float, float, float]
    ) -> None:
        self.pose = pose
        self.velocity = velocity
        self.acceleration = (0.0, 0.0, 0.0)
        self.target = target
        self.resting = False

    def advance(self, limits: Limits, dt_s: float) -> None:
        """One step of constant acceleration towards the target."""
        if self.resting:
            self.acceleration = (0.0, 0.0, 0.0)
            return
        (n, e, y), (vn, ve, vy) = self.pose, self.velocity
        dn, de, dy = self.target[0] - n, self.target[1] - e, self.target[2] - y
        wanted = self._wanted_rate(dn, de, dy, limits, dt_s)
        an, ae, ay = (dn * wanted - vn) / dt_s, (de * wanted - ve) / dt_s, (dy * wanted - vy) / dt_s
        an, ae, ay = self._limited((an, ae, ay), limits)
        half = 0.5 * dt_s * dt_s
        self.pose = (n + vn * dt_s + an * half, e + ve * dt_s + ae * half, y + vy * dt_s + ay * half)
        self.velocity = (vn + an * dt_s, ve + ae * dt_s, vy + ay * dt_s)
        self.acceleration = (an, ae, ay)
        if (
            all(abs(a - b) < _AT_REST for a, b in zip(self.pose, self.target, strict=True))
            and max(map(abs, self.velocity)) < 100.0 * _AT_REST
        ):
            self.pose = self.target
            self.velocity = (0.0, 0.0, 0.0)
            self.resting = True

    def _limited(self, wanted: tuple[float, float, float], limits: Limits) -> tuple[float, float, float]:
        """The acceleration (north, east, yaw) within the limits, all axes in step. A boat that turns or slides faster
        than the reference ever does brakes each axis by itself: in step its turn would go on for as long as its way."""
        (vn, ve, vy), yaw = self.velocity, self.pose[2]
        slide = ned_to_body(vn, ve, yaw)[1]
        ax, ay = ned_to_body(wanted[0], wanted[1], yaw)
        surge = max(1.0, abs(ax) / limits.acc_surge)
        sway = max(1.0, abs(ay) / limits.braking_mps2(slide))
        turn = max(1.0, abs(wanted[2]) / limits.braking_radps2(vy))
        if abs(vy) <= limits.turn and abs(slide) <= limits.slide:
            surge = sway = turn = max(surge, sway, turn)
        north, east = body_to_ned(ax / surge, ay / sway, yaw)
        return north, east, wanted[2] / turn

    def _wanted_rate(self, dn: float, de: float, dy: float, limits: Limits, dt_s: float) -> float:
        """Share of the remaining way to cover per second: as fast as the limits allow and a stop at the target permits.

        A step begins at rate v₀ and ends at v; the way left after it must be v²/2a: v²/2a + v dt/2 + v₀ dt/2 − 1 = 0.
        The last two steps end exactly at the target.
        """
        yaw = self.pose[2]
        headings = _headings_between(yaw, yaw + dy, math.atan2(de, dn)) if dn != 0.0 or de != 0.0 else (yaw,)
        fastest, acceleration = limits.along(dn, de, dy, headings)
        if math.isinf(acceleration):
            return 0.0
        present = self._present_rate(dn, de, dy, limits)
        landing = 1.0 / dt_s - 0.5 * present  # ends the step after this one on the target, at rest
        step = acceleration * dt_s
        if 0.0 <= landing <= step and abs(present - landing) <= step:
            return min(fastest, landing)
        acceleration *= BRAKE_SHARE
        left = 1.0 - 0.5 * present * dt_s
        if left <= 0.0:
            return 0.0
        braking = acceleration * (math.sqrt(0.25 * dt_s * dt_s + 2.0 * left / acceleration) - 0.5 * dt_s)
        return min(fastest, braking)

    def _present_rate(self, dn: float, de: float, dy: float, limits: Limits) -> float:
        """Share of the remaining way that the present velocity covers per second, with each axis scaled by its
        acceleration limit."""
        w, wy = 1.0 / (limits.acc_surge * limits.acc_sway), 1.0 / (limits.acc_yaw * limits.acc_yaw)
        square = w * (dn * dn + de * de) + wy * dy * dy
        along = w * (dn * self.velocity[0] + de * self.velocity[1]) + wy * dy * self.velocity[2]
        return max(0.0, along / square) if square > 0.0 else 0.0


class ReferenceGenerator:
    """Call `start` at the boat's state, `retarget` at any time, and `update` every tick, always with the same `dt_s`.

    The limits are the DP_* parameters, read at every step. Remembers the core's state and the samples of the last
    SMOOTHING_S.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._speed_mps: float | None = None
        self._hurries = False
        self.start(0.0, 0.0, 0.0)

    def start(
        self,
        north_m: float,
        east_m: float,
        yaw_rad: float,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """Begin at this state; the target is the pose where the boat comes to rest from it."""
        vn, ve = body_to_ned(surge_mps, sway_mps, yaw_rad)
        way = 0.5 * (SMOOTHING_S + stopping_time_s(surge_mps, sway_mps, yaw_rate_radps, self._parameters))
        pose = (north_m, east_m, yaw_rad)
        target = (north_m + vn * way, east_m + ve * way, yaw_rad + yaw_rate_radps * way)
        self._core = _Core(pose, (vn, ve, yaw_rate_radps), target)
        self._window: deque[Sample] = deque()
        self._sum = [0.0] * 9
        self._rested = 0  # number of the newest samples in the window that are at the target
        self._speed_mps, self._hurries = None, False

    def retarget(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None = None, hurries: bool = False
    ) -> None:
        """Continue from the present motion to another pose, by the shorter turn; `speed_mps` lowers the speed limits,
        `hurries` raises that of yaw rate."""
        self._core.target = (north_m, east_m, nearest_turn(yaw_rad, self._core.pose[2]))
        self._core.resting = False
        self._rested = 0
        self._speed_mps, self._hurries = speed_mps, hurries

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the reference goes to."""
        north, east, yaw = self._core.target
        return north, east, wrap_pi(yaw)

    @property
    def arrived(self) -> bool:
        """Whether the reference rests at its target."""
        return 0 < len(self._window) <= self._rested

    def update(self, dt_s: float, pace: float = 1.0) -> PoseSetpoint:
        """The reference `dt_s` after the last: pose in NED, velocity and acceleration in the reference's body axes.
        `pace`: share of its speeds, for a boat that does not keep up."""
        core = self._core
        if not self._window:
            self._fill(dt_s)
        self._rested = self._rested + 1 if core.resting else 0
        core.advance(Limits(self._parameters, self._speed_mps, self._hurries, pace), dt_s)
        newest = (*core.pose, *core.velocity, *core.acceleration)
        oldest = self._window.popleft()
        self._window.append(newest)
        if self._rested >= len(self._window):
            mean = list(newest)  # removes the rounding of the running sum
            self._sum = [value * len(self._window) for value in mean]
        else:
            self._sum = [s + new - old for s, new, old in zip(self._sum, newest, oldest, strict=True)]
            share = 1.0 / len(self._window)
            mean = [s * share for s in self._sum]
        return pose_setpoint(mean[:3], mean[3:6], mean[6:], core.target)

    def _fill(self, dt_s: float) -> None:
        """Fill the window with samples of uniform motion whose mean is the state at the start."""
        count = max(1, round(SMOOTHING_S / dt_s))
        (n, e, y), (vn, ve, vy) = self._core.pose, self._core.velocity
        for k in range(count):
            t = (k - 0.5 * (count - 1)) * dt_s
            self._window.append((n + vn * t, e + ve * t, y + vy * t, vn, ve, vy, 0.0, 0.0, 0.0))
        self._core.pose = self._window[-1][:3]
        self._sum = [sum(column) for column in zip(*self._window, strict=True)]
