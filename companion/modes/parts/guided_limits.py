"""Limits of one stay in Offboard: how long, and how far from where it began. Source: MAV_CMD_DO_GUIDED_LIMITS."""

from __future__ import annotations

import math

from companion.core.estimate import NavState


class GuidedLimits:
    """`reached`: the limit that was reached, for people; None while there is none. Remembers the limits, and when and
    where the stay began."""

    def __init__(self) -> None:
        self.reached: str | None = None
        self._most_s = self._most_m = math.inf
        self._begun: tuple[float, float, float] | None = None

    def set(self, most_s: float | None, most_m: float | None) -> None:
        """Limits for this stay, or the next; None: no limit. They count from the beginning of the stay."""
        self._most_s = math.inf if most_s is None else most_s
        self._most_m = math.inf if most_m is None else most_m
        self.reached = None

    def begin(self, nav: NavState, now_s: float) -> None:
        """A stay begins here. One that begins after a limit was reached has none."""
        if self.reached is not None:
            self.end()
        self._begun, self.reached = (now_s, nav.north_m, nav.east_m), None

    def go_on(self, nav: NavState, now_s: float) -> None:
        """The stay goes on after an interruption; after a limit was reached, another one begins."""
        if self._begun is None or self.reached is not None:
            self.begin(nav, now_s)

    def watch(self, nav: NavState, now_s: float) -> None:
        """Once a tick during the stay."""
        if self._begun is None or self.reached is not None:
            return
        begun_s, north_m, east_m = self._begun
        if now_s - begun_s > self._most_s:
            self.reached = f"limit of {self._most_s:g} s reached"
        elif math.hypot(nav.north_m - north_m, nav.east_m - east_m) > self._most_m:
            self.reached = f"limit of {self._most_m:g} m reached"

    def end(self) -> None:
        """The stay is over, and its limits with it. What was reached is known until the next one."""
        self._begun = None
        self._most_s = self._most_m = math.inf
