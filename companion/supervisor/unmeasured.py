"""Says that position or heading are measured no more, long before that becomes a failsafe."""

from __future__ import annotations

import math

from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog

LATE_S = 1.5  # a receiver that sends once a second is heard by then


class Unmeasured:
    """`update(nav, armed, now_s)` once a tick. Remembers what is not measured, while the boat is armed, and when a
    sensor was last not used because it lies.

    Such a one has been told of by then (`sense_distrusted`), and its next value comes after it is trusted again.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._missing: set[str] = set()
        self._lied_s: dict[str, float] = {}

    def update(self, nav: NavState, armed: bool, now_s: float) -> None:
        """Announce what is measured no more, and what is measured again."""
        self._watch("position", nav.position_age_s, "dead reckoning", nav, armed, now_s)
        self._watch("heading", nav.heading_age_s, "by the gyro alone", nav, armed, now_s)

    def _watch(self, sense: str, age_s: float, instead: str, nav: NavState, armed: bool, now_s: float) -> None:
        if any(one.sense == sense and one.excluded for one in nav.distrusted):
            self._lied_s[sense] = now_s
        lied = now_s - self._lied_s.get(sense, -math.inf) < LATE_S
        missing = armed and LATE_S <= age_s < math.inf and not lied
        if missing and sense not in self._missing:
            self._missing.add(sense)
            text = f"{sense.capitalize()} not measured: {instead}"
            self._events.say(now_s, TextKind.ATTENTION, f"{sense}_unmeasured", text)
        elif sense in self._missing and (age_s < LATE_S or not armed):
            self._missing.discard(sense)
            if armed:
                text = f"{sense.capitalize()} is measured again"
                self._events.say(now_s, TextKind.ROUTINE, f"{sense}_unmeasured_over", text)
