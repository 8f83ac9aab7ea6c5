"""PID with filtered derivative (PIDf) of the RescueRunner thesis (Hallhagen & Persson 2016, 6.4).

Kp + Ki/s + Kd s/(1 + Tf s), made discrete by Tustin's rule s → 2/h (z − 1)/(z + 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Gains:
    """Gains of one PIDf; `tf_s`: time constant of the derivative's filter."""

    kp: float
    ki: float
    kd: float
    tf_s: float


def coefficients(gains: Gains, h_s: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """((b0, b1, b2), (a0, a1, a2)) of the difference equation, as the thesis prints them.

    y(n) = (b0 e(n) + b1 e(n−1) + b2 e(n−2) − a1 y(n−1) − a2 y(n−2)) / a0
    """
    kp, ki, kd, tf = gains.kp, gains.ki, gains.kd, gains.tf_s
    b0 = (2.0 * tf + h_s) * (2.0 * kp + h_s * ki) + 4.0 * kd
    b1 = (
        -8.0 * kd
        - 2.0 * kp * (2.0 * tf + h_s)
        + h_s * ki * (2.0 * tf + h_s)
        - 2.0 * tf * (2.0 * kp + h_s * ki)
        + h_s * (2.0 * kp + h_s * ki)
    )
    b2 = 4.0 * tf * kp - 2.0 * h_s * tf * ki - 2.0 * h_s * kp + h_s * h_s * ki + 4.0 * kd
    return (b0, b1, b2), (4.0 * tf + 2.0 * h_s, -8.0 * tf, 4.0 * tf - 2.0 * h_s)


class Pidf:
    """`update(error, gains, h_s)` → output.

    Remembers the last error, the integral and the derivative separately, so that a change of gains leaves no lasting
    step. With constant gains it is the difference equation of `coefficients`. `low`, `high`: limits of the integral.
    The thesis prints no anti-windup; without one nothing settles.
    """

    __slots__ = ("_derivative", "_high", "_integral", "_last", "_low")

    def __init__(self, low: float = -math.inf, high: float = math.inf) -> None:
        self._low, self._high = low, high
        self.start()

    def start(self) -> None:
        """Reset error, integral and derivative."""
        self._last: float | None = None
        self._integral = self._derivative = 0.0

    def update(self, error: float, gains: Gains, h_s: float) -> float:
        """One step of length `h_s`."""
        last = error if self._last is None else self._last  # no step of the derivative at the start
        self._last = error
        self._integral = min(self._high, max(self._low, self._integral + 0.5 * h_s * gains.ki * (error + last)))
        down = 2.0 * gains.tf_s + h_s
        self._derivative = ((2.0 * gains.tf_s - h_s) * self._derivative + 2.0 * gains.kd * (error - last)) / down
        return gains.kp * error + self._integral + self._derivative
