"""One thruster, commanded against measured: does it do what it is told?

What a sound thruster may show lies in a band around the command: the command itself, and where it came from, which fades. For the
throttle the edges of the band follow the command with a first-order lag, slower than any sound propeller; for the azimuth they follow at half
of its rate. A measurement further outside than the tolerance, for long enough, is a fault.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from companion.config import ThrusterConfig
from companion.core.angles import wrap_pi
from companion.core.types import ThrusterCommand, ThrusterFeedback

_AZIMUTH_RATE_SHARE = 0.5
_LONGEST_STEP_S = 0.5  # a gap counts for no more
_MOVED_SHARE = 0.2  # of the tolerance: a stuck azimuth that has turned so far is loose again
_RECOVERY = 2.0  # times as long as it takes to be declared failed


class ThrusterFault(Enum):
    """What a thruster does wrong; the value is for people."""

    STALLED = "propeller does not turn"
    ASTRAY = "turns otherwise than commanded"
    RUNAWAY = "runs by itself"
    STUCK = "azimuth does not follow"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """`throttle` −1…1; `lag_s` how slowly a sound propeller may follow; `after_s` how long outside is a fault; `retry_s` until a thruster at fault
    is tried again, 0: not before the boat is armed anew."""

    throttle: float
    azimuth_rad: float
    lag_s: float
    after_s: float
    retry_s: float


class FeedbackSupervision:
    """`update(command, armed, measured, tolerances, now_s)` once a tick → its fault, or None.

    Remembers the two bands, how long the measurement has been outside of each, and the fault. It is forgotten: a stuck azimuth when it has
    moved and follows again, or has stood as commanded for `retry_s`; a runaway when it stands still; a propeller that did not follow after
    `retry_s`; all but a runaway when the boat is armed or disarmed. While nothing is measured it waits, and begins anew after.
    """

    __slots__ = (
        "_armed", "_azimuth_high", "_azimuth_low", "_azimuth_off_s", "_command_rad", "_fault_rad", "_fault_s", "_high", "_last_s", "_low", "_moved", "_off_s",
        "_rate_radps", "_seen", "_well_s", "fault",
    )  # fmt: skip

    def __init__(self, thruster: ThrusterConfig) -> None:
        self._rate_radps = _AZIMUTH_RATE_SHARE * thruster.azimuth_rate_radps
        self.fault: ThrusterFault | None = None
        self._seen = self._armed = self._moved = False
        self._last_s = self._fault_s = 0.0
        self._low = self._high = self._off_s = self._well_s = 0.0
        self._command_rad = self._azimuth_low = self._azimuth_high = self._azimuth_off_s = self._fault_rad = 0.0

    def update(
        self, command: ThrusterCommand, armed: bool, measured: ThrusterFeedback | None, tolerances: Tolerances, now_s: float
    ) -> ThrusterFault | None:
        """`command`: the last that went to the bridge; `measured`: the newest report, None if it is old or the bridge is not well."""
        dt_s = min(max(now_s - self._last_s, 0.0), _LONGEST_STEP_S)
        self._last_s = now_s
        if measured is None:
            self._seen = False
            return self.fault
        throttle = command.throttle if armed else 0.0
        if not self._seen or armed != self._armed:
            self._begin(throttle, command, armed, measured)
        stray = measured.throttle is not None and self._propeller_stray(throttle, measured.throttle, tolerances, dt_s)
        self._off_s = self._off_s + dt_s if stray else max(0.0, self._off_s - dt_s)
        turned_wrong = False
        if armed and measured.azimuth_rad is not None and command.azimuth_rad is not None:
            turned_wrong = self._azimuth_stray(command.azimuth_rad, measured.azimuth_rad, tolerances, dt_s)
            self._azimuth_off_s = self._azimuth_off_s + dt_s if turned_wrong else max(0.0, self._azimuth_off_s - dt_s)
        if self.fault is not None:
            self._recover(stray or turned_wrong, measured, tolerances, now_s, dt_s)
        if stray and measured.throttle is not None and self._off_s >= tolerances.after_s:
            self._declare(_propeller_fault(throttle, measured.throttle, tolerances), measured, now_s)
        elif turned_wrong and self._azimuth_off_s >= tolerances.after_s:
            self._declare(ThrusterFault.STUCK, measured, now_s)
        return self.fault

    def _begin(self, throttle: float, command: ThrusterCommand, armed: bool, measured: ThrusterFeedback) -> None:
        """From whatever it does now, it is given the time to come to what it is told."""
        if armed != self._armed and self.fault is not ThrusterFault.RUNAWAY:
            self.fault = None
        self._seen, self._armed = True, armed
        present = throttle if measured.throttle is None else measured.throttle
        self._low, self._high = min(throttle, present), max(throttle, present)
        self._off_s = self._azimuth_off_s = 0.0
        if command.azimuth_rad is not None and measured.azimuth_rad is not None:
            self._command_rad = command.azimuth_rad
            azimuth = command.azimuth_rad + wrap_pi(measured.azimuth_rad - command.azimuth_rad)
            self._azimuth_low, self._azimuth_high = min(azimuth, command.azimuth_rad), max(azimuth, command.azimuth_rad)

    def _propeller_stray(self, throttle: float, measured: float, tolerances: Tolerances, dt_s: float) -> bool:
        share = dt_s / (tolerances.lag_s + dt_s)
        low, high = self._low, self._high
        self._low = low = throttle if throttle < low else low + (throttle - low) * share
        self._high = high = throttle if throttle > high else high + (throttle - high) * share
        return not low - tolerances.throttle <= measured <= high + tolerances.throttle

    def _azimuth_stray(self, azimuth_rad: float, measured_rad: float, tolerances: Tolerances, dt_s: float) -> bool:
        self._command_rad = at = self._command_rad + wrap_pi(azimuth_rad - self._command_rad)
        step = self._rate_radps * dt_s
        self._azimuth_low = low = min(at, self._azimuth_low + step)
        self._azimuth_high = high = max(at, self._azimuth_high - step)
        off_rad = abs(wrap_pi(measured_rad - 0.5 * (low + high))) - 0.5 * (high - low)
        return off_rad > tolerances.azimuth_rad

    def _declare(self, fault: ThrusterFault, measured: ThrusterFeedback, now_s: float) -> None:
        """A fault that lasts is not replaced, but by a runaway."""
        if self.fault is None or (fault is ThrusterFault.RUNAWAY and self.fault is not fault):
            self.fault, self._fault_s, self._well_s, self._moved = fault, now_s, 0.0, False
            self._fault_rad = measured.azimuth_rad or 0.0
            self._off_s = self._azimuth_off_s = 0.0  # what it does once it is told to be neutral is judged anew

    def _recover(self, stray: bool, measured: ThrusterFeedback, tolerances: Tolerances, now_s: float, dt_s: float) -> None:
        if self.fault is ThrusterFault.STALLED or self.fault is ThrusterFault.ASTRAY:
            over = 0.0 < tolerances.retry_s <= now_s - self._fault_s
        else:
            self._well_s = 0.0 if stray else self._well_s + dt_s
            over = self._well_s >= _RECOVERY * tolerances.after_s
            if self.fault is ThrusterFault.STUCK and measured.azimuth_rad is not None:
                self._moved = self._moved or abs(wrap_pi(measured.azimuth_rad - self._fault_rad)) > _MOVED_SHARE * tolerances.azimuth_rad
                over = (over and self._moved) or 0.0 < tolerances.retry_s <= self._well_s
        if over:
            self.fault = None
            self._off_s = self._azimuth_off_s = 0.0


def _propeller_fault(throttle: float, measured: float, tolerances: Tolerances) -> ThrusterFault:
    if abs(measured) <= tolerances.throttle:
        return ThrusterFault.STALLED
    return ThrusterFault.RUNAWAY if throttle == 0.0 else ThrusterFault.ASTRAY
