"""How a sailing boat comes from one heading to another: through the wind, or before it.

The shorter way counts, but a turn through the wind of more than 140° costs more than one before it. A boat with too
little way for a tack first bears away to gather some. A tack that fails is followed by a turn before the wind.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import Announce
from companion.guidance.sail_wind import SailWind
from companion.params.store import Parameters

_GYBE_RAD = math.radians(140.0)
_LEAD_RAD = math.radians(100.0)  # by which the bow is led in a turn before the wind
_TACK_LEAD_RAD = math.radians(30.0)  # in a turn through the wind: a rudder hard over takes the way that it needs
_ARRIVED_RAD = 0.1
_BACK_S, _BACK_RAD = 3.0, math.radians(5.0)  # a bow that has fallen back so far after that time does not get through
_GATHER_S, _BEAR_AWAY_RAD = 12.0, math.radians(15.0)
WAY_SHARE = 0.165  # of the wind: a slower boat does not get through it
_LUFFS_RAD = math.radians(30.0)  # off the wind, where a turn through it goes on with the sheet free


class SailTurn:
    """`heading(yaw_rad, …)` once a tick: the heading to steer now on the way to that one.

    Remembers since when the bow goes through the wind, whether it turns before the wind, and since when the boat
    gathers way.
    """

    def __init__(self, parameters: Parameters, wind: SailWind, say: Announce) -> None:
        self._parameters, self._wind, self._say = parameters, wind, say
        self._tacks_s: float | None = None
        self._gathers_s: float | None = None
        self._wears = False

    @property
    def tacks(self) -> bool:
        """Whether the bow goes through the wind."""
        return self._tacks_s is not None

    @property
    def turns(self) -> bool:
        """Whether the boat goes about in any way, or gathers way for it."""
        return self._wears or self._tacks_s is not None or self._gathers_s is not None

    @property
    def gathers(self) -> bool:
        """Whether the boat gathers way for a tack."""
        return self._gathers_s is not None

    def luffs(self, nav: NavState) -> bool:
        """Whether the sail is to luff: it would stop the turn and push the boat to leeward."""
        return self.tacks and abs(wrap_pi(nav.yaw_rad - self._wind.from_rad)) < _LUFFS_RAD

    def reset(self) -> None:
        """Forget the turn."""
        self._tacks_s = self._gathers_s = None
        self._wears = False

    def heading(self, yaw_rad: float, no_go_rad: float, nav: NavState, now_s: float) -> float:
        """The heading to steer. `no_go_rad`: closest to the wind that the boat sails."""
        from_rad = self._wind.from_rad
        off, to = wrap_pi(nav.yaw_rad - from_rad), wrap_pi(yaw_rad - from_rad)
        through_wind_rad = abs(off) + abs(to)
        same_side = off * to >= 0.0
        if same_side or through_wind_rad < _ARRIVED_RAD or math.tau - through_wind_rad < _LEAD_RAD:
            self.reset()
            return yaw_rad
        if self._tacks_s is None and not self._wears:
            self._choose(through_wind_rad, nav, now_s)
        self._mind_failure(abs(off) > no_go_rad + _BACK_RAD, now_s)
        if self._wears:
            return wrap_pi(nav.yaw_rad + math.copysign(_LEAD_RAD, off))
        if self._gathers_s is not None:
            return wrap_pi(from_rad + math.copysign(no_go_rad + _BEAR_AWAY_RAD, off))
        return wrap_pi(nav.yaw_rad - math.copysign(min(_TACK_LEAD_RAD, through_wind_rad), off))

    def _choose(self, through_wind_rad: float, nav: NavState, now_s: float) -> None:
        """Turn before the wind, gather way, or begin the tack."""
        if through_wind_rad > _GYBE_RAD:
            self._wears = True
        elif nav.surge_mps < WAY_SHARE * self._wind.speed_mps:
            self._gathers_s = now_s if self._gathers_s is None else self._gathers_s
            self._wears = now_s - self._gathers_s > _GATHER_S
        else:
            self._tacks_s, self._gathers_s = now_s, None

    def _mind_failure(self, has_fallen_back: bool, now_s: float) -> None:
        if self._tacks_s is None:
            return
        tacks_s = now_s - self._tacks_s
        if tacks_s > self._parameters["SAIL_TACK_T"] or (tacks_s > _BACK_S and has_fallen_back):
            self._wears, self._tacks_s = True, None
            self._say(now_s, TextKind.ATTENTION, "tack_failed", "Tack failed: gybing instead")
