"""A figure that is derived from dimensions: its value, how far off it may be, and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """One derived figure.

    `key`: its place in the vessel's file, such as `hull.damping.x_u`. The true value is expected between `value /
    factor` and `value · factor`. `formula` and `source` say how `value` came about.
    """

    key: str
    value: float
    factor: float
    formula: str
    source: str

    def covers(self, published: float) -> bool:
        """Whether a published value lies within the factor. Values of opposite signs are never covered."""
        return self.off(published) <= self.factor

    def off(self, published: float) -> float:
        """By what factor the derived value is off, 1 or more; infinite where the signs differ."""
        if self.value * published <= 0.0:
            return float("inf")
        return max(self.value / published, published / self.value)
