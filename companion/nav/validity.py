"""When each kind of measurement was last accepted → whether control may use position and heading, and how accurate
they are."""

from __future__ import annotations

import math

from companion.nav.solution import Motion
from companion.params.store import Parameters

HEADING_COAST_RAD = math.radians(5.0)  # largest sigma at which the gyro alone may carry the heading
_HEADING_BY_MOTION_RAD = math.radians(10.0)  # the same, where the boat's motion is all that ever tells the heading
_HEADING_USABLE_RAD = math.radians(20.0)
_CARRIED_AGE_S = 1.0  # age of the velocity up to which it carries the position


class Validity:
    """Remembers the times (`*_s`) of what was accepted, and the slow errors of measurements that the sigmas of the
    motion do not hold: those of a filter with inertial sensors do."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.position_s = self.velocity_s = self.heading_s = self.imu_s = 0.0
        self.lied_s = -math.inf  # when a source was last not used because it lies
        self.apart_m = 0.0  # between two receivers of which one must be wrong: the boat may be at either
        self._slow_sigma_m = self._slow_sigma_rad = 0.0

    def begin(self, t_s: float) -> None:
        """The first position."""
        self.position_s = t_s

    def position(self, t_s: float, slow_sigma_m: float) -> None:
        """A position was accepted."""
        self.position_s = max(self.position_s, t_s)
        self._slow_sigma_m = slow_sigma_m

    def velocity(self, t_s: float) -> None:
        """A velocity was accepted."""
        self.velocity_s = max(self.velocity_s, t_s)

    def heading(self, t_s: float, slow_sigma_rad: float) -> None:
        """A heading was accepted."""
        self.heading_s = max(self.heading_s, t_s)
        self._slow_sigma_rad = slow_sigma_rad

    def imu(self, t_s: float) -> None:
        """An inertial sample was used."""
        self.imu_s = max(self.imu_s, t_s)

    def unmeasured_s(self, now_s: float) -> float:
        """Time since the last position or velocity."""
        return now_s - max(self.position_s, self.velocity_s)

    def carried(self, now_s: float) -> bool:
        """Whether measured velocities carry on a position that no fix confirms, not for too long."""
        return (
            now_s - self.velocity_s <= _CARRIED_AGE_S
            and now_s - self.position_s <= self._parameters["NAV_CARRY_T"]
            and now_s - self.lied_s <= _CARRIED_AGE_S
        )

    def position_sigma_m(self, motion: Motion) -> float:
        """Of the position, with what its receiver wanders slowly, and how far another one is off."""
        return math.hypot(motion.position_sigma_m, self._slow_sigma_m, self.apart_m)

    def yaw_sigma_rad(self, motion: Motion) -> float:
        """Of the heading, with its slow error; π at most."""
        return min(math.hypot(motion.yaw_sigma_rad, self._slow_sigma_rad), math.pi)

    def covariance_m2(self, motion: Motion) -> tuple[float, float, float]:
        """Of the position: north-north, north-east, east-east, with what `position_sigma_m` adds."""
        slow_m2 = self._slow_sigma_m**2 + self.apart_m**2
        nn, ne, ee = motion.position_covariance_m2 or (motion.position_sigma_m**2, 0.0, motion.position_sigma_m**2)
        return nn + slow_m2, ne, ee + slow_m2

    def position_valid(self, position_sigma_m: float, now_s: float) -> bool:
        """Whether control may use a position of that sigma, once there is one."""
        lately = now_s - self.position_s <= self._parameters["FS_POS_T"] or self.carried(now_s)
        return lately and position_sigma_m <= self._parameters["COM_POS_FS_EPH"]

    def heading_valid(self, yaw_sigma_rad: float, now_s: float, by_gyro: bool, by_motion: bool = False) -> bool:
        """Whether control may use a heading of that sigma, once there is one: measured lately, or carried by the gyro
        (`by_gyro`) while its sigma is small and positions arrive. `by_motion`: no compass measures it."""
        if yaw_sigma_rad > _HEADING_USABLE_RAD:
            return False
        tolerated_s = self._parameters["FS_POS_T"]
        if now_s - self.heading_s <= tolerated_s:
            return True
        placed = now_s - self.position_s <= tolerated_s or self.carried(now_s)
        largest_rad = _HEADING_BY_MOTION_RAD if by_motion else HEADING_COAST_RAD
        return by_gyro and yaw_sigma_rad <= largest_rad and placed
