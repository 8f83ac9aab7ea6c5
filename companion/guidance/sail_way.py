"""Way under sail: a boat that drifts aside faster than it goes ahead has a keel and a rudder that give no force.

It then lies close to the wind with the rudder hard over, and drifts off. The remedy is a sailor's: bear away to a
reach, where the sail drives ahead, until there is way on.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, through_water

_LEAST_MPS, _ENOUGH_MPS = 0.5, 0.9  # ahead: less may be no way, so much is enough
_DRIFT_SHARE = 0.6  # of the way ahead: a keel whose flow is attached lets the boat drift by a tenth
_STALL_S, _REACH_S = 2.0, 12.0  # until it counts as stalled; the longest that it bears away
_REACH_RAD = math.radians(95.0)


class SailWay:
    """`heading(yaw_rad, …)` once a tick: that heading, or a reach while the boat gathers way.

    Remembers for how long the boat has drifted aside, and for how long it has borne away.
    """

    def __init__(self) -> None:
        self._stall_s = 0.0
        self._reach_s: float | None = None

    @property
    def gathers(self) -> bool:
        """Whether the boat has borne away to gather way."""
        return self._reach_s is not None

    def reset(self) -> None:
        """Forget it."""
        self._stall_s, self._reach_s = 0.0, None

    def heading(self, yaw_rad: float, from_rad: float, nav: NavState, dt_s: float) -> float:
        """The heading to steer. `from_rad`: where the wind comes from."""
        surge_mps, sway_mps = through_water(nav)
        drifts = surge_mps < _LEAST_MPS and abs(sway_mps) > _DRIFT_SHARE * abs(surge_mps)
        self._stall_s = self._stall_s + dt_s if drifts else 0.0
        if self._reach_s is None and self._stall_s > _STALL_S:
            self._reach_s = 0.0
        if self._reach_s is None:
            return yaw_rad
        self._reach_s += dt_s
        if surge_mps > _ENOUGH_MPS or self._reach_s > _REACH_S:
            self.reset()
            return yaw_rad
        off_rad, wanted_rad = wrap_pi(nav.yaw_rad - from_rad), wrap_pi(yaw_rad - from_rad)
        if off_rad * wanted_rad > 0.0 and abs(wanted_rad) > _REACH_RAD:
            return yaw_rad
        return wrap_pi(from_rad + math.copysign(_REACH_RAD, off_rad))
