"""A leg of a mission sailed by dynamic positioning, with a heading independent of the track."""

from __future__ import annotations

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.positioning.hold_point import HoldPoint

_STRAIGHT_RAD = 0.02


class SidewaysLeg:
    """Call `start`, then `update(nav)` every tick before the hold point's own update. The boat stops and turns to the
    heading first, then moves along the leg.

    Remembers the leg's end and whether the boat still turns. The hold point moves the boat.
    """

    def __init__(self, hold_point: HoldPoint) -> None:
        self._hold_point = hold_point
        self._target = (0.0, 0.0, 0.0)
        self._speed_mps: float | None = None
        self._turning = False

    @property
    def arrived(self) -> bool:
        """Whether the reference has come to rest at the end of the leg."""
        return not self._turning and self._hold_point.arrived

    def start(self, nav: NavState, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None:
        """Begin a leg to this pose. `speed_mps` None: at the set speed."""
        self._target, self._speed_mps = (north_m, east_m, yaw_rad), speed_mps
        self._turning = abs(wrap_pi(yaw_rad - nav.yaw_rad)) > _STRAIGHT_RAD
        if self._turning:
            self._hold_point.stop_here(nav)
            self._hold_point.turn_to(yaw_rad)
        else:
            self._go(nav, fresh=True)

    def update(self, nav: NavState) -> None:
        """Start moving once the heading is reached."""
        if self._turning and self._hold_point.arrived:
            self._turning = False
            self._go(nav, fresh=False)

    def _go(self, nav: NavState, fresh: bool) -> None:
        self._hold_point.go_to(nav, *self._target, self._speed_mps, fresh=fresh, sideways=True)
