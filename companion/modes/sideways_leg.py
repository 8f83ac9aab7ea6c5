"""A leg of a mission sailed by dynamic positioning, with a heading independent of the track."""

from __future__ import annotations

from companion.core.angles import wrap_pi
from companion.core.types import NavState
from companion.modes.station import Station

_STRAIGHT_RAD = 0.02


class SidewaysLeg:
    """`start`, then `update(nav)` every tick before the station's own. First the heading is taken up where the boat stops, then it goes.

    Remembers where it leads and whether it is under way; the station given does the moving.
    """

    def __init__(self, station: Station) -> None:
        self._station = station
        self._target = (0.0, 0.0, 0.0)
        self._speed_mps: float | None = None
        self._turning = False

    @property
    def arrived(self) -> bool:
        """The reference stands at the end of the leg."""
        return not self._turning and self._station.arrived

    def start(self, nav: NavState, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None) -> None:
        self._target, self._speed_mps = (north_m, east_m, yaw_rad), speed_mps
        self._turning = abs(wrap_pi(yaw_rad - nav.yaw_rad)) > _STRAIGHT_RAD
        if self._turning:
            self._station.stop_here(nav)
            self._station.turn_to(yaw_rad)
        else:
            self._go(nav, fresh=True)

    def update(self, nav: NavState) -> None:
        if self._turning and self._station.arrived:
            self._turning = False
            self._go(nav, fresh=False)

    def _go(self, nav: NavState, fresh: bool) -> None:
        self._station.go_to(nav, *self._target, self._speed_mps, fresh=fresh, sideways=True)
