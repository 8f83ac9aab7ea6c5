"""The wind by which a boat sails: slow enough to steer by, kept for a while where the wind vane fails."""

from __future__ import annotations

import math

from companion.core.decision import TextKind
from companion.core.estimate import Air, NavState, air_over_ground
from companion.core.events import Announce
from companion.params.store import Parameters

_SLOW_S = 3.0  # time constant of the wind by which the boat steers
_LIGHT_S = 10.0  # for which a light wind lasts before it is announced
_STRONGER = 1.3  # times SAIL_WIND_MIN: the wind counts as back


class SailWind:
    """`update` once a tick. `air`: the last wind over ground, to trim the sail by. `known`: the boat can sail: there is
    a wind, or the wind vane failed no more than SAIL_WIND_T ago.

    Remembers the wind, a slow copy of it, when it was heard last, and what has been announced.
    """

    def __init__(self, parameters: Parameters, say: Announce) -> None:
        self._parameters, self._say = parameters, say
        self.air: Air | None = None
        self._slow: Air = (0.0, 0.0)
        self._heard_s = 0.0
        self._lost = self._given_up = self._light = False
        self._light_s: float | None = None

    @property
    def known(self) -> bool:
        """Whether the boat can sail by it."""
        return self.air is not None and not self._given_up

    @property
    def failed(self) -> bool:
        """Whether the wind vane has failed for longer than the boat sails by the last wind."""
        return self._given_up

    @property
    def light(self) -> bool:
        """Whether there has been too little of it for a while."""
        return self._light

    @property
    def from_rad(self) -> float:
        """Direction that the slow wind comes from; 0 where none is known."""
        return math.atan2(-self._slow[1], -self._slow[0])

    @property
    def speed_mps(self) -> float:
        """Of the slow wind."""
        return math.hypot(*self._slow)

    def update(self, nav: NavState, now_s: float, dt_s: float) -> None:
        """Take the wind in, and say when it fails, is light, or is back."""
        air = air_over_ground(nav)
        if air is None:
            self._miss(now_s)
            return
        if self._lost:
            self._say(now_s, TextKind.ROUTINE, "wind_back", "Wind vane: back")
        self._lost = self._given_up = False
        north, east = air if self.air is None else self._slow
        share = dt_s / (dt_s + _SLOW_S)
        self._slow = north + share * (air[0] - north), east + share * (air[1] - east)
        self._heard_s, self.air = now_s, air
        self._judge_strength(now_s)

    def _miss(self, now_s: float) -> None:
        if self.air is None:
            return
        kept_s = self._parameters["SAIL_WIND_T"]
        if not self._lost:
            self._lost = True
            self._say(now_s, TextKind.ATTENTION, "wind_lost", f"Wind vane lost: sails by the last wind, {kept_s:.0f} s")
        if not self._given_up and now_s - self._heard_s > kept_s:
            self._given_up = True
            self._say(now_s, TextKind.ALARM, "wind_unknown", "No wind known: sheet free, drifting")

    def _judge_strength(self, now_s: float) -> None:
        least_mps, speed_mps = self._parameters["SAIL_WIND_MIN"], self.speed_mps
        if self._light and speed_mps > _STRONGER * least_mps:
            self._light, self._light_s = False, None
            self._say(now_s, TextKind.ROUTINE, "light_wind", f"Wind again: {speed_mps:.1f} m/s")
        elif not self._light and speed_mps >= least_mps:
            self._light_s = None
        elif not self._light:
            self._light_s = now_s if self._light_s is None else self._light_s
            self._light = now_s - self._light_s > _LIGHT_S
            if self._light:
                self._say(now_s, TextKind.ATTENTION, "light_wind", f"No wind: {speed_mps:.1f} m/s")
