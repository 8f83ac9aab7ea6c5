"""In a stream, a boat that turns on the spot turns ahead of the corner: the stream carries it there meanwhile.

A turning hull has hardly a hold on the water sideways, so it goes as the stream's part across it, and along the hull as
slowly as it is asked to. One that begins at the corner lies beyond it once its bow points along the next leg.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.track import Track
from companion.params.store import Parameters

_LEAST_SHARE = 0.5  # of NAV_ACC_RAD: a stream that carries the boat no further in half a turn changes nothing
_RATE_SHARE = 0.5  # of PATH_YAW_RATE, that a turn is planned with: it begins late, and a stream works against it
# After the turn, until the boat sails against the stream. The stream is known from before, on the bow: wind on the beam
# carries the hull faster.
_LAG_S = 1.6
_BEND_RAD = math.radians(15.0)  # courses that differ by less belong to one leg
_STEPS, _HALVINGS = 12, 4  # in which the track ahead is searched

Vector = tuple[float, float]


def carried_m(water_mps: Vector, from_rad: float, to_rad: float, rate_radps: float) -> Vector:
    """How far (north, east) a stream carries a boat across its hull while the bow turns the shorter way, at that rate:
    ∫ (w·n) n dψ / r, n to starboard."""
    turn_rad = wrap_pi(to_rad - from_rad)
    end_rad = from_rad + turn_rad
    s = 0.5 * (math.sin(2.0 * end_rad) - math.sin(2.0 * from_rad))
    c = -0.5 * (math.cos(2.0 * end_rad) - math.cos(2.0 * from_rad))
    north, east = water_mps
    share = math.copysign(0.5, turn_rad) / rate_radps
    return share * (turn_rad * north - (s * north + c * east)), share * (turn_rad * east - (c * north - s * east))


class CarriedTurn:
    """`course_s_m` every tick. Remembers up to where on the track the bow has turned, whether in a stream, and whether
    it waits."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Another way begins."""
        self._reached_s_m = 0.0
        self._in_stream = self._waits = False

    @property
    def in_stream(self) -> bool:
        """Whether the stream is so strong that it counts."""
        return self._in_stream

    @property
    def waits(self) -> bool:
        """Whether the bow has turned so far that the stream must first carry the boat nearer to the corner."""
        return self._waits

    def course_s_m(
        self,
        nav: NavState,
        track: Track,
        s_m: float,
        usual_m: float,
        preview_s: float,
        water_mps: Vector,
        heading_rad: Callable[[float], float],
    ) -> float:
        """Arc length of the track whose course the bow turns to, of a boat at `s_m`. Without a stream it is `usual_m`
        ahead, in one what the boat makes in `preview_s` and the turn. `water_mps`: the stream (north, east).
        `heading_rad`: course → heading."""
        rate_radps = _RATE_SHARE * math.radians(self._parameters["PATH_YAW_RATE"])
        if math.hypot(*water_mps) * math.pi / rate_radps <= _LEAST_SHARE * self._parameters["NAV_ACC_RAD"]:
            self.reset()
            return s_m + usual_m
        rate_radps = max(rate_radps, abs(nav.yaw_rate_radps))
        course = track.at(s_m).course_rad
        c, s = math.cos(course), math.sin(course)
        along_mps = water_mps[0] * c + water_mps[1] * s
        least_m = preview_s * max(0.0, nav.north_mps * c + nav.east_mps * s)

        def reaches(ahead_m: float) -> bool:
            heading = heading_rad(track.at(s_m + ahead_m).course_rad)
            north_m, east_m = carried_m(water_mps, nav.yaw_rad, heading, rate_radps)
            return least_m + north_m * c + east_m * s + along_mps * _LAG_S >= ahead_m

        most_m = least_m + max(0.0, along_mps) * (math.pi / rate_radps + _LAG_S)
        return self._turned_to(track, s_m, s_m + _farthest_m(reaches, most_m))

    def _turned_to(self, track: Track, s_m: float, soon_s_m: float) -> float:
        """The bow never turns back to a course before."""
        self._reached_s_m = min(track.length_m, max(self._reached_s_m, s_m, soon_s_m))
        course = track.at(self._reached_s_m).course_rad
        self._in_stream = True
        self._waits = abs(wrap_pi(course - track.at(soon_s_m).course_rad)) > _BEND_RAD
        return self._reached_s_m


def _farthest_m(reaches: Callable[[float], bool], most_m: float) -> float:
    """The largest distance up to `most_m` that is reached; 0 for none."""
    step_m = most_m / _STEPS
    step = next((i for i in range(_STEPS, 0, -1) if reaches(i * step_m)), 0)
    low_m, high_m = step * step_m, min(_STEPS, step + 1) * step_m
    for _ in range(_HALVINGS):
        middle_m = 0.5 * (low_m + high_m)
        low_m, high_m = (middle_m, high_m) if reaches(middle_m) else (low_m, middle_m)
    return low_m
