"""Supervision of one thruster: its measured throttle and azimuth against its command.

A healthy thruster stays in a band between the command and the value that it comes from. For the throttle the edges of
the band follow the command with a first-order lag, slower than any healthy propeller; for the azimuth they follow at
half of its rate, as configured or learned. A measurement outside the band by more than the tolerance, for long enough,
is a fault.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from companion.config.devices import ThrusterConfig
from companion.core.actuation import ThrusterCommand, ThrusterFeedback
from companion.core.angles import wrap_pi

_AZIMUTH_RATE_SHARE = 0.5
_LONGEST_STEP_S = 0.5  # between two commands: boards go neutral then, and the supervision restarts
_MOVED_SHARE = 0.2  # of the tolerance: a stuck azimuth that has turned by this can move again
_RECOVERY = 2.0  # a recovery takes this many times as long as a fault


class ThrusterFault(Enum):
    """Fault of a thruster; the value is for people."""

    STALLED = "propeller stalled"
    ASTRAY = "wrong throttle"
    RUNAWAY = "runaway"
    STUCK = "azimuth stuck"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """`throttle` (0…1), `azimuth_rad`: tolerated distance from the band. `lag_s`: tolerated lag of a propeller.
    `after_s`: how long outside is a fault. `retry_s`: time until a faulty thruster is tried again; 0: at the next
    arming. `current`: times the expected current that is tolerated.
    `learns_turns`: slow azimuths are learned."""

    throttle: float
    azimuth_rad: float
    lag_s: float
    after_s: float
    retry_s: float
    current: float = 1.8
    learns_turns: bool = True


class FeedbackSupervision:
    """Call `update` once a tick.

    A fault ends: of a stuck azimuth when it has moved and follows again, or has been as commanded for `retry_s`; of a
    runaway when it has stopped; of a propeller after `retry_s`; all but a runaway when the boat is armed or disarmed.
    Without measurements the supervision pauses, and then restarts. Remembers both bands, how long the measurements have
    been outside, and the fault.
    """

    __slots__ = (
        "_armed", "_azimuth_high", "_azimuth_low", "_azimuth_off_s", "_command_rad", "_fault_rad", "_fault_s", "_high",
        "_last_s", "_low", "_moved", "_off_s", "_rate_radps", "_seen", "_well_s", "fault",
    )  # fmt: skip

    def __init__(self, thruster: ThrusterConfig) -> None:
        self.turns_at(thruster.azimuth_rate_radps)
        self.fault: ThrusterFault | None = None
        self._seen = self._armed = self._moved = False
        self._last_s = self._fault_s = 0.0
        self._low = self._high = self._off_s = self._well_s = 0.0
        self._command_rad = self._azimuth_low = self._azimuth_high = self._azimuth_off_s = self._fault_rad = 0.0

    def turns_at(self, rate_radps: float) -> None:
        """Expect that rate of turn from now on."""
        self._rate_radps = _AZIMUTH_RATE_SHARE * rate_radps

    def update(
        self,
        command: ThrusterCommand,
        armed: bool,
        measured: ThrusterFeedback | None,
        tolerances: Tolerances,
        now_s: float,
    ) -> ThrusterFault | None:
        """The thruster's fault, or None. `command`: the last one sent to the bridge; `measured`: the newest report,
        None if it is old or the bridge does not answer."""
        dt_s = max(now_s - self._last_s, 0.0)
        self._last_s = now_s
        if dt_s >= _LONGEST_STEP_S:
            self._seen = False  # the board went neutral meanwhile, for want of commands
            dt_s = _LONGEST_STEP_S
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
        """Start the bands at the present measurement, so that the thruster has time to reach its command."""
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
        """Set the fault. Only a runaway replaces a present fault."""
        if self.fault is None or (fault is ThrusterFault.RUNAWAY and self.fault is not fault):
            self.fault, self._fault_s, self._well_s, self._moved = fault, now_s, 0.0, False
            self._fault_rad = measured.azimuth_rad or 0.0
            self._off_s = self._azimuth_off_s = 0.0  # the command becomes neutral now: start the times anew

    def _recover(
        self, stray: bool, measured: ThrusterFeedback, tolerances: Tolerances, now_s: float, dt_s: float
    ) -> None:
        if self.fault is ThrusterFault.STALLED or self.fault is ThrusterFault.ASTRAY:
            over = 0.0 < tolerances.retry_s <= now_s - self._fault_s
        else:
            self._well_s = 0.0 if stray else self._well_s + dt_s
            over = self._well_s >= _RECOVERY * tolerances.after_s
            if self.fault is ThrusterFault.STUCK and measured.azimuth_rad is not None:
                self._moved = (
                    self._moved
                    or abs(wrap_pi(measured.azimuth_rad - self._fault_rad)) > _MOVED_SHARE * tolerances.azimuth_rad
                )
                over = (over and self._moved) or 0.0 < tolerances.retry_s <= self._well_s
        if over:
            self.fault = None
            self._off_s = self._azimuth_off_s = 0.0


def _propeller_fault(throttle: float, measured: float, tolerances: Tolerances) -> ThrusterFault:
    if abs(measured) <= tolerances.throttle:
        return ThrusterFault.STALLED
    return ThrusterFault.RUNAWAY if throttle == 0.0 else ThrusterFault.ASTRAY
