"""How far ahead on its track a boat takes its course, since its bow follows late, and its hull later still."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.early_turn import EarlyTurn
from companion.guidance.path_laying import THROUGH_M
from companion.guidance.stopping import creep_mps
from companion.guidance.track import Track
from companion.guidance.turning import TURN_PREVIEW_S, Turning
from companion.params.store import Parameters

ALMOST_BACK_RAD = math.radians(120.0)
"""A sharper turn of the track leads back along the same line."""
# Of the radius that a plan gives a waypoint: so far inside may the boat pass as it turns early. The rest is for wind
# and current.
_INSIDE = 0.5
_FAR_INSIDE = 0.75  # the same of a boat that would run wide
# Times the speed along the track: that of a boat under way there, however it heels, slips and lags. What sails so much
# slower than it should lies across its course.
_UNDER_WAY = 2.0
_ALONG_RAD = math.radians(60.0)  # off the course of its leg, however a stream turns it, a boat is not on its way there


class OnLeg(NamedTuple):
    """The boat's place on the track and its speed setpoint; the radius that the plan gives the waypoint ahead, None for
    none, and whether the boat is to swing through that."""

    track: Track
    s_m: float
    speed_mps: float
    radius_m: float | None
    through: bool


class Preview:
    """`begin` with each track, then `ahead_m` or `ahead_s` every tick. `early`: how early the boat begins its turns.
    Remembers up to where a boat that begins early has begun to turn, and the same beyond a turn back."""

    def __init__(self, parameters: Parameters, turning: Turning, slides: bool) -> None:
        """`slides`: what turns the boat pushes it out of the turn."""
        self.early = EarlyTurn(parameters, turning, slides)
        self._parameters, self._turning = parameters, turning
        self._back_m = self._begun_m = 0.0

    def begin(self) -> None:
        """Another track."""
        self._back_m = self._begun_m = 0.0

    def turned_back_s_m(self, nav: NavState, track: Track, s_m: float) -> float:
        """Up to which arc length a boat has turned back, in an arc that began before a tip which it will not reach any
        more: its bow points back, or it sails back. `s_m` where it has not."""
        if self._back_m <= s_m:
            return s_m
        course_rad = track.at(s_m).course_rad
        c, s = math.cos(course_rad), math.sin(course_rad)
        back = nav.north_mps * c + nav.east_mps * s <= 0.0 or math.cos(nav.yaw_rad - course_rad) <= 0.0
        return self._back_m if back else s_m

    def ahead_m(self, nav: NavState, leg: OnLeg, error_m: float, lookahead_m: float) -> float:
        """How far ahead the course is taken. `error_m`: across the track.

        In an arc, or of a boat that begins its turns early, that is several seconds: may be more than a leg. A boat
        that does not sail along the track comes no nearer to its next leg, and where the track turns back one that is
        far off it has its own leg to sail yet: for these the course would be now that of the one leg, now that of the
        other. So has one whose bow does not point along its leg yet. A turn that has begun goes on, though the boat
        sails no more along the track."""
        ahead_s = self.ahead_s(nav, leg)
        usual_m = ahead_s * leg.speed_mps
        if self._turning.arc is None and not self.early.slides:
            return usual_m
        course_rad = leg.track.at(leg.s_m).course_rad
        along_mps = nav.north_mps * math.cos(course_rad) + nav.east_mps * math.sin(course_rad)
        ahead_m = min(usual_m, max(ahead_s * _UNDER_WAY * max(0.0, along_mps), self._begun_m - leg.s_m))
        if abs(wrap_pi(leg.track.at(leg.s_m + ahead_m).course_rad - course_rad)) > ALMOST_BACK_RAD:
            if abs(error_m) > lookahead_m or abs(wrap_pi(nav.yaw_rad - course_rad)) > _ALONG_RAD:
                ahead_m = 0.0
            else:
                self._back_m = max(self._back_m, leg.s_m + ahead_m)
        else:
            self._begun_m = max(self._begun_m, leg.s_m + ahead_m)
        return max(ahead_m, self._back_m - leg.s_m)

    def ahead_s(self, nav: NavState, leg: OnLeg) -> float:
        """The same in time, of a boat that sails along the track."""
        inside_m = leg.radius_m or (THROUGH_M if leg.through else self._parameters["NAV_ACC_RAD"])
        early_s = self.early.begins_s(
            nav,
            min(TURN_PREVIEW_S, self._earliest_s(leg)),
            leg.speed_mps,
            _FAR_INSIDE * inside_m,
            lambda m: leg.track.at(leg.s_m + m).course_rad,
        )
        return early_s + self._turning.late_s(nav.surge_mps, nav.sway_mps)

    def _earliest_s(self, leg: OnLeg) -> float:
        """How early a turn may begin. A boat that nothing pushes sideways, and whose thrusters turn it at once, passes
        a corner inside by r U t²/2 if it turns t early at the rate r: no more than a share of the radius that the plan
        gives, and little where the boat swings through."""
        if self._turning.bends is None or (leg.radius_m is None and not leg.through):
            return math.inf
        rate = math.radians(self._parameters["PATH_YAW_RATE"])
        pace_mps = max(leg.speed_mps, creep_mps(self._parameters))
        return math.sqrt(2.0 * _INSIDE * (leg.radius_m or THROUGH_M) / (rate * pace_mps))
