"""Home: set at the first valid position, moved on request, by the mission, or at arming with HOME_ON_ARM."""

from __future__ import annotations

import math

from companion.core.decision import Home, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog


def is_on_earth(lat_deg: float, lon_deg: float) -> bool:
    """Whether these degrees are a position."""
    return math.isfinite(lat_deg) and math.isfinite(lon_deg) and abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0


class HomeKeeper:
    """Remembers home; None until there was a valid position."""

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.home: Home | None = None

    def update(self, nav: NavState, now_s: float) -> None:
        """Set home at the first valid position."""
        if self.home is None and nav.position_valid:
            self.set_here(nav, now_s)

    def set_here(self, nav: NavState, now_s: float) -> bool:
        """Set home at the boat's position. False while that is not valid."""
        if not nav.position_valid:
            return False
        yaw_rad = nav.yaw_rad if nav.heading_valid else None
        self.home = Home(nav.lat_deg, nav.lon_deg, nav.altitude_m, yaw_rad)
        self._events.say(now_s, TextKind.ROUTINE, "home_set", "Home set here")
        return True

    def set(self, home: Home, now_s: float) -> bool:
        """Set home there. False if that is not a position."""
        if not is_on_earth(home.lat_deg, home.lon_deg):
            return False
        self.home = home
        self._events.say(now_s, TextKind.ROUTINE, "home_set", f"Home set to {home.lat_deg:.6f}, {home.lon_deg:.6f}")
        return True
