"""The interface of both navigation solutions: with inertial sensors (`inertial.py`) and without (`no_imu.py`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from companion.nav.lever_arms import Vector
from companion.nav.outliers import Verdict


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the boat's origin at `t_s`: position (m) and velocity (m/s) in NED, attitude (roll, pitch, yaw in rad),
    body rates (rad/s), and one sigma of each."""

    t_s: float
    position: Vector
    velocity: Vector
    attitude: Vector
    rates: Vector
    position_sigma_m: float
    velocity_sigma_mps: float
    yaw_sigma_rad: float
    position_covariance_m2: tuple[float, float, float] | None = None  # north-north, north-east, east-east


class Place(NamedTuple):
    """Horizontal motion of the boat's origin at some moment, as measurements have it, and one sigma of its position."""

    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    yaw_rad: float
    sigma_m: float


class Offset(NamedTuple):
    """Where a point of the hull is from the boat's origin, and how it moves relative to it, in NED."""

    north_m: float
    east_m: float
    north_mps: float
    east_mps: float


class Solution(Protocol):
    """Takes measurements at their time of validity `t_s`, of a point `lever_m` from the boat's origin (body axes).
    `sigma_*`: one sigma of the measurement on each axis."""

    def position(
        self, t_s: float, north_m: float, east_m: float, lever_m: Vector, sigma_m: float, rule: Verdict | None = None
    ) -> Verdict:
        """Take a position and return its verdict. `rule`: the verdict of another rule, which replaces the gate."""
        ...

    def velocity(
        self,
        t_s: float,
        north_mps: float,
        east_mps: float,
        lever_m: Vector,
        sigma_mps: float,
        rule: Verdict | None = None,
    ) -> Verdict:
        """Take a velocity over ground and return its verdict. `rule` as for a position."""
        ...

    def heading(self, t_s: float, yaw_rad: float, sigma_rad: float, rule: Verdict | None = None) -> Verdict:
        """Take a true heading and return its verdict. `rule` as for a position."""
        ...

    def add_heading_variance(self, variance_rad2: float) -> None:
        """Add to the variance of the heading."""
        ...

    def place(self, t_s: float) -> Place:
        """Where measurements have the boat at a moment near the last one."""
        ...

    def offset(self, lever_m: Vector) -> Offset:
        """Of a point `lever_m` from the boat's origin (body axes)."""
        ...

    def motion(self, now_s: float) -> Motion:
        """Motion of the boat's origin at `now_s`."""
        ...
