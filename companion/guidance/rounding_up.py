"""Ahead of the end of its way, a boat without sideways thrust turns its bow into a stream that would carry it past.

What comes to rest must at last lie bow to the weather. A boat that turns only once it is there is carried on meanwhile:
over the place, and over a fence behind it. Where wind holds it against the stream, and nothing carries it to the end,
it sails there bow first after all.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.guidance.stopping import creep_mps
from companion.params.store import Parameters

_LAG_S = 1.2  # of the heading loop
_THROUGH_MPS = 0.15  # least speed through the stream: a slower one has no direction
_SLOWER_SHARE = 0.5  # of the stream: over ground, the boat lets itself be carried to the end so fast
_TURNING_RAD = math.radians(60.0)  # off its heading, a boat first turns
_HELD_SHARE = 0.5  # of the speed that it lets itself be carried at, in the mean: slower, it is held back
_HELD_TURNS = 2.0  # turns, from the begin of the first, before that is judged; the mean is that of one
_STEERAGE_SHARE = 0.3  # of WP_SPEED, kept through the water while it turns by a boat that needs it


class RoundingUp:
    """`update` every tick on the last leg; `heading_rad`, `most_mps` and `least_mps` count while it `lasts`.

    It begins where the way left is what the boat makes while it turns and then stops, and ends with the leg. A stream
    that carries it no further than NAV_ACC_RAD in that turn needs none, nor one that does not carry it to the end.
    Remembers whether it has begun, for how long, the mean speed along the track since, whether that was too slow, and
    the stream.
    """

    def __init__(self, parameters: Parameters, on_the_spot: bool) -> None:
        """`on_the_spot`: the boat needs no way to turn."""
        self._parameters = parameters
        self._steerage = 0.0 if on_the_spot else _STEERAGE_SHARE
        self._lasts = self._held = False
        self._stream_mps = self._made_mps = self._for_s = 0.0

    @property
    def lasts(self) -> bool:
        """Whether the boat lies, or turns, bow into the stream."""
        return self._lasts

    @property
    def most_mps(self) -> float:
        """Highest speed over ground along the track; infinite while it does not last."""
        if not self._lasts:
            return math.inf
        return max(_SLOWER_SHARE * self._stream_mps, creep_mps(self._parameters))

    def reset(self) -> None:
        """Another way begins."""
        self._lasts = self._held = False

    def update(self, nav: NavState, water: tuple[float, float], course_rad: float, left_m: float, dt_s: float) -> None:
        """`water`: velocity (north, east) of the stream. `left_m`: along the track to the end."""
        c, s = math.cos(course_rad), math.sin(course_rad)
        self._stream_mps = water[0] * c + water[1] * s
        turn_s = math.pi / math.radians(self._parameters["PATH_YAW_RATE"]) + _LAG_S
        made_mps = max(0.0, nav.north_mps * c + nav.east_mps * s)
        if self._lasts:
            self._see_held(made_mps, turn_s, dt_s)
            return
        carried_m = self._stream_mps * turn_s
        if self._held or carried_m <= self._parameters["NAV_ACC_RAD"]:
            return
        stops_m = self._stream_mps**2 / (2.0 * self._parameters["PATH_ACC"])
        self._lasts = left_m <= 0.5 * (made_mps * turn_s + carried_m) + stops_m
        self._made_mps, self._for_s = made_mps, 0.0

    def _see_held(self, made_mps: float, turn_s: float, dt_s: float) -> None:
        """End it where the boat is not carried along."""
        self._for_s += dt_s
        self._made_mps += min(1.0, dt_s / turn_s) * (made_mps - self._made_mps)
        if self._for_s > _HELD_TURNS * turn_s and self._made_mps < _HELD_SHARE * self.most_mps:
            self._lasts, self._held = False, True

    def heading_rad(self, water: tuple[float, float], course_rad: float, speed_mps: float) -> float:
        """The heading in which the boat makes a course at `speed_mps` over ground: against the stream that carries it
        along the course, and bow first where the course leads across or against it, as back to a track."""
        c, s = math.cos(course_rad), math.sin(course_rad)
        along, across = water[0] * c + water[1] * s, water[1] * c - water[0] * s
        through = speed_mps - along
        if math.hypot(through, across) < _THROUGH_MPS:
            through = -_THROUGH_MPS
        return wrap_pi(course_rad - math.atan2(across, through))

    def least_mps(self, nav: NavState, water: tuple[float, float], heading_rad: float) -> float:
        """Least speed over ground along the hull: until the bow has come round, a boat that brakes lies in a flow from
        astern, which holds its bow."""
        if abs(wrap_pi(heading_rad - nav.yaw_rad)) <= _TURNING_RAD:
            return -math.inf
        carried_mps = water[0] * math.cos(nav.yaw_rad) + water[1] * math.sin(nav.yaw_rad)
        return carried_mps + self._steerage * self._parameters["WP_SPEED"]
