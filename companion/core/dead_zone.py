"""What of a value lies outside a dead zone around 0."""

from __future__ import annotations

import math


def beyond_dead_zone(value: float, dead: float) -> float:
    """0 within ±`dead`; outside, the distance from there, with the sign of `value`."""
    return math.copysign(max(0.0, abs(value) - dead), value)
