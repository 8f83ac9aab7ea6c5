"""The setpoint that another computer sends in Offboard."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned
from companion.guidance.motion_request import MotionRequest, Pair
from companion.guidance.velocity_course import STANDING_MPS


@dataclass(frozen=True, slots=True)
class OffboardTarget:
    """A setpoint: position (m), velocity (m/s), acceleration (m/s²), heading and yaw rate; None for unused fields.

    With `body`, vectors are ahead and to starboard and the heading counts from the bow; otherwise vectors are north and
    east and the heading counts from north. With `offset`, the position is relative to the boat. With `keeps_yaw`, the
    boat keeps its heading.
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
        """Whether the setpoint has a meaning only with a known position and heading of the boat."""
        return self.position is not None or (self.body and self.yaw_rad is not None)

    def fixed(self, nav: NavState) -> OffboardTarget:
        """The same setpoint with position and heading in the local plane, for a boat at `nav`. Velocities are not
        changed."""
        position, yaw_rad = self.position, self.yaw_rad
        if position is not None and self.offset:
            north_m, east_m = body_to_ned(*position, nav.yaw_rad) if self.body else position
            position = (nav.north_m + north_m, nav.east_m + east_m)
        if yaw_rad is not None:
            yaw_rad = wrap_pi(yaw_rad + (nav.yaw_rad if self.body else 0.0))
        return replace(self, position=position, yaw_rad=yaw_rad, offset=False)

    @property
    def is_point(self) -> bool:
        """Whether the setpoint is only a position to go to and hold."""
        return self.position is not None and self.velocity is None and not self.yaw_rate_radps

    @property
    def stands(self) -> bool:
        """Whether it asks for no velocity, or for one that means to stand still."""
        return self.velocity is None or math.hypot(*self.velocity) < STANDING_MPS

    def motion(self, age_s: float) -> MotionRequest:
        """The motion request of a fixed target that arrived `age_s` ago. Its velocity moves its position on."""
        point = self.position
        if point is not None and self.velocity is not None and not self.body:
            point = (point[0] + self.velocity[0] * age_s, point[1] + self.velocity[1] * age_s)
        free = self.yaw_rad is None and self.yaw_rate_radps is None and not self.keeps_yaw
        acceleration = self.acceleration if point is None and self.velocity is None else None
        return MotionRequest(
            self.velocity,
            acceleration,
            self.body,
            point,
            self.yaw_rad,
            self.yaw_rate_radps or 0.0,
            along=free and not self.body,
        )
