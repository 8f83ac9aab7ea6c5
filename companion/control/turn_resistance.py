"""How much harder the water resists a turn than the vessel's file says, learned from turns.

The file's hull may be another one, and propellers in a turn lose their momentum across the shaft (Faltinsen 1990, 9):
an outboard that turns a RIB at 15° a second brakes that turn as hard as the hull does. The yaw equation (Fossen 2021,
with C and D as in `companion.control.model`), with N what the thrusters give by the allocation, is

k D(u, r) = N + munk(u, v) − m33 ṙ

All of it low-pass filtered, k is a regression over the turns so far, with the file's 1 as its prior. Waves that turn
the boat make it smaller. It is never below 1: what turns easier than its file says needs no care.

Rudder boats learn nothing: in rough water, what the stream at the blade gives is known too badly. A launch of 4 m that
learned sailed its squares wider by a quarter.
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.control.model import damping, drift_moment_nm
from companion.core.actuation import Wrench
from companion.core.estimate import NavState, through_water

_SEEN_S = 1.0  # low-pass filter: beyond the lag of thrusters
_USUAL_SHARE = 0.3  # of the yaw limit: a turn that by the file takes so much counts as `_PRIOR_S` and `_LASTS_S` say
# turning: so long until the file's word weighs as much as what is seen, and until that is forgotten
_PRIOR_S, _LASTS_S = 1.0, 15.0
_MOST = 5.0
_SLIGHT, _MARKED = 1.25, 1.75  # below the first, the file is believed; from the second on, what was learned
_MARKED_GAIN = (_MARKED - 1.0) / (_MARKED - _SLIGHT)


class TurnResistance:
    """`update` every cycle under way; `factor`: by which the file's damping in yaw is to be multiplied, 1 to 5.
    Remembers the filtered terms of the equation, and the sums of the regression."""

    __slots__ = ("_given_nm", "_hull", "_rate_radps", "_resisted_nm", "_seen", "_sum", "_weight", "_yaw_nm", "factor")

    def __init__(self, config: VesselConfig) -> None:
        self._hull, self._yaw_nm = config.hull, config.limits.yaw_nm
        self.reset()

    def reset(self) -> None:
        """The file is believed again."""
        self._weight = self._sum = _PRIOR_S * (_USUAL_SHARE * self._yaw_nm) ** 2
        self.factor = 1.0
        self.restart()

    def restart(self) -> None:
        """After cycles that were not seen: what was learned stays."""
        self._seen = False
        self._given_nm = self._resisted_nm = self._rate_radps = 0.0

    def update(self, nav: NavState, achieved: Wrench, dt_s: float) -> None:
        """`achieved`: what the thrusters gave in the last cycle, of `dt_s`."""
        (u, v), r = through_water(nav), nav.yaw_rate_radps
        _, _, resisted_nm = damping(self._hull, u, 0.0, r)
        given_nm = achieved.yaw_nm - drift_moment_nm(self._hull, u, v)
        if not math.isfinite(given_nm + resisted_nm) or dt_s <= 0.0:
            self.restart()
            return
        if not self._seen:
            self._seen, self._given_nm, self._resisted_nm, self._rate_radps = True, given_nm, resisted_nm, r
            return
        part = dt_s / (dt_s + _SEEN_S)
        gained_radps2 = (r - self._rate_radps) / (dt_s + _SEEN_S)  # the change of the filtered rate
        self._given_nm += part * (given_nm - self._given_nm)
        self._resisted_nm += part * (resisted_nm - self._resisted_nm)
        self._rate_radps += part * (r - self._rate_radps)
        self._learn(self._given_nm - self._hull.m33_kgm2 * gained_radps2, dt_s)

    def _learn(self, resisted_nm: float, dt_s: float) -> None:
        """`resisted_nm`: what the water took of the turn."""
        by_file_nm, usual_nm = self._resisted_nm, _USUAL_SHARE * self._yaw_nm
        weight = by_file_nm * by_file_nm * dt_s
        kept = 1.0 / (1.0 + weight / (_LASTS_S * usual_nm * usual_nm))
        self._weight = kept * (self._weight + weight)
        self._sum = kept * (self._sum + resisted_nm * by_file_nm * dt_s)
        learned = min(_MOST, max(1.0, self._sum / self._weight))
        self.factor = learned if learned >= _MARKED else 1.0 + _MARKED_GAIN * max(0.0, learned - _SLIGHT)
