"""A motion that an outside computer requests, as the references take it."""

from __future__ import annotations

from dataclasses import dataclass

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class MotionRequest:
    """`velocity` (m/s), or if that is None `acceleration` (m/s²), is (north, east), or (forward, starboard) if `body`
    is True; with neither, the boat stays. `point` (north_m, east_m): the position to reach in addition. `yaw_rad`: the
    heading; if None, the boat turns at `yaw_rate_radps`, or points along its course if `along` is True.
    """

    velocity: Pair | None = None
    acceleration: Pair | None = None
    body: bool = False
    point: Pair | None = None
    yaw_rad: float | None = None
    yaw_rate_radps: float = 0.0
    along: bool = False
