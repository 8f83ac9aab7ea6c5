"""Requested velocities of a boat without sideways thrust, sailed as course and speed."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, without_waves
from companion.core.frames import body_to_ned
from companion.core.setpoint import PathSetpoint, Progress, Setpoint, WrenchSetpoint
from companion.guidance.course_keeping import CourseKeeping
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.motion_request import MotionRequest, Pair
from companion.guidance.sideslip import SteeredHull
from companion.params.store import Parameters

STANDING_MPS = 0.05  # a slower request means to stand still
_STEERAGE_SHARE = 0.3  # of the speed, kept while the bow points off the course
_POINT_RATE_1PS = 0.25
# Lags of the hull's sway, between which ever less is learnt of what its turn explains. Hulls that follow sooner do
# not snake, and answer gusts better with all of it: WAM-V 16 in 6 m/s was 0.44 m off a straight line without, 0.36
# with it.
_EARLY_S, _LATE_S = 2.5, 4.5
_SLIDES_MPS = 0.1  # for that lag
_LARGEST_LEAD_RAD = math.radians(45.0)


class VelocityCourse:
    """Call `start(nav)`, then `update` every tick.

    The heading turns at PATH_YAW_RATE at most, the speed changes by PATH_ACC. A heading beside a velocity over ground
    is ignored, and so is the sideways part of a velocity in body axes. Remembers the last setpoint's speed and heading,
    the drift, what keeps the course beside it, and the velocity that a requested acceleration has reached.
    """

    def __init__(
        self, parameters: Parameters, top_mps: float, can_reverse: bool, steered: SteeredHull | None = None
    ) -> None:
        self._parameters = parameters
        self._crab = CrabCompensation(top_mps, steered)
        self._keeping = CourseKeeping()
        self._hull = None if steered is None else steered.hull
        self._can_reverse = can_reverse
        self._surge = self._yaw = 0.0
        self._velocity = (0.0, 0.0)

    def start(self, nav: NavState) -> None:
        """Begin from the boat's motion."""
        self._surge, self._yaw = nav.surge_mps, nav.yaw_rad
        self._velocity = (nav.north_mps, nav.east_mps)
        self._crab.reset()
        self._keeping.reset()

    def update(self, wanted: MotionRequest, nav: NavState, dt_s: float) -> Setpoint:
        """A PathSetpoint for the request; a WrenchSetpoint without thrust if a boat that cannot reverse is to stand
        still."""
        most_rad = math.radians(self._parameters["PATH_YAW_RATE"])
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / most_rad)
        self._crab.update(nav, max(0.0, self._surge), straight, dt_s)
        ahead = self._along_the_hull(wanted, dt_s)
        if ahead is not None and wanted.point is None:
            return self._by_the_hull(ahead, wanted, nav, dt_s)
        north, east = self._over_ground(wanted, nav, dt_s)
        speed = min(self._parameters["MPC_XY_VEL_MAX"], math.hypot(north, east))
        if speed < STANDING_MPS:
            return self._by_the_hull(0.0, replace(wanted, yaw_rate_radps=0.0), nav, dt_s)
        course = math.atan2(east, north)
        mean = without_waves(nav)
        steered = self._keeping.update(
            mean,
            (speed * math.cos(course), speed * math.sin(course)),
            straight,
            dt_s,
            self._passing_mps(mean, course, speed),
        )
        best = self._crab.heading_rad(nav, math.atan2(steered[1], steered[0]), math.hypot(*steered), self._yaw)
        self._yaw = wrap_pi(self._yaw + _within(wrap_pi(best - self._yaw), most_rad * dt_s))
        surge = speed * max(_STEERAGE_SHARE, math.cos(wrap_pi(course - nav.yaw_rad)))
        return replace(self._setpoint(surge, 0.0, dt_s), progress=Progress(course_rad=course))

    def _passing_mps(self, nav: NavState, course_rad: float, speed_mps: float) -> float:
        """Of the velocity across the course, to starboard, what goes as the turn under way ends: the sideslip that it
        gives the hull, and the bow that has not come to its setpoint; 0 for a hull whose course follows soon."""
        late_s = 0.0 if self._hull is None else self._hull.sway_lag_s(speed_mps, _SLIDES_MPS)
        share = min(1.0, max(0.0, (late_s - _EARLY_S) / (_LATE_S - _EARLY_S)))
        slip = self._crab.slip_mps * math.cos(wrap_pi(nav.yaw_rad - course_rad))
        return share * (slip + speed_mps * math.sin(wrap_pi(nav.yaw_rad - self._yaw)))

    def _along_the_hull(self, wanted: MotionRequest, dt_s: float) -> float | None:
        """The requested speed ahead, for a request in body axes or for none; None for one over ground."""
        if wanted.velocity is None and wanted.acceleration is None:
            return 0.0
        if not wanted.body:
            return None
        if wanted.velocity is not None:
            return wanted.velocity[0]
        assert wanted.acceleration is not None
        return self._surge + wanted.acceleration[0] * dt_s

    def _over_ground(self, wanted: MotionRequest, nav: NavState, dt_s: float) -> Pair:
        """The requested velocity over ground (north, east)."""
        north = east = 0.0
        if wanted.velocity is not None:
            north, east = body_to_ned(*wanted.velocity, nav.yaw_rad) if wanted.body else wanted.velocity
        elif wanted.acceleration is not None:
            most, (north, east) = self._parameters["MPC_XY_VEL_MAX"], wanted.acceleration
            size = max(1.0e-9, math.hypot(north, east))
            share = min(1.0, self._parameters["PATH_ACC"] / size) * dt_s
            north, east = self._velocity[0] + share * north, self._velocity[1] + share * east
            share = min(1.0, most / max(1.0e-9, math.hypot(north, east)))
            north, east = share * north, share * east
        self._velocity = (north, east)
        if wanted.point is not None:
            north += _POINT_RATE_1PS * (wanted.point[0] - nav.north_m)
            east += _POINT_RATE_1PS * (wanted.point[1] - nav.east_m)
        return north, east

    def _by_the_hull(self, ahead_mps: float, wanted: MotionRequest, nav: NavState, dt_s: float) -> Setpoint:
        """A setpoint for a speed ahead or astern, with a requested heading or yaw rate."""
        astern = self._parameters["DP_SPEED_ASTERN"] if self._can_reverse else 0.0
        surge = min(self._parameters["MPC_XY_VEL_MAX"], max(-astern, ahead_mps))
        most = math.radians(self._parameters["PATH_YAW_RATE"])
        rate = 0.0
        if wanted.yaw_rad is not None:
            self._yaw = wrap_pi(self._yaw + _within(wrap_pi(wanted.yaw_rad - self._yaw), most * dt_s))
        elif wanted.yaw_rate_radps != 0.0:
            rate = _within(wanted.yaw_rate_radps, most)
            lead = wrap_pi(self._yaw - nav.yaw_rad) + rate * dt_s
            self._yaw = wrap_pi(nav.yaw_rad + _within(lead, _LARGEST_LEAD_RAD))
        setpoint = self._setpoint(surge, rate, dt_s)
        if self._can_reverse or surge >= STANDING_MPS:
            return setpoint
        return WrenchSetpoint(ZERO_WRENCH)

    def _setpoint(self, surge_mps: float, rate_radps: float, dt_s: float) -> PathSetpoint:
        before = self._surge
        self._surge += _within(surge_mps - before, self._parameters["PATH_ACC"] * dt_s)
        gained_mps2 = (self._surge - before) / dt_s
        return PathSetpoint(self._yaw, self._surge, yaw_rate_radps=rate_radps, surge_mps2=gained_mps2, over_ground=True)


def _within(value: float, most: float) -> float:
    return min(most, max(-most, value))
