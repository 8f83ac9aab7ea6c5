"""The drive between a bridge and a propeller: its own trim, dead band, ends and direction."""

from __future__ import annotations

import math
from itertools import pairwise

from companion.config.bridges import OutputConfig
from companion.config.devices import ThrusterConfig


class DriveModel:
    """Throttle against input level, linear between measured points: full astern, ends of the dead band, full ahead."""

    def __init__(self, thruster: ThrusterConfig, pulses: bool) -> None:
        """`pulses`: levels are pulses in µs; else shares −1 to 1."""
        output = thruster.output or OutputConfig()
        trim, ahead, astern = (1500.0, 2000.0, 1000.0) if pulses else (0.0, 1.0, -1.0)
        trim = trim if output.trim is None else output.trim
        ahead = ahead if output.ahead is None else output.ahead
        astern = astern if output.astern is None else output.astern
        if output.reversed:
            ahead, astern = astern, ahead
        idle = [(trim - output.dead_band, 0.0), (trim + output.dead_band, 0.0)]
        self._points = sorted({*idle, (ahead, 1.0), *([(astern, -1.0)] if astern != trim else [])})
        self._trim, self._output = trim, output
        low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
        self._stops_rad = -math.pi if low is None else low, math.pi if high is None else high

    def throttle(self, level: float) -> float:
        """What the propeller does at an input level, −1 to 1; limited to the ends."""
        points = self._points
        if level <= points[0][0]:
            return points[0][1]
        for (low, at_low), (high, at_high) in pairwise(points):
            if level <= high:
                return at_low + (at_high - at_low) * (level - low) / (high - low) if high > low else at_high
        return points[-1][1]

    def level(self, throttle: float) -> float:
        """The level that it reports while the propeller does `throttle`."""
        for (low, at_low), (high, at_high) in pairwise(self._points):
            if min(at_low, at_high) <= throttle <= max(at_low, at_high) and at_low != at_high and throttle != 0.0:
                return low + (high - low) * (throttle - at_low) / (at_high - at_low)
        return self._trim

    def azimuth_rad(self, shown_rad: float | None) -> float | None:
        """Azimuth of the thruster while its drive is at the angle `shown_rad`."""
        if shown_rad is None:
            return None
        away = shown_rad - self._output.azimuth_trim_rad
        return -away if self._output.azimuth_reversed else away

    def shown_rad(self, azimuth_rad: float) -> float:
        """The angle that the drive reports at an azimuth of the thruster."""
        away = -azimuth_rad if self._output.azimuth_reversed else azimuth_rad
        return away + self._output.azimuth_trim_rad

    def servo_azimuth_rad(self, pulse_us: float) -> float:
        """Azimuth at a servo's pulse, between its ends."""
        low, high = self._stops_rad
        share = (pulse_us - self._output.azimuth_min_us) / (self._output.azimuth_max_us - self._output.azimuth_min_us)
        return low + (high - low) * min(1.0, max(0.0, share))

    def servo_pulse_us(self, azimuth_rad: float) -> float:
        """Pulse of the servo at an azimuth between its ends."""
        low, high = self._stops_rad
        return self._output.azimuth_min_us + (azimuth_rad - low) / (high - low) * (
            self._output.azimuth_max_us - self._output.azimuth_min_us
        )
