"""What both ways of navigating give: with inertial sensors (`inertial.py`) and without (`no_imu.py`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.core.records import quick
from companion.nav.lever_arms import Vector
from companion.nav.wild_points import Verdict


@quick
@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the boat's origin at `t_s`: NED position (m) and velocity (m/s), attitude (rad), body rates (rad/s), one sigma each."""

    t_s: float
    position: Vector
    velocity: Vector
    attitude: Vector
    rates: Vector
    position_sigma_m: float
    velocity_sigma_mps: float
    yaw_sigma_rad: float


class Solution(Protocol):
    """Takes measurements at their time of validity, `lever_m` from the boat's origin, and says what became of each.

    `rule`: what another rule has found of a position; then the solution's own gate is not asked.
    """

    def position(
        self, t_s: float, north_m: float, east_m: float, lever_m: Vector, sigma_m: float, rule: Verdict | None = None
    ) -> Verdict: ...

    def velocity(self, t_s: float, north_mps: float, east_mps: float, lever_m: Vector, sigma_mps: float) -> Verdict: ...

    def heading(self, t_s: float, yaw_rad: float, sigma_rad: float) -> Verdict: ...

    def doubt_position(self, variance_m2: float) -> None: ...

    def doubt_heading(self, variance_rad2: float) -> None: ...

    def motion(self, now_s: float) -> Motion: ...
