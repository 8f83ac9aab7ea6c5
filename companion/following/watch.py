"""Whether the data that Follow steers by are good: the leader's position and the boat's own."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from statistics import median_high

from companion.core.estimate import NavState
from companion.core.readings import LeaderState, Wish
from companion.following.doubt import LeaderDoubt
from companion.params.store import Parameters

_LEAST_S = 0.5  # shorter outages are tolerated
_MOST_S = 4.0  # a leader heard less often than every 1.3 s cannot be followed
_MISSED = 3.0  # a position may be late by as many intervals
_REMEMBERED = 8
_TOGETHER = 0.2  # share of the median interval below which two came together
_SAME_S = 1e-3  # times that differ by rounding only
_LONGEST_STEP_S = 0.25


class Rhythm:
    """`see(t_s)` each position. `interval_s`: how often a source sends. Losses lengthen intervals, so it is the second
    shortest of the last 8. Two that came together do not count: MAVSDK sends each new target at once, and again at its
    usual time."""

    def __init__(self) -> None:
        self._intervals_s: deque[float] = deque(maxlen=_REMEMBERED)
        self.last_s = -math.inf

    def see(self, t_s: float) -> None:
        """A position. One that is not newer than the last is ignored."""
        if t_s <= self.last_s + _SAME_S:
            return
        if math.isfinite(self.last_s):
            self._intervals_s.append(t_s - self.last_s)
        self.last_s = t_s

    @property
    def interval_s(self) -> float | None:
        """None before the second position."""
        if not self._intervals_s:
            return None
        least_s = _TOGETHER * median_high(self._intervals_s)
        return sorted(interval_s for interval_s in self._intervals_s if interval_s >= least_s)[:2][-1]


class LeaderWatch:
    """`heard(state)` each message of the leader, `update(nav, now_s)` once a tick; then `fault` and `good_s`.

    Data count as lost before they are older than FOLL_LOSS_T, or three of their source's intervals where that is
    longer: a tick early, so that the boat is out of Follow by then whatever its control rate. A leader module sends at
    20 Hz, and FOLL_LOSS_T alone counts. In a tick that comes late, the delay is not the leader's: its packets wait.
    Remembers the leader, when it was heard, how often positions come, and since when all has been good.
    """

    def __init__(self, parameters: Parameters, leads: Callable[[int], bool]) -> None:
        """`leads(system_id)`: whether that system may lead."""
        self._parameters = parameters
        self._leads = leads
        self._theirs = Rhythm()
        self._ours = Rhythm()
        self._doubt = LeaderDoubt()
        self._step_s = self._delay_s = 0.0
        self._tick_s: float | None = None
        self._good_since_s: float | None = None
        self.system_id: int | None = None
        self.heard_s = -math.inf
        self.wish: Wish | None = None  # None: no module speaks

    def heard(self, state: LeaderState) -> None:
        """A message of the leader. Another leader begins anew."""
        if state.system_id != self.system_id:
            self.system_id, self.wish = state.system_id, None
            self._theirs = Rhythm()
            self._doubt = LeaderDoubt()
            self._good_since_s = None
        self.heard_s = max(self.heard_s, state.heard_s)
        if state.wish is not None:
            self.wish = state.wish
        if state.lat_deg is not None and state.lon_deg is not None:
            self._theirs.see(min(state.t_s, state.heard_s))
            self._doubt.see(state)

    def update(self, nav: NavState, now_s: float) -> None:
        """Call after the newest estimate is in."""
        if self._tick_s is not None:
            passed_s = max(0.0, now_s - self._tick_s)
            self._step_s = min(_LONGEST_STEP_S, passed_s)
            self._delay_s = passed_s - self._step_s
        self._tick_s = now_s
        if math.isfinite(nav.position_age_s):
            self._ours.see(nav.t_s - nav.position_age_s)
        if self.fault(nav, now_s) is not None:
            self._good_since_s = None
        elif self._good_since_s is None:
            self._good_since_s = now_s

    @property
    def jump_m(self) -> float | None:
        """How far the leader has jumped since a person last chose to follow it; None where it has not."""
        return self._doubt.jump_m

    def forget_jump(self) -> None:
        """A person has chosen to follow it all the same."""
        self._doubt.forget_jump()

    def good_s(self, now_s: float) -> float:
        """For how long there has been no fault, s."""
        return 0.0 if self._good_since_s is None else now_s - self._good_since_s

    def fault(self, nav: NavState, now_s: float) -> str | None:
        """Why the leader cannot be followed at this moment, for people; None while it can."""
        chosen = int(self._parameters["FOLL_SYSID"])
        if self.system_id is None or not self._leads(self.system_id):
            return f"leader {chosen} not heard" if chosen else "no leader heard"
        read_s = now_s - self._delay_s
        age_s, silent_s = read_s - self._theirs.last_s, read_s - self.heard_s
        if age_s > self._limit_s(self._theirs.interval_s, module=self.wish is not None):
            if silent_s > 0.5 * age_s or silent_s > _MOST_S:
                return f"leader silent for {silent_s:.1f} s"
            return f"leader without a position for {age_s:.1f} s" if math.isfinite(age_s) else "leader has no position"
        if self._theirs.interval_s is None:
            return "leader has only just been heard"
        if (doubt := self._doubt.text(now_s)) is not None:
            return doubt
        own_s = nav.position_age_s + now_s - nav.t_s
        if own_s > self._limit_s(self._ours.interval_s, module=False):
            return f"own position {own_s:.1f} s old" if math.isfinite(own_s) else "own position not known"
        return None

    def _limit_s(self, interval_s: float | None, module: bool) -> float:
        longest_s = self._parameters["FOLL_LOSS_T"]
        if interval_s is not None and not module:
            longest_s = max(longest_s, min(_MOST_S, _MISSED * interval_s))
        return max(_LEAST_S, longest_s - self._step_s)
