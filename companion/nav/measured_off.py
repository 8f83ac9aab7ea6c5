"""What measurements are off by, as the error-state filter has it: slow errors, and a latency that nobody knows."""

from __future__ import annotations

from typing import NamedTuple


class Wander(NamedTuple):
    """A slow error: one sigma, and the time constant in s after which it is another one."""

    sigma: float
    time_s: float


class MeasuredOff(NamedTuple):
    """The wander of positions (m, north and east) and headings (rad), and by how much the values of the receiver in use
    are later than their times (s)."""

    north_m: float
    east_m: float
    heading_rad: float
    late_s: float
