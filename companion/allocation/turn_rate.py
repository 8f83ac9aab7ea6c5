"""How fast a thruster really turns, learned from its reports: a nozzle may be slower than the vessel's file says."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi

_LAG_S = 0.25  # with which a steering gear closes the last of its way: farther off, its rate is what limits it
_SPAN_S = 0.3  # over which a rate is measured; no less than the time from a command to the motion that is reported
_SHORT_SPAN_S = 0.2  # the same, where the thruster then comes close to the command
_LEARN_S = 0.6
_LAGGING_SHARE = 0.4  # of the rate at which such a gear closes its way: what turns more slowly is at its limit
_LEAST_WAY_RAD = math.radians(5.0)  # beyond play
_STANDS_SHARE = 0.08  # of the configured rate: what turns more slowly is stuck, not slow
_CHANGED_SHARE = 0.1  # of the rate: a change that matters
_SETTLED_SHARE = 0.2  # of a measured rate: so near to it, the next one confirms it
_SLOW_SHARE = 0.8  # of the configured rate


class TurnRate:
    """Commands and reports of one thruster → its rate of turn.

    `rate_radps` is never above the configured rate. A rate counts while the command is so far ahead that a gear with a
    short lag would turn at its full rate, or much faster than this one does: all over the span and on average over the
    one before, since the motion follows the command with a delay. Remembers the rate, the last measurement and whether
    it confirms the one before, the rate used last, the last report, and of the present span its length, its way and by
    how much the command was ahead, on average of the span before too.
    """

    __slots__ = (
        "_ahead_before_rad",
        "_ahead_rad_s",
        "_configured_radps",
        "_last",
        "_least_rad",
        "_seen_radps",
        "_side",
        "_span_s",
        "_used_radps",
        "_way_rad",
        "rate_radps",
        "settled",
    )

    def __init__(self, configured_radps: float) -> None:
        self._configured_radps = configured_radps
        self.begin_anew()

    def begin_anew(self) -> None:
        """Take the configured rate for true again."""
        self.rate_radps = self._used_radps = self._configured_radps
        self.settled = False
        self._seen_radps = 0.0
        self._last: tuple[float, float] | None = None  # time and azimuth of the last report
        self._least_rad = math.inf
        self._restart(0.0)

    @property
    def slow(self) -> bool:
        """Whether it turns markedly slower than configured, and a further measurement confirms it."""
        return self.settled and self.rate_radps < _SLOW_SHARE * self._configured_radps

    def update(self, command_rad: float, measured_rad: float, t_s: float) -> bool:
        """Take a report of time `t_s` and the command before it; returns whether the rate has changed markedly."""
        last, self._last = self._last, (t_s, measured_rad)
        if last is None or not 0.0 < t_s - last[0] <= _SPAN_S:
            if last is None or t_s != last[0]:
                self._restart(0.0)
            return False
        dt_s, ahead_rad = t_s - last[0], wrap_pi(command_rad - last[1])
        side = math.copysign(1.0, ahead_rad)
        if abs(ahead_rad) < min(_LEAST_WAY_RAD, _LAG_S * self.rate_radps) or side != self._side:
            changed = self._span_s >= _SHORT_SPAN_S and self._end_span()
            self._restart(side)
            return changed
        self._span_s += dt_s
        self._ahead_rad_s += dt_s * abs(ahead_rad)
        self._least_rad = min(self._least_rad, abs(ahead_rad))
        self._way_rad += side * wrap_pi(measured_rad - last[1])
        return self._span_s >= _SPAN_S and self._end_span()

    def _restart(self, side: float) -> None:
        self._side, self._span_s, self._way_rad = side, 0.0, 0.0
        self._ahead_rad_s = 0.0
        self._least_rad = math.inf
        self._ahead_before_rad = math.nan  # the motion of the first span may begin late

    def _end_span(self) -> bool:
        span_s, seen_radps, least_rad = self._span_s, self._way_rad / self._span_s, self._least_rad
        before_rad, self._ahead_before_rad = self._ahead_before_rad, self._ahead_rad_s / span_s
        self._span_s = self._ahead_rad_s = self._way_rad = 0.0
        self._least_rad = math.inf
        if seen_radps < _STANDS_SHARE * self._configured_radps:
            return False
        if math.isnan(before_rad):
            self._seen_radps = seen_radps
            return False
        return self._learn(seen_radps, span_s, min(before_rad, least_rad))

    def _learn(self, seen_radps: float, span_s: float, ahead_rad: float) -> bool:
        if ahead_rad < _LAG_S * min(self.rate_radps, seen_radps / _LAGGING_SHARE):  # what the rate limits, no lag can
            return False
        before = self._seen_radps
        self._seen_radps = seen_radps
        self.settled = abs(seen_radps - before) < _SETTLED_SHARE * seen_radps
        share = 1.0 - math.exp(-span_s / _LEARN_S)
        step = 0.5 * (before + seen_radps) - self.rate_radps if self.settled else share * (seen_radps - self.rate_radps)
        self.rate_radps = min(self._configured_radps, self.rate_radps + step)
        changed = abs(self.rate_radps - self._used_radps) >= _CHANGED_SHARE * self._used_radps
        if changed:
            self._used_radps = self.rate_radps
        return changed
