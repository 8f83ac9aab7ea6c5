"""Parts of the status: where home is, and how the boat stands to its fence. Others take them from `types`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Home:
    lat_deg: float
    lon_deg: float
    altitude_m: float
    yaw_rad: float | None = None


@dataclass(frozen=True, slots=True)
class FenceState:
    """Of the fence in force. `breaches` counts since it came in force, `breach_s` is the begin of the last one."""

    breached: bool
    breaches: int
    breach_s: float | None
    slowed: bool  # the speed is limited so that the boat stops inside
