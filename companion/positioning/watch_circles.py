"""Circles around the hold point: outside the inner one the boat warns, outside the outer one it raises an alarm."""

from __future__ import annotations

from companion.core.decision import TextKind
from companion.core.events import EventLog
from companion.params.store import Parameters

_BACK_INSIDE = 0.8  # of a circle's radius


class WatchCircles:
    """`update(off_m, now_s)` while a point is held. Announces once when the boat leaves a circle and when it is back.

    Remembers which circles the boat is outside of. Radii: DP_WATCH_R and DP_ALARM_R.
    """

    def __init__(self, parameters: Parameters, events: EventLog, name: str = "Hold") -> None:
        """`name`: the mode that holds, for the texts."""
        self._name = name
        self._parameters = parameters
        self._events = events
        self._outside = self._alarmed = False

    @property
    def left(self) -> bool:
        """Whether the boat is outside the watch circle."""
        return self._outside

    @property
    def alarmed(self) -> bool:
        """Whether the boat is outside the alarm circle."""
        return self._alarmed

    def reset(self) -> None:
        """Another point is held: forget which circles the boat was outside of."""
        self._outside = self._alarmed = False

    def update(self, off_m: float, now_s: float) -> None:
        """`off_m`: distance of the boat from the hold point."""
        warn_m, alarm_m = self._parameters["DP_WATCH_R"], self._parameters["DP_ALARM_R"]
        if not self._outside and off_m > warn_m:
            self._outside = True
            self._events.say(
                now_s,
                TextKind.ATTENTION,
                "watch_circle_left",
                f"{self._name}: {off_m:.1f} m off, outside the watch circle",
            )
        elif self._outside and off_m < _BACK_INSIDE * warn_m:
            self._outside = False
            self._events.say(
                now_s, TextKind.ROUTINE, "watch_circle_back", f"{self._name}: back inside the watch circle"
            )
        if not self._alarmed and off_m > alarm_m:
            self._alarmed = True
            self._events.say(
                now_s, TextKind.ALARM, "watch_alarm", f"{self._name}: {off_m:.1f} m off, outside the alarm circle"
            )
        elif self._alarmed and off_m < _BACK_INSIDE * alarm_m:
            self._alarmed = False
            self._events.say(now_s, TextKind.ROUTINE, "watch_alarm_over", f"{self._name}: back inside the alarm circle")
