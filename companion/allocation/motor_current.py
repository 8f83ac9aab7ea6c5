"""Supervision of one motor's current: does it draw what its propeller needs at this throttle?

Torque and thrust grow with the square of the revolutions, power with the cube; throttle is in proportion to them. So a
sound motor draws `full_a`·|u|³ from its supply, a little less with way on. One whose propeller is blocked or fouled
draws much more, one that has lost its propeller or its coupling much less. Source: Fossen 2021, 9.1
(Q = ρ D⁵ K_Q n|n|).
"""

from __future__ import annotations

from enum import Enum

_FLOOR = 0.08  # of the full current: idle current and resolution of the sensor
_LOST_SHARE = 0.25  # of the least expected current, below which nothing loads the motor
_TOLD_SHARE = 0.1  # of the full current, from which on a motor without load shows


class LoadFault(Enum):
    """What the current of a motor tells of its propeller; the value is for people."""

    BLOCKED = "blocked or fouled"
    UNLOADED = "no load on the motor"


class CurrentSupervision:
    """Call `update` once a tick.

    The expected current lies in a band: its edges are those of the present throttle and of where it comes from, which
    fades with the lag of a propeller. A fault is declared once the current has been outside for long enough, and lasts
    for `retry_s`, or until the boat is armed or disarmed (`retry_s` 0: until that alone). Remembers the band, how long
    the current has been outside, and the fault with its time.
    """

    __slots__ = ("_armed", "_fault_s", "_full_a", "_high", "_last_s", "_low", "_off_s", "_throttle", "fault")

    def __init__(self, full_a: float) -> None:
        """`full_a`: current at full throttle with the boat at rest, A."""
        self._full_a = full_a
        self.fault: LoadFault | None = None
        self._armed = False
        self._low = self._high = self._throttle = self._off_s = self._fault_s = 0.0
        self._last_s: float | None = None

    def update(
        self,
        throttle: float,
        armed: bool,
        current_a: float | None,
        tolerance: float,
        times_s: tuple[float, float, float],
        now_s: float,
    ) -> LoadFault | None:
        """The fault, or None. `throttle` (−1…1): as commanded; `current_a`: as measured, None where it is old or not
        measured; `tolerance`: times the expected current that is tolerated; `times_s`: lag of a propeller, how long
        outside is a fault, and after which time a thruster is tried again (0: at the next arming)."""
        lag_s, after_s, retry_s = times_s
        dt_s = 0.0 if self._last_s is None else max(0.0, now_s - self._last_s)
        self._last_s = now_s
        over = self.fault is not None and 0.0 < retry_s <= now_s - self._fault_s
        if over or armed is not self._armed:
            self.fault, self._off_s = None, 0.0
        self._armed = armed
        self._follow(throttle if armed else 0.0, lag_s, dt_s)
        if current_a is None or not armed or self.fault is not None:
            self._off_s = 0.0
            return self.fault
        found = self._judged(current_a, tolerance)
        self._off_s = self._off_s + dt_s if found is not None else max(0.0, self._off_s - dt_s)
        if found is not None and self._off_s >= after_s:
            self.fault, self._fault_s = found, now_s
        return self.fault

    def _follow(self, throttle: float, lag_s: float, dt_s: float) -> None:
        """Move the band of |throttle|; a propeller that turns round comes through rest."""
        share, size = dt_s / (lag_s + dt_s), abs(throttle)
        low = 0.0 if throttle * self._throttle < 0.0 else self._low
        self._throttle = throttle
        self._low = size if size < low else low + (size - low) * share
        self._high = size if size > self._high else self._high + (size - self._high) * share

    def _judged(self, current_a: float, tolerance: float) -> LoadFault | None:
        least_a, most_a = self._full_a * self._low**3, self._full_a * self._high**3
        if current_a > tolerance * most_a + _FLOOR * self._full_a:
            return LoadFault.BLOCKED
        if least_a > _TOLD_SHARE * self._full_a and current_a < _LOST_SHARE * least_a:
            return LoadFault.UNLOADED
        return None
