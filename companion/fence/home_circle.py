"""The circle around home that the boat must not leave: GF_MAX_HOR_DIST, with PX4's meaning."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from companion.core.decision import Home, TextKind
from companion.core.events import EventLog
from companion.core.geodesy import distance_and_bearing
from companion.fence.zones import FenceZone
from companion.mission.commands import DESTINATIONS, Command
from companion.mission.plan import PlanItem
from companion.params.store import Parameters

PARAMETER = "GF_MAX_HOR_DIST"
_NO_SEQ = -1  # it is no item of a plan


class HomeCircle:
    """`zone` is the circle now: it moves with home. `announce(now_s)` once a tick says what changed. Remembers what was
    said last."""

    def __init__(self, parameters: Parameters, home: Callable[[], Home | None], events: EventLog) -> None:
        self._parameters = parameters
        self._home = home
        self._events = events
        self._said: FenceZone | None = None
        self._missed = False

    @property
    def wanted(self) -> bool:
        """Whether there is to be a circle, with or without a home; not while the fence is off."""
        return self._parameters[PARAMETER] > 0.0 and self._parameters["GF_ACTION"] != 0

    @property
    def zone(self) -> FenceZone | None:
        """The circle; None if none is wanted, or without a home."""
        if not self.wanted or (home := self._home()) is None:
            return None
        return FenceZone(_NO_SEQ, True, 0, ((home.lat_deg, home.lon_deg),), self._parameters[PARAMETER])

    def announce(self, now_s: float) -> None:
        """Say that the circle is new, has moved or is gone, or that it waits for a home."""
        zone, missed = self.zone, self.wanted and self._home() is None
        if missed and not self._missed:
            self._events.say(now_s, TextKind.ATTENTION, "home_circle", "No home yet: its fence circle is not enforced")
        elif zone != self._said:
            text = "Fence circle around home is off" if zone is None else f"Fence: within {zone.radius_m:g} m of home"
            self._events.say(now_s, TextKind.ROUTINE, "home_circle", text)
        self._said, self._missed = zone, missed


def as_item(home: tuple[float, float], radius_m: float, seq: int) -> PlanItem:
    """The circle as an item of a fence. `home`: (lat_deg, lon_deg)."""
    x, y = (round(degrees * 1e7) for degrees in home)
    return PlanItem(seq, Command.FENCE_CIRCLE_INCLUSION, 0, radius_m, 0.0, 0.0, 0.0, x, y, 0.0)


def beyond(items: Sequence[PlanItem], home: tuple[float, float], radius_m: float, kept_m: float) -> Iterator[str]:
    """What is wrong with each destination of a mission that is not inside the circle by `kept_m`. `home`: (lat_deg,
    lon_deg)."""
    for item in items:
        if item.command in DESTINATIONS:
            distance_m, _ = distance_and_bearing(*home, item.lat_deg, item.lon_deg)
            if distance_m > radius_m - kept_m:
                yield f"item {item.number}: {distance_m:.0f} m from home; {PARAMETER} is {radius_m:g} m"
