"""What another computer asks of the boat in Offboard."""

from __future__ import annotations

from dataclasses import dataclass, replace

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.core.types import NavState
from companion.guidance.wanted_motion import Pair, WantedMotion


@dataclass(frozen=True, slots=True)
class OffboardTarget:
    """A setpoint: position (m), velocity (m/s), acceleration (m/s²), heading and yaw rate; None for what is not meant.

    `body`: along the boat's own axes, ahead and to starboard, and the heading from the bow; else north and east, and the heading from north. `offset`: the
    position counts from where the boat is. `keeps_yaw`: the heading is to stay as it is.
    """

    position: Pair | None = None
    velocity: Pair | None = None
    acceleration: Pair | None = None
    yaw_rad: float | None = None
    yaw_rate_radps: float | None = None
    keeps_yaw: bool = False
    body: bool = False
    offset: bool = False

    @property
    def needs_place(self) -> bool:
        """Whether it can only be judged by who knows where the boat is."""
        return self.position is not None or (self.body and self.yaw_rad is not None)

    def fixed(self, nav: NavState) -> OffboardTarget:
        """The same with position and heading as they are in the local plane, for a boat at `nav`. Velocities stay in the boat's axes."""
        position, yaw_rad = self.position, self.yaw_rad
        if position is not None and self.offset:
            north_m, east_m = body_to_ned(*position, nav.yaw_rad) if self.body else position
            position = (nav.north_m + north_m, nav.east_m + east_m)
        if yaw_rad is not None:
            yaw_rad = wrap_pi(yaw_rad + (nav.yaw_rad if self.body else 0.0))
        return replace(self, position=position, yaw_rad=yaw_rad, offset=False)

    @property
    def is_point(self) -> bool:
        """A place to go to and stay at, and nothing else."""
        return self.position is not None and self.velocity is None and not self.yaw_rate_radps

    def motion(self, age_s: float) -> WantedMotion:
        """Of a fixed target that came `age_s` ago; its position goes on by its velocity."""
        point = self.position
        if point is not None and self.velocity is not None and not self.body:
            point = (point[0] + self.velocity[0] * age_s, point[1] + self.velocity[1] * age_s)
        free = self.yaw_rad is None and self.yaw_rate_radps is None and not self.keeps_yaw
        acceleration = self.acceleration if point is None and self.velocity is None else None
        return WantedMotion(
            self.velocity, acceleration, self.body, point, self.yaw_rad, self.yaw_rate_radps or 0.0, along=free and not self.body
        )
