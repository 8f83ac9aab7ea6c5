"""Which of the vessels around would come too near, what each of them is by the collision regulations, and that it is said."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.types import Contact, NavState, Severity
from companion.guidance import colreg, evasion
from companion.guidance.colreg import Encounter
from companion.modes.events import EventLog
from companion.nav.traffic import TrafficTracker, contact
from companion.params import Parameters

_MOST_CONTACTS = 24  # the nearest of those in reach
_FURTHER = 1.5  # times CA_TIME: how near a vessel will come that is too near by then
_CLEAR_S = 8.0  # without a conflict before a vessel is past and clear
_MARGIN_SHARE, _MARGIN_M = 0.2, 1.5  # of CA_DIST, and for what the boat's own course and the other's report are off
_SIGMAS = 2.0
_TRIGGER_SHARE = 1.0 / 3.0  # of the margin: a way is planned with all of it and given up with this


@dataclass(frozen=True, slots=True)
class Conflict:
    """A vessel that comes nearer than it should along the boat's way: how near (clear water), and after how long it is too near."""

    contact: Contact
    met: Encounter
    clear_m: float
    due_s: float

    @property
    def gives_way(self) -> bool:
        """This boat does."""
        return colreg.gives_way(self.met, self.contact.status)


class TrafficWatch:
    """Remembers what each vessel in conflict was when the conflict began (it stays that until past and clear), and when it last was in one."""

    def __init__(
        self, config: VesselConfig, parameters: Parameters, tracker: TrafficTracker, events: EventLog, frame: Callable[[], LocalFrame]
    ) -> None:
        self._parameters = parameters
        self._tracker = tracker
        self._events = events
        self._frame = frame
        self._radius_m = 0.5 * math.hypot(config.length_m, config.beam_m)
        self._met: dict[int, tuple[Encounter, float, str]] = {}  # MMSI: what it is, when last in conflict, its name

    @property
    def radius_m(self) -> float:
        """Of the circle around this boat."""
        return self._radius_m

    def margin_m(self, nav: NavState) -> float:
        """What plans keep besides CA_DIST."""
        return _MARGIN_SHARE * self._parameters["CA_DIST"] + _MARGIN_M + _SIGMAS * nav.position_accuracy_m

    def trigger_m(self, nav: NavState) -> float:
        """Clear water below which something must be done."""
        return self._parameters["CA_DIST"] + _TRIGGER_SHARE * self.margin_m(nav)

    def contacts(self, nav: NavState, speed_mps: float, now_s: float) -> list[Contact]:
        """The vessels that could come near within CA_TIME, the nearest first."""
        frame, horizon_s, keep_m = self._frame(), self._parameters["CA_TIME"], self._parameters["CA_DIST"] + self.margin_m(nav)
        near: list[tuple[float, int, Contact]] = []
        for target in self._tracker.targets:
            there = contact(target, frame, now_s)
            if there is None:
                continue
            gap = math.hypot(there.north_m - nav.north_m, there.east_m - nav.east_m) - there.radius_m - self._radius_m
            if gap < keep_m + (speed_mps + there.speed_mps) * horizon_s:
                near.append((gap, there.mmsi, there))
        return [there for _, _, there in sorted(near)[:_MOST_CONTACTS]]

    def conflicts(
        self, nav: NavState, way: Sequence[evasion.Place], pace: evasion.Pace, velocity: colreg.Velocity, contacts: Sequence[Contact], now_s: float
    ) -> list[Conflict]:
        """Along `way`, the most urgent first. `velocity`: of the boat, by which an encounter is judged."""
        horizon_s = self._parameters["CA_TIME"]
        t_s = evasion.times(_FURTHER * horizon_s)
        places = evasion.travel(way, pace, t_s)
        trigger_m, found = self.trigger_m(nav), []
        for other in contacts:
            gaps = evasion.clear_water(places, t_s, other, self._radius_m)
            clear_m = float(gaps.min())
            due_s = float(t_s[int((gaps < trigger_m).argmax())]) if clear_m < trigger_m else math.inf
            if due_s <= horizon_s:
                known = self._met.get(other.mmsi)
                met = colreg.encounter((nav.north_m, nav.east_m), velocity, other) if known is None else known[0]
                found.append(Conflict(other, met, clear_m, due_s))
        return sorted(found, key=lambda conflict: conflict.due_s)

    def tell(self, conflicts: Sequence[Conflict], now_s: float) -> None:
        """Say what is new and what is over."""
        for conflict in conflicts:
            if conflict.contact.mmsi not in self._met:
                duty = "" if conflict.gives_way else ", which has to give way"
                text = f"Traffic: {conflict.contact.label} {conflict.met.value}, {max(0.0, conflict.clear_m):.0f} m in {conflict.due_s:.0f} s{duty}"
                self._events.say(now_s, Severity.WARNING, f"traffic_{conflict.met.name.lower()}", text)
            self._met[conflict.contact.mmsi] = conflict.met, now_s, conflict.contact.label
        for mmsi, (_, last_s, label) in list(self._met.items()):
            if now_s - last_s > _CLEAR_S:
                del self._met[mmsi]
                self._events.say(now_s, Severity.INFO, "traffic_clear", f"Traffic: clear of {label}")

    def keep_in_mind(self, now_s: float) -> None:
        """While the boat is off its route for them, none of them is past and clear."""
        self._met = {mmsi: (met, now_s, label) for mmsi, (met, _, label) in self._met.items()}

    def forget(self) -> None:
        self._met.clear()
