"""To which side a thruster that steers the boat alone pushes, ahead or astern, and where it turns for that.

Force and moment are those of one force at one angle. The same moment comes from a push ahead at one angle and from one
astern at the opposite angle: a solver that looks one cycle ahead reverses at once where the moment changes its sign,
brakes a boat that is to go ahead, and stays there, since without thrust a turn changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.allocation.geometry import Thruster
from companion.allocation.solver import YAW_PRIORITY

_SOON_S, _LASTS = 2.0, 1.0  # a new demand is taken to last so long; an older one by so many times its age longer
_LEAST_OFF = 0.01  # of the limits: a demand, or a gain, that is worth no change
_WORTH_S = 0.2  # of the limits, times seconds, that must be gained as well: little thrust does not reverse in waves
_BRAKES_SHARE = 0.1  # of the force ahead: a boat that makes way is to brake from so much astern on
_STILL_BRAKES_SHARE = 0.03  # until so little: about one limit alone the thruster turned to and fro without thrust
_NOTHING = 1.0e-18
_MARGIN = 1.05  # on what the present side costs, before the other is better


@dataclass(frozen=True, slots=True)
class _Way:
    """What one side gives: `aim_rad`, its azimuth; `off`, what is missing of the demand there, in limits; `time_s`,
    until the thruster is there."""

    aim_rad: float
    off: float
    time_s: float


class LoneSide:
    """`update` every cycle, then `ahead` and `aim_rad`.

    Of both sides it takes the one that misses less of the demand by the time for which that will last, the way to it
    included: that way gives nothing. A boat that makes way ahead, and is not to brake, is pushed ahead alone: steered
    by a push astern it would lose its way in every bend. Remembers its side, and how long the same side would have been
    of more use.
    """

    def __init__(self, thruster: Thruster, scales: tuple[float, float, float]) -> None:
        """`scales`: the wrench limits in N, N, Nm."""
        self._thruster = thruster
        self._surge_n, _, self._yaw_nm = scales
        self.reset()

    def reset(self) -> None:
        """Begin ahead."""
        self.ahead = True
        self.aim_rad: float | None = None
        self._brakes = False  # it is to brake
        self._better = 0  # the side that misses less once the thruster is there: 1 ahead, −1 astern
        self._lasted_s = 0.0  # for which it has been that side

    def update(
        self,
        demand: tuple[float, float],
        ideal: tuple[float, float],
        force_n: float,
        azimuth_rad: float,
        makes_way: bool,
        dt_s: float,
    ) -> None:
        """One cycle: the demand (surge N, yaw Nm), the force (x, y) that would give it without stops, the thruster's
        present force and azimuth, and whether the boat makes way ahead through the water. `aim_rad` is then the azimuth
        to turn to, None where nothing worth a turn is asked for."""
        surge_n, yaw_nm = demand
        nothing = self._off(surge_n, yaw_nm, 0.0, azimuth_rad)
        if nothing < _LEAST_OFF:
            self.aim_rad, self._better, self._lasted_s = None, 0, 0.0
            return
        direction_rad = math.atan2(ideal[1], ideal[0])
        astern, ahead = (
            self._way(side, surge_n, yaw_nm, direction_rad, force_n, azimuth_rad) for side in (False, True)
        )
        better = 0 if abs(ahead.off - astern.off) < _LEAST_OFF else 1 if ahead.off < astern.off else -1
        self._lasted_s = self._lasted_s + dt_s if better == self._better else 0.0
        self._better = better
        stays, other = (ahead, astern) if self.ahead else (astern, ahead)
        present_n = self._best_n(self.ahead, surge_n, yaw_nm, azimuth_rad)
        gives = self._off(surge_n, yaw_nm, present_n, azimuth_rad)  # on its way to where it stays
        lasts_s = _SOON_S + _LASTS * self._lasted_s
        self._brakes = surge_n <= -(_STILL_BRAKES_SHARE if self._brakes else _BRAKES_SHARE) * self._surge_n
        keeps_way = makes_way and not self._brakes
        wins = _MARGIN * _missing(other, nothing, lasts_s) + _WORTH_S < _missing(stays, gives, lasts_s)
        if (keeps_way and not self.ahead) or (wins and not keeps_way):
            self.ahead, stays = not self.ahead, other
        self.aim_rad = stays.aim_rad

    def _way(
        self, ahead: bool, surge_n: float, yaw_nm: float, direction_rad: float, force_n: float, azimuth_rad: float
    ) -> _Way:
        t = self._thruster
        aim_rad = t.sectors.nearest(direction_rad if ahead else direction_rad + math.pi, azimuth_rad)
        best_n = self._best_n(ahead, surge_n, yaw_nm, aim_rad)
        reversal_s = abs(force_n) / t.force_rate_nps if force_n * (1.0 if ahead else -1.0) < 0.0 else 0.0
        turn_s = abs(aim_rad - azimuth_rad) / t.azimuth_rate_radps
        return _Way(aim_rad, self._off(surge_n, yaw_nm, best_n, aim_rad), max(turn_s, reversal_s))

    def _best_n(self, ahead: bool, surge_n: float, yaw_nm: float, azimuth_rad: float) -> float:
        """The force to that side at an azimuth that misses least."""
        t = self._thruster
        along, turning = self._unit(azimuth_rad)
        asked = along * surge_n / self._surge_n + YAW_PRIORITY * turning * yaw_nm / self._yaw_nm
        best_n = asked / max(_NOTHING, along * along + YAW_PRIORITY * turning * turning)
        return min(t.max_n, max(0.0, best_n)) if ahead else max(t.min_n, min(0.0, best_n))

    def _unit(self, azimuth_rad: float) -> tuple[float, float]:
        """Surge and yaw of one newton, in limits."""
        t = self._thruster
        c, s = math.cos(azimuth_rad), math.sin(azimuth_rad)
        return c / self._surge_n, (t.x_m * s - t.y_m * c) / self._yaw_nm

    def _off(self, surge_n: float, yaw_nm: float, force_n: float, azimuth_rad: float) -> float:
        """What is missing of the demand, in limits; yaw counts as in the solver."""
        along, turning = self._unit(azimuth_rad)
        return math.hypot(
            surge_n / self._surge_n - along * force_n,
            math.sqrt(YAW_PRIORITY) * (yaw_nm / self._yaw_nm - turning * force_n),
        )


def _missing(way: _Way, meanwhile: float, lasts_s: float) -> float:
    """What is missing in all while the demand lasts, `meanwhile` on the way."""
    late_s = min(way.time_s, lasts_s)
    return late_s * meanwhile + (lasts_s - late_s) * way.off
