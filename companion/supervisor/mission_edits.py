"""Changes of the mission by the transmitter: a waypoint where the boat is, and an empty mission.

Whoever stores plans takes each change from here, and says what became of it. So a waypoint that was announced is on the
medium, as an uploaded mission is.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from companion.core.decision import ACCEPTED, ModeId, Outcome, Result, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.mission.commands import Command
from companion.mission.plan import PlanItem, PlanKind, PlanRefusal, Plans
from companion.mission.validation import CAPACITY
from companion.supervisor.helm import Helm

_GLOBAL_RELATIVE_ALT = 3  # MAV_FRAME
_MOST_WAITING = 8  # changes: a switch is thrown by hand


class MissionEdits:
    """`save_waypoint` and `clear` ask for a change; `due()` → the items of the mission as it should be, or None;
    `settled(refusal, now_s)` when they are in force or refused.

    Remembers the changes to come, each a waypoint or None for an empty mission, and the items that are on their way.
    """

    def __init__(self, plans: Plans, helm: Helm, events: EventLog) -> None:
        self._plans = plans
        self._helm = helm
        self._events = events
        self._waiting: deque[PlanItem | None] = deque()
        self._under_way: tuple[PlanItem, ...] | None = None

    def save_waypoint(self, nav: NavState, now_s: float) -> Outcome:
        """Append a waypoint where the boat is, in any mode but Mission."""
        reason = self._refusal()
        if reason is None and not nav.position_valid:
            reason = "position not valid"
        elif reason is None and len(self._plans.items(PlanKind.MISSION)) >= CAPACITY:
            reason = "mission is full"
        if reason is not None:
            return self._refuse(f"Waypoint refused: {reason}", now_s)
        x, y = round(nav.lat_deg * 1e7), round(nav.lon_deg * 1e7)
        frame, here = _GLOBAL_RELATIVE_ALT, (x, y, 0.0)
        self._waiting.append(PlanItem(0, Command.NAV_WAYPOINT, frame, 0.0, 0.0, 0.0, math.nan, *here))
        return ACCEPTED

    def clear(self, now_s: float) -> Outcome:
        """Empty the mission, in any mode but Mission."""
        if (reason := self._refusal()) is not None:
            return self._refuse(f"Clear mission refused: {reason}", now_s)
        self._waiting.append(None)
        return ACCEPTED

    def due(self) -> tuple[PlanItem, ...] | None:
        """The mission with the next change; None while there is none, or one is on its way."""
        if self._under_way is not None or not self._waiting:
            return None
        items, item = self._plans.items(PlanKind.MISSION), self._waiting.popleft()
        self._under_way = () if item is None else (*items, replace(item, seq=len(items)))
        return self._under_way

    @property
    def under_way(self) -> bool:
        """Whether a change has been taken and is not settled."""
        return self._under_way is not None

    def settled(self, refusal: PlanRefusal | None, now_s: float) -> None:
        """The change is in force and stored, or refused."""
        items, self._under_way = self._under_way, None
        if refusal is not None:
            what = "Waypoint" if items else "Clear mission"
            self._refuse(f"{what} refused: {refusal.text}", now_s)
        elif items:
            self._events.say(now_s, TextKind.ROUTINE, "waypoint_saved", f"Waypoint saved: item {items[-1].number}")
        else:
            self._events.say(now_s, TextKind.ROUTINE, "mission_cleared", "Mission cleared by the transmitter")

    def _refusal(self) -> str | None:
        if self._helm.mode.id is ModeId.MISSION:
            return "the boat is in Mission"
        return "earlier ones are still being stored" if len(self._waiting) >= _MOST_WAITING else None

    def _refuse(self, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, TextKind.REFUSAL, "mission_edit_refused", text)
        return Outcome(Result.TEMPORARILY_REJECTED, text)
