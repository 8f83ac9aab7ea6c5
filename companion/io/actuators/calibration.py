"""From a thruster's throttle and azimuth to the levels of its drive and back: trim, dead band, end points, direction,
rates. Shared by all bridges."""

from __future__ import annotations

import math

from companion.config.bridges import OutputConfig
from companion.config.devices import ThrusterConfig
from companion.core.actuation import ThrusterCommand
from companion.core.angles import wrap_pi

_AS_IT_IS = OutputConfig()


class ThrusterOutput:
    """`level(command, armed, now_s)` → the level that the drive is sent, in the unit of its bridge; `throttle(level)` →
    the throttle of a level that the drive reports.

    The level is that of standstill while disarmed, and for a throttle that is not finite. Remembers the last throttle
    and its time, for the rate.
    """

    def __init__(self, thruster: ThrusterConfig, pulses: bool) -> None:
        """`pulses`: the bridge speaks µs; else a share −1…1."""
        output = thruster.output or _AS_IT_IS
        self.neutral = output.scale(pulses).trim
        self._scale = output.scale(pulses)
        self._rate_ps = output.rate_ps
        self._azimuth_sign = -1.0 if output.azimuth_reversed else 1.0
        self._azimuth_trim_rad = output.azimuth_trim_rad
        self._throttle = 0.0
        self._told_s: float | None = None

    def level(self, command: ThrusterCommand, armed: bool, now_s: float) -> float:
        """The level for a command: with trim, dead band, end points, direction and rate."""
        throttle = command.throttle if armed and math.isfinite(command.throttle) else 0.0
        throttle = self._slewed(min(1.0, max(-1.0, throttle)), now_s)
        if throttle == 0.0:
            return self.neutral
        span = (self._scale.ahead if throttle > 0.0 else self._scale.astern) - self.neutral
        skipped = math.copysign(self._scale.dead_band, span) if span else 0.0
        return self.neutral + skipped + abs(throttle) * (span - skipped)

    def throttle(self, level: float) -> float:
        """The throttle −1…1 of a level that the drive reports."""
        off, ahead, astern = level - self.neutral, self._scale.ahead - self.neutral, self._scale.astern - self.neutral
        if abs(off) <= self._scale.dead_band:
            return 0.0
        forward = off * ahead > 0.0
        span = abs(ahead if forward else astern)
        if span == 0.0:
            return 0.0
        share = min(1.0, (abs(off) - self._scale.dead_band) / (span - self._scale.dead_band))
        return share if forward else -share

    def drive_azimuth(self, azimuth_rad: float | None) -> float | None:
        """The angle to send to a drive that takes angles, in rad."""
        if azimuth_rad is None or not self._turned:
            return azimuth_rad
        return self._azimuth_sign * azimuth_rad + self._azimuth_trim_rad

    def azimuth(self, drive_rad: float | None) -> float | None:
        """The thruster's azimuth in rad, for the angle that its drive reports."""
        if drive_rad is None or not self._turned:
            return drive_rad
        return wrap_pi(self._azimuth_sign * (drive_rad - self._azimuth_trim_rad))

    @property
    def _turned(self) -> bool:
        return self._azimuth_sign < 0.0 or self._azimuth_trim_rad != 0.0

    def _slewed(self, throttle: float, now_s: float) -> float:
        """Towards standstill at once, away from it at the rate."""
        last, self._throttle = self._throttle, throttle
        dt_s = 0.0 if self._told_s is None else max(0.0, now_s - self._told_s)
        self._told_s = now_s
        if self._rate_ps is not None and throttle != 0.0:
            begin = 0.0 if throttle * last < 0.0 else last
            if abs(throttle) > abs(begin):
                self._throttle = math.copysign(min(abs(throttle), abs(begin) + self._rate_ps * dt_s), throttle)
        return self._throttle


class AzimuthServo:
    """`pulse_us(azimuth_rad, now_s)` for a servo that turns a thruster between its stops; `azimuth_rad(pulse_us)` back.

    The pulses move at the thruster's own rate; only the first one is given at once. Remembers the last azimuth and its
    time.
    """

    def __init__(self, thruster: ThrusterConfig, begin_at_rest: bool = False) -> None:
        """`begin_at_rest`: before the first demand there is a pulse, that of the thruster's azimuth at rest. Raises
        ValueError for a thruster without stops."""
        output = thruster.output or _AS_IT_IS
        if thruster.azimuth_min_rad is None or thruster.azimuth_max_rad is None:
            raise ValueError(f"thruster '{thruster.name}' has no stops")
        self._low_rad, self._high_rad = thruster.azimuth_min_rad, thruster.azimuth_max_rad
        self._low_us, self._high_us = output.azimuth_min_us, output.azimuth_max_us
        self._rate_radps = thruster.azimuth_rate_radps
        self._last_rad: float | None = (
            min(self._high_rad, max(self._low_rad, thruster.azimuth_rad)) if begin_at_rest else None
        )
        self._last_s: float | None = None

    def pulse_us(self, azimuth_rad: float | None, now_s: float) -> float | None:
        """The pulse for an azimuth. None or a number that is not finite: the last one; None before the first demand."""
        wanted = (
            self._last_rad
            if azimuth_rad is None or not math.isfinite(azimuth_rad)
            else min(self._high_rad, max(self._low_rad, azimuth_rad))
        )
        if wanted is None:
            return None
        if self._last_rad is not None:
            most = 0.0 if self._last_s is None else self._rate_radps * max(0.0, now_s - self._last_s)
            wanted = min(self._last_rad + most, max(self._last_rad - most, wanted))
        self._last_rad, self._last_s = wanted, now_s
        share = (wanted - self._low_rad) / (self._high_rad - self._low_rad)
        return self._low_us + share * (self._high_us - self._low_us)

    def azimuth_rad(self, pulse_us: float) -> float:
        """The azimuth for a pulse, within the stops."""
        share = (pulse_us - self._low_us) / (self._high_us - self._low_us)
        return self._low_rad + min(1.0, max(0.0, share)) * (self._high_rad - self._low_rad)
