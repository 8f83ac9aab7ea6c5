"""The circle of a trial: where the boat will come to rest, and whether that is inside.

The deceleration is half of what the model says until the boat has braked; then it is what was seen, with a reserve. The
turning rate of a boat that turns only with way on is half of the model's, then the least that was seen.
"""

from __future__ import annotations

import math

from companion.core.estimate import NavState
from companion.modes.trial.expectation import Expectation

_UNSEEN, _SEEN = 0.5, 0.7  # share of the deceleration that is counted on
_REACT_S = 1.5  # from the decision until the thrusters push astern
_WORTH_MPS2 = 0.2  # share of the expected deceleration below which a braking tells nothing
_WORTH_RADPS = 0.1  # the same of the turning rate
_TURNED_RAD = math.radians(40.0)  # a smaller turn tells nothing of the rate
_DRIFT_MOST = 0.6  # of the top speed
_MARGIN, _MARGIN_UNDERACTUATED = 0.5, 1.5  # lengths inside the circle; a boat without sideways thrust must turn first


class TrialCircle:
    """`centre` and `radius_m` as the operator accepted them. Remembers the least deceleration and turning rate seen."""

    def __init__(self, centre: tuple[float, float], radius_m: float, expectation: Expectation) -> None:
        self.centre, self.radius_m = centre, radius_m
        self._expectation = expectation
        self._brake_mps2 = _UNSEEN * expectation.brake_mps2
        self._seen = False
        self._turn_radps: float | None = None

    @property
    def brake_mps2(self) -> float:
        """The deceleration that is counted on."""
        return self._brake_mps2

    @property
    def turning_s(self) -> float:
        """How long the boat drifts, until it has turned round; 0 for one that pushes sideways."""
        return self._expectation.turning_s if self._turn_radps is None else math.pi / self._turn_radps

    def learn(self, from_mps: float, to_mps: float, time_s: float) -> None:
        """The boat has braked from one speed to another in that time."""
        if time_s <= 0.5 or from_mps - to_mps < 0.25 * self._expectation.top_mps:
            return
        seen = _SEEN * (from_mps - to_mps) / time_s
        if seen < _WORTH_MPS2 * self._expectation.brake_mps2 * _SEEN:
            seen = _WORTH_MPS2 * self._expectation.brake_mps2 * _SEEN
        self._brake_mps2 = min(self._brake_mps2, seen) if self._seen else seen
        self._seen = True

    def learn_turn(self, turned_rad: float, time_s: float) -> None:
        """The boat has turned by that angle with the helm hard over in that time."""
        if time_s <= 0.5 or turned_rad < _TURNED_RAD:
            return
        seen = max(turned_rad / time_s, _WORTH_RADPS * self._expectation.turn_radps)
        self._turn_radps = seen if self._turn_radps is None else min(self._turn_radps, seen)

    def distance_m(self, nav: NavState) -> float:
        """From the centre to the boat."""
        return math.hypot(nav.north_m - self.centre[0], nav.east_m - self.centre[1])

    def stop_m(self, nav: NavState) -> float:
        """Way over ground until the boat is at rest, if it brakes now."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        return speed * _REACT_S + 0.5 * speed * speed / self._brake_mps2

    def leaves(self, nav: NavState, turning_s: float) -> bool:
        """Whether the boat would come to rest outside, if it began to brake a tick later. `turning_s`: how long it
        drifts with the current afterwards, until it has turned round. A current that would carry it back does not
        help: it is outside before."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        if speed < 1e-6:
            return self.distance_m(nav) > self._inner_m
        way = self.stop_m(nav) / speed
        north = nav.north_m + nav.north_mps * way - self.centre[0]
        east = nav.east_m + nav.east_mps * way - self.centre[1]
        outward = nav.north_mps * north + nav.east_mps * east > 0.0
        if math.hypot(north, east) > self._inner_m and outward:
            return True
        drift_n, drift_e = self.drift(nav)
        north, east = north + drift_n * turning_s, east + drift_e * turning_s
        outward = (nav.north_mps + drift_n) * north + (nav.east_mps + drift_e) * east > 0.0
        return math.hypot(north, east) > self._inner_m and outward

    def drift(self, nav: NavState) -> tuple[float, float]:
        """Velocity of the water over ground, as far as it is known and can be believed."""
        north, east = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        speed, most = math.hypot(north, east), _DRIFT_MOST * self._expectation.top_mps
        share = min(1.0, most / speed) if speed > 0.0 else 0.0
        return north * share, east * share

    @property
    def _inner_m(self) -> float:
        e = self._expectation
        return self.radius_m - (_MARGIN if e.sways else _MARGIN_UNDERACTUATED) * e.length_m
