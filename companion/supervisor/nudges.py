"""Small corrections in Hold: metres and degrees relative to the hold point, or a heading."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config.vessel import VesselConfig
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.modes.hold import HoldMode
from companion.params.store import Parameters
from companion.supervisor.helm import Helm


class Nudges:
    """Requests between ticks, each answered with an outcome. Remembers nothing."""

    def __init__(
        self, config: VesselConfig, parameters: Parameters, helm: Helm, hold: HoldMode, events: EventLog
    ) -> None:
        self._can_sway = config.limits.sway_n > 0.0
        self._parameters = parameters
        self._helm = helm
        self._hold = hold
        self._events = events

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float, nav: NavState, now_s: float) -> Outcome:
        """Move the hold point ahead and to starboard along the held heading, and turn that heading to starboard."""
        if not math.isfinite(forward_m + starboard_m + turn_rad):
            return self._refuse(Result.DENIED, "not a number", now_s)
        way_m, most_m = math.hypot(forward_m, starboard_m), self._parameters["DP_NUDGE_MAX"]
        if way_m > most_m:
            return self._refuse(Result.DENIED, f"{way_m:.1f} m, DP_NUDGE_MAX is {most_m:g} m", now_s)
        turn_deg, most_deg = math.degrees(abs(turn_rad)), self._parameters["DP_NUDGE_YAW"]
        if turn_deg > most_deg + 1e-6:
            return self._refuse(Result.DENIED, f"{turn_deg:.0f} deg, DP_NUDGE_YAW is {most_deg:g} deg", now_s)
        text = f"Nudge {forward_m:+.2f} m ahead, {starboard_m:+.2f} m to starboard, {math.degrees(turn_rad):+.0f} deg"
        return self._done(lambda: self._hold.nudge(forward_m, starboard_m, turn_rad), text, nav, now_s)

    def head(self, yaw_rad: float, nav: NavState, now_s: float) -> Outcome:
        """Hold this heading at the same point."""
        if not math.isfinite(yaw_rad):
            return self._refuse(Result.DENIED, "not a heading", now_s)
        text = f"Heading {math.degrees(yaw_rad) % 360.0:.0f} deg"
        return self._done(lambda: self._hold.head(yaw_rad), text, nav, now_s)

    def _done(self, step: Callable[[], str | None], text: str, nav: NavState, now_s: float) -> Outcome:
        helm = self._helm
        if helm.mode is not self._hold:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"{helm.mode.id.value} is not Hold", now_s)
        if not helm.armed:
            return self._refuse(Result.TEMPORARILY_REJECTED, "arm first", now_s)
        if not self._can_sway:
            return self._refuse(Result.DENIED, "this boat has no sideways thrust", now_s)
        if (reason := helm.refusal(self._hold.id, nav, now_s) or helm.guarded(self._hold, step, now_s)) is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, reason, now_s)
        self._events.say(now_s, TextKind.ROUTINE, "nudge", text)
        return ACCEPTED

    def _refuse(self, result: Result, reason: str, now_s: float) -> Outcome:
        text = f"Nudge refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(result, text)
