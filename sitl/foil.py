"""Lift and drag of a sail or a fin at any angle of the flow.

Up to the stall by the lifting line of Prandtl for an elliptic load, C_L = 2π Λ/(Λ + 2) (α + α₀) and C_D = C_D0 +
C_L²/(0.9 π Λ). Beyond it by Viterna and Corrigan (1981), as for wings of that aspect ratio in full stall: with C_Dmax =
1.11 + 0.018 Λ, C_L = A₁ sin 2α + A₂ cos²α/sin α and C_D = B₁ sin²α + B₂ cos α, continuous at the stall. With the flow
from the trailing edge, 0.7 of the lift.
"""

from __future__ import annotations

import math

_SPAN_EFFICIENCY = 0.9
_BACKWARDS = 0.7


class Foil:
    """`coefficients(angle)` of a wing of that aspect ratio. `camber_rad`: α₀ of a sail that the wind fills; it is
    filled from `filled_rad` on, and luffs below."""

    __slots__ = (
        "_a1", "_a2", "_b1", "_b2", "_camber_rad", "_filled_rad", "_flat_drag", "_luffing_drag", "_room", "_slope",
        "_stall_rad",
    )  # fmt: skip

    def __init__(
        self,
        aspect: float,
        stall_rad: float,
        flat_drag: float,
        camber_rad: float = 0.0,
        filled_rad: float = 0.0,
        luffing_drag: float = 0.0,
    ) -> None:
        self._slope = math.tau * aspect / (aspect + 2.0)
        self._room = _SPAN_EFFICIENCY * math.pi * aspect
        self._stall_rad, self._flat_drag = stall_rad, flat_drag
        self._camber_rad, self._filled_rad, self._luffing_drag = camber_rad, filled_rad, luffing_drag
        lift = self._slope * (stall_rad + camber_rad)
        drag = flat_drag + lift * lift / self._room
        s, c = math.sin(stall_rad), math.cos(stall_rad)
        most = 1.11 + 0.018 * aspect
        self._b1, self._b2 = most, (drag - most * s * s) / c
        self._a1, self._a2 = 0.5 * most, (lift - most * s * c) * s / (c * c)

    def coefficients(self, angle_rad: float) -> tuple[float, float]:
        """(C_L, C_D), C_L with the sign of the angle, −π to π."""
        size = abs(math.remainder(angle_rad, math.tau))
        if size > 0.5 * math.pi:
            lift, drag = self._ahead(math.pi - size)
            lift *= -_BACKWARDS
        else:
            lift, drag = self._ahead(size)
        return math.copysign(1.0, math.remainder(angle_rad, math.tau)) * lift, drag

    def _ahead(self, angle_rad: float) -> tuple[float, float]:
        if angle_rad > self._stall_rad:
            s, c = math.sin(angle_rad), math.cos(angle_rad)
            return self._a1 * math.sin(2.0 * angle_rad) + self._a2 * c * c / s, self._b1 * s * s + self._b2 * c
        full = min(1.0, angle_rad / self._filled_rad) if self._filled_rad > 0.0 else 1.0
        lift = self._slope * (angle_rad + full * self._camber_rad)
        return lift, self._flat_drag + lift * lift / self._room + (1.0 - full) * self._luffing_drag
