"""A point of a route, as guidance sees it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point to pass within `radius_m` (None: NAV_ACC_RAD), with at most `speed_mps` on the leg to it (None: as
    commanded). `straight`: the leg to it is a straight line, else the curve of PATH_KIND."""

    north_m: float
    east_m: float
    radius_m: float | None = None
    speed_mps: float | None = None
    straight: bool = False

    @property
    def own_radius_m(self) -> float | None:
        """The radius that the plan gives it; None where it gives none, or 0."""
        return self.radius_m if self.radius_m is not None and self.radius_m > 0.0 else None
