"""How much earlier than its bow's lag asks for a boat begins a turn that one thruster turns it by, which pushes it out
of the turn.

An outboard slides its hull out of a turn, so that the course comes after the bow by the lag of the sway. Where its
moment turns the boat slower than PATH_YAW_RATE, as the heading setpoint turns, by the file or because the water resists
turns more, they take longer; the boat begins one half of that earlier, and ends it half of that later. Boats with a
difference of thrust wait for their bow instead, and need none of that.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config.hull import HullConfig
from companion.core.estimate import NavState
from companion.guidance.bend_speed import BendSpeeds
from companion.guidance.turning import Turning
from companion.params.store import Parameters

# Of the sway's lag, and of the same again where the water resists turns twice as hard: propellers that lose momentum
# across their shafts do so to the slide too.
_SLIDE_SHARE, _MOST_SHARES = 0.4, 2.0
_REACH = 2.0  # radii ahead, within which a turn counts
_MOST_RAD = math.radians(120.0)
_NEW = 0.1  # a share by which the resistance must change to be worth another profile of speed
_LEAST_MPS = 0.1


class EarlyTurn:
    """`turns_against`, then `begins_s` every tick. Remembers the resistance, and the `bends` with it: None for a boat
    whose moment does not bound its speed in bends. Of a boat that does not slide nothing changes."""

    def __init__(self, parameters: Parameters, turning: Turning, slides: bool) -> None:
        """`slides`: what turns the boat pushes it out of the turn."""
        self._parameters = parameters
        self._by_file = turning.bends
        self._hull = turning.steered.hull if slides and turning.bends and turning.steered else None
        self._resistance = 1.0
        self.bends: BendSpeeds | None = turning.bends

    @property
    def slides(self) -> bool:
        """Whether turns begin earlier than by the bow's lag."""
        return self._hull is not None

    def turns_against(self, resistance: float) -> bool:
        """The water resists a turn so many times as hard as the vessel's file says. Returns whether that is new."""
        if self._hull is None or self._by_file is None or abs(resistance - self._resistance) < _NEW * self._resistance:
            return False
        self._resistance = resistance
        self.bends = self._by_file.resisted(resistance)
        return True

    def begins_s(
        self, nav: NavState, usual_s: float, planned_mps: float, inside_m: float, course_rad: Callable[[float], float]
    ) -> float:
        """How early a turn begins that would begin `usual_s` early: no earlier than such that the boat passes its
        corner `inside_m` inside. `planned_mps`: the speed setpoint; `course_rad`: of the track, so many metres ahead.
        """
        if self._hull is None:
            return usual_s
        fastest = math.radians(self._parameters["PATH_YAW_RATE"])
        pace = max(_LEAST_MPS, min(nav.surge_mps, 2.0 * planned_mps))
        now = fastest if self.bends is None else min(fastest, self.bends.rate_radps(pace))
        turn_rad = min(_MOST_RAD, abs(course_rad(_REACH * pace / now) - course_rad(0.0)))
        longer_s = turn_rad * (1.0 / now - 1.0 / fastest)
        slides_s = self._slides_s(self._hull, nav)
        earliest_s = max(usual_s, math.sqrt(2.0 * inside_m / (now * pace)))
        return min(usual_s + 0.5 * longer_s + slides_s, earliest_s)

    def _slides_s(self, hull: HullConfig, nav: NavState) -> float:
        return _SLIDE_SHARE * min(_MOST_SHARES, self._resistance) * hull.sway_lag_s(nav.surge_mps, nav.sway_mps)
