"""Motion asked for from outside, as the references take it."""

from __future__ import annotations

from dataclasses import dataclass

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class WantedMotion:
    """`velocity` (m/s) and, where there is none, `acceleration` (m/s²) along north and east, or along the boat's own axes where `body`; neither: to stay.
    `point` (north_m, east_m): where it should be now, besides. `yaw_rad`: heading; None: turning at `yaw_rate_radps`, or where `along` the bow on the course.
    """

    velocity: Pair | None = None
    acceleration: Pair | None = None
    body: bool = False
    point: Pair | None = None
    yaw_rad: float | None = None
    yaw_rate_radps: float = 0.0
    along: bool = False
