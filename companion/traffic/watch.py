"""Conflicts: which vessels would come too near, what each of them is by the collision regulations, and the
announcements of that."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import Contact, NavState
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.params.store import Parameters
from companion.traffic import colreg, evasion
from companion.traffic.colreg import Encounter
from companion.traffic.tracker import TrafficTracker, contact

_MOST_CONTACTS = 24  # the nearest of those in reach
_FURTHER = 1.5  # times CA_TIME: the prediction goes on so far, to find the closest approach
_CLEAR_S = 8.0  # without a conflict, before a vessel is past and clear
_MARGIN_SHARE, _MARGIN_M = 0.2, 1.5  # of CA_DIST, and fixed: for errors of the boat's course and of the reports
_SIGMAS = 2.0
_MOVER_TIME_S = 40.0  # what a sensor sees moving is not predicted further
_MOVER_MORE_M = 2.0  # kept from it, beyond CP_DIST
_SAME_M = 10.0  # from the hull of a vessel: what a sensor sees there is that vessel
_TRIGGER_SHARE = 1.0 / 3.0  # of the margin: a way is planned with all of it, and given up below this


@dataclass(frozen=True, slots=True)
class Conflict:
    """A vessel that comes too near along the boat's way."""

    contact: Contact
    met: Encounter
    clear_m: float  # least clear water
    due_s: float  # time until it is too near

    @property
    def we_give_way(self) -> bool:
        """Whether this boat has to give way."""
        return colreg.gives_way(self.met, self.contact.status)


class TrafficWatch:
    """`contacts`, `conflicts` and `announce`, once a second.

    Remembers for each vessel in conflict what it was when the conflict began (it stays that until it is past and
    clear), and when it was last in conflict.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        tracker: TrafficTracker,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        movers: Callable[[float], Sequence[Contact]] = lambda _now_s: (),
    ) -> None:
        """`movers(now_s)`: what ranging sensors and a radar see moving."""
        self._parameters = parameters
        self._movers = movers
        self._tracker = tracker
        self._events = events
        self._frame = frame
        self._radius_m = 0.5 * math.hypot(config.length_m, config.beam_m)
        self._met: dict[int, tuple[Encounter, float, str]] = {}  # by MMSI: encounter, last time in conflict, name

    @property
    def radius_m(self) -> float:
        """Radius of the circle around this boat's hull."""
        return self._radius_m

    def margin_m(self, nav: NavState) -> float:
        """Distance that plans keep in addition to CA_DIST."""
        return _MARGIN_SHARE * self._parameters["CA_DIST"] + _MARGIN_M + _SIGMAS * nav.position_accuracy_m

    def trigger_m(self, nav: NavState) -> float:
        """Clear water below which a vessel is in conflict."""
        return self._parameters["CA_DIST"] + _TRIGGER_SHARE * self.margin_m(nav)

    def contacts(self, nav: NavState, speed_mps: float, now_s: float) -> list[Contact]:
        """The vessels that could come near within CA_TIME, the nearest first; at most 24."""
        frame, horizon_s = self._frame(), self._parameters["CA_TIME"]
        keep_m = self._parameters["CA_DIST"] + self.margin_m(nav)
        near: list[tuple[float, int, Contact]] = []
        targets = self._tracker.targets if self._parameters["CA_ACTION"] else ()
        vessels = [one for target in targets if (one := contact(target, frame, now_s)) is not None]
        for there in (*vessels, *self._sensed(vessels, now_s)):
            gap = math.hypot(there.north_m - nav.north_m, there.east_m - nav.east_m) - there.radius_m - self._radius_m
            if gap < keep_m + (speed_mps + there.speed_mps) * horizon_s:
                near.append((gap, there.mmsi, there))
        return [there for _, _, there in sorted(near)[:_MOST_CONTACTS]]

    def sees_movers(self, now_s: float) -> bool:
        """Whether a sensor sees anything move."""
        return bool(self._movers(now_s))

    def _sensed(self, vessels: Sequence[Contact], now_s: float) -> Iterator[Contact]:
        """What the sensors see moving and none of the vessels that count explains. The boat keeps CP_DIST and a little
        more from it, not all of CA_DIST, so its circle is smaller by the difference."""
        less_m = max(0.0, self._parameters["CA_DIST"] - max(0.0, self._parameters["CP_DIST"]) - _MOVER_MORE_M)
        for one in self._movers(now_s):
            near = (math.dist((one.north_m, one.east_m), (v.north_m, v.east_m)) - v.radius_m for v in vessels)
            if min(near, default=math.inf) > one.radius_m + _SAME_M:
                yield replace(one, radius_m=one.radius_m - less_m)

    def conflicts(
        self,
        nav: NavState,
        way: Sequence[evasion.Place],
        ramp: evasion.SpeedRamp,
        velocity: colreg.Velocity,
        contacts: Sequence[Contact],
        now_s: float,
    ) -> list[Conflict]:
        """The conflicts along `way`, the most urgent first. `velocity`: of the boat (north, east) in m/s, by which an
        encounter is judged."""
        horizon_s = self._parameters["CA_TIME"]
        t_s = evasion.time_steps(_FURTHER * horizon_s)
        places = evasion.places_along(way, ramp, t_s)
        trigger_m, found = self.trigger_m(nav), []
        for other in contacts:
            gaps = evasion.clear_water(places, t_s, other, self._radius_m)
            clear_m = float(gaps.min())
            due_s = float(t_s[int((gaps < trigger_m).argmax())]) if clear_m < trigger_m else math.inf
            if due_s <= (horizon_s if other.mmsi > 0 else min(horizon_s, _MOVER_TIME_S)):
                known = self._met.get(other.mmsi)
                met = colreg.encounter((nav.north_m, nav.east_m), velocity, other) if known is None else known[0]
                found.append(Conflict(other, met, clear_m, due_s))
        return sorted(found, key=lambda conflict: conflict.due_s)

    def announce(self, conflicts: Sequence[Conflict], now_s: float) -> None:
        """Announce new conflicts, and vessels that are past and clear."""
        for conflict in conflicts:
            if conflict.contact.mmsi not in self._met:
                duty = "" if conflict.we_give_way else "; it gives way"
                near = f"{max(0.0, conflict.clear_m):.0f} m in {conflict.due_s:.0f} s"
                text = f"Traffic: {conflict.contact.label} {conflict.met.value}, {near}{duty}"
                self._events.say(now_s, TextKind.ATTENTION, f"traffic_{conflict.met.name.lower()}", text)
            self._met[conflict.contact.mmsi] = conflict.met, now_s, conflict.contact.label
        for mmsi, (_, last_s, label) in list(self._met.items()):
            if now_s - last_s > _CLEAR_S:
                del self._met[mmsi]
                self._events.say(now_s, TextKind.ROUTINE, "traffic_clear", f"Traffic: clear of {label}")

    def extend(self, now_s: float) -> None:
        """Keep all conflicts alive: while the boat avoids them, none of them is past and clear."""
        self._met = {mmsi: (met, now_s, label) for mmsi, (met, _, label) in self._met.items()}

    def forget(self) -> None:
        """Forget all conflicts, without an announcement."""
        self._met.clear()
