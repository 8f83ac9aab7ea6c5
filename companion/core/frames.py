"""Rotation of horizontal vectors between NED and body axes (x forward, y starboard)."""

from __future__ import annotations

import math


def body_to_ned(x: float, y: float, yaw_rad: float) -> tuple[float, float]:
    """(x forward, y starboard) → (north, east), any unit."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return c * x - s * y, s * x + c * y


def ned_to_body(north: float, east: float, yaw_rad: float) -> tuple[float, float]:
    """(north, east) → (x forward, y starboard), any unit."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return c * north + s * east, -s * north + c * east
