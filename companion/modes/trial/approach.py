"""Between two manoeuvres: brake, go to the centre or turn the bow to it, on a rough model.

Forces in proportion to the error of velocity over ground, with the heading held by the heading law: no integral, no
path, nothing that a wrong model could upset.
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import Setpoint
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.expectation import STEERAGE_SHARE, Expectation
from companion.modes.trial.hard_over import HardOver, hard_over
from companion.modes.trial.manoeuvres.manoeuvre import Begin, straight

_SOFT = 0.25  # share of the top speed at which the whole force brakes
_STILL = 0.08  # share of the top speed that counts as rest
_STILL_MPS = 0.05  # what a receiver calls rest
_SLOWS_SHARE, _SLOWS_S = 0.05, 2.0  # a boat that slows down by less in this time is held up by wind and current
_SPEED_SHARE = 0.35  # of the top speed, on the way to the centre
_CLOSING_1PS = 0.2
_BEARING_RAD = math.radians(12.0)
_STEADY_RADPS = math.radians(6.0)
_AIM_SHARE = 0.2  # of the radius: nearer to the centre the bow may point anywhere
_FAR_SHARE = 0.7  # of the radius: further out the boat comes in before anything else
_FAR_IN_DRIFT_SHARE = 0.4  # the same for a boat that the current carries sideways while it turns
_BRAKES_SHARE = 0.4  # of the radius: further out a boat without sideways thrust does not come to rest first
_UPSTREAM_SHARE = 0.4  # of the radius: where such a boat goes instead of the centre
_DRIFTS_SHARE = 0.08  # of the top speed: a slower current does not count
_AWAY_RAD = math.radians(60.0)  # a boat that points further away from its way brakes, and does not sail


class Approach:
    """`begin`, then `update` every tick → setpoint; None: it is there. Remembers its target, the heading that it
    keeps, and its least speed while it brakes."""

    def __init__(self, circle: TrialCircle, expectation: Expectation, config: VesselConfig) -> None:
        self._circle, self._expectation, self._config = circle, expectation, config
        self._target = Begin.HERE
        self._yaw_rad = 0.0
        self._braking = True
        self._begun_s = 0.0
        self._fast_mps = self._least_mps = 0.0
        self._least_s = 0.0
        self._hard_over = HardOver(circle)

    def begin(self, nav: NavState, target: Begin, brakes: bool, now_s: float) -> None:
        """`brakes`: come to rest first, with the heading of now."""
        self._target, self._yaw_rad, self._braking, self._begun_s = target, nav.yaw_rad, brakes, now_s
        self._fast_mps = math.hypot(nav.surge_mps, nav.sway_mps) if self._expectation.sways else abs(nav.surge_mps)
        self._least_mps, self._least_s = math.inf, now_s
        self._hard_over.ease()

    @property
    def longest_s(self) -> float:
        """Time after which the manoeuvre begins wherever the boat is."""
        e = self._expectation
        return 3.0 * e.turn_s + 2.0 * self._circle.radius_m / (_SPEED_SHARE * e.top_mps)

    def update(self, nav: NavState, now_s: float) -> Setpoint | None:
        """Brake, then go or turn."""
        e, circle = self._expectation, self._circle
        speed = math.hypot(nav.surge_mps, nav.sway_mps) if e.sways else abs(nav.surge_mps)  # as far as it can brake
        if self._braking and not e.sways and circle.distance_m(nav) > _BRAKES_SHARE * circle.radius_m:
            self._braking = False  # the current would carry it further out before it turns: it brakes as it turns
        if self._braking:
            if speed > max(_STILL * e.top_mps, _STILL_MPS, nav.velocity_accuracy_mps) and (
                now_s - self._begun_s < 6.0 * e.speeding_s and self._slows(speed, now_s)
            ):
                return self.towards(nav, (0.0, 0.0), self._yaw_rad, now_s)
            self._braking = False
            circle.learn(self._fast_mps, speed, now_s - self._begun_s)
        if self._target is Begin.HERE or now_s - self._begun_s > self.longest_s:
            return None
        return self._go(nav, now_s)

    def _slows(self, speed_mps: float, now_s: float) -> bool:
        """Whether a boat that brakes still slows down. Without an integral it never comes to rest in a strong stream,
        and would be carried out of its circle."""
        if speed_mps < (1.0 - _SLOWS_SHARE) * self._least_mps:
            self._least_mps, self._least_s = speed_mps, now_s
        return now_s - self._least_s < _SLOWS_S

    def _go(self, nav: NavState, now_s: float) -> Setpoint | None:
        e, circle = self._expectation, self._circle
        target = self._target_place(nav)
        north, east = target[0] - nav.north_m, target[1] - nav.east_m
        distance = math.hypot(north, east)
        near_m = max(0.12 * circle.radius_m, e.length_m, 2.0 if not e.sways else 0.0)
        outside = distance > (_FAR_SHARE if target == circle.centre else _FAR_IN_DRIFT_SHARE) * circle.radius_m
        goes = outside or (self._target is Begin.CENTRE and distance > near_m)
        bearing = math.atan2(east, north)
        if goes:
            self._yaw_rad = bearing
            speed = min(_SPEED_SHARE * e.top_mps, _CLOSING_1PS * distance)
            return self.towards(nav, (speed * north / distance, speed * east / distance), bearing, now_s)
        if self._target is Begin.FACING and distance > _AIM_SHARE * circle.radius_m:
            self._yaw_rad = bearing
        off = abs(wrap_pi(self._yaw_rad - nav.yaw_rad))
        if e.needs_way and off >= _BEARING_RAD:
            return self.towards(nav, (0.0, 0.0), self._yaw_rad, now_s)
        still = math.hypot(nav.surge_mps, nav.sway_mps) < max(2.0 * _STILL * e.top_mps, 2.0 * _STILL_MPS)
        if off < _BEARING_RAD and abs(nav.yaw_rate_radps) < _STEADY_RADPS and (still or not e.sways):
            return None
        return self.towards(nav, (0.0, 0.0), self._yaw_rad, now_s)

    def _target_place(self, nav: NavState) -> tuple[float, float]:
        """The centre; upstream of it for a boat that cannot push against a current from the side."""
        circle, e = self._circle, self._expectation
        north, east = circle.drift(nav)
        speed = math.hypot(north, east)
        if e.sways or speed < _DRIFTS_SHARE * e.top_mps:
            return circle.centre
        up_m = _UPSTREAM_SHARE * circle.radius_m / speed
        return circle.centre[0] - up_m * north, circle.centre[1] - up_m * east

    def towards(self, nav: NavState, velocity: tuple[float, float], yaw_rad: float, now_s: float) -> Setpoint:
        """Forces for a velocity over ground (north, east), with that heading."""
        e = self._expectation
        x, y = ned_to_body(*velocity, nav.yaw_rad)
        if abs(wrap_pi(yaw_rad - nav.yaw_rad)) > (_BEARING_RAD if e.needs_way else _AWAY_RAD):
            x = max(x, self._steerage_mps(nav)) if e.needs_way else min(x, 0.0)
        soft = _SOFT * e.top_mps
        share = min(1.0, max(-1.0, (x - nav.surge_mps) / soft))
        surge_n = share * (e.surge_n if share > 0.0 else e.astern_n)
        if e.needs_way and (side := self._hard_over.update(nav, yaw_rad, now_s)):
            return hard_over(self._config, e.surge_n, side)
        sway_n = e.sway_n * min(1.0, max(-1.0, (y - nav.sway_mps) / soft)) if e.sways else 0.0
        return straight(yaw_rad, surge_n, sway_n)

    def _steerage_mps(self, nav: NavState) -> float:
        """Speed ahead over ground at which a boat turns that needs way for it. The way must be through the water: with
        the stream from astern a boat that is slow over ground hardly turns, and the stream carries it far out."""
        along_mps, _ = ned_to_body(*self._circle.drift(nav), nav.yaw_rad)
        return max(0.0, along_mps) + STEERAGE_SHARE * self._expectation.top_mps
