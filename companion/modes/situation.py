"""What arming checks and failsafes look at: the vessel as it stands in one tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from companion.core.records import quick
from companion.core.types import DeviceHealth, FixType, Inputs, NavState
from companion.modes.mode import Mode
from companion.params import Parameters

NO_ESTIMATE = NavState(
    t_s=0.0,
    position_valid=False,
    heading_valid=False,
    lat_deg=0.0,
    lon_deg=0.0,
    altitude_m=0.0,
    north_m=0.0,
    east_m=0.0,
    roll_rad=0.0,
    pitch_rad=0.0,
    yaw_rad=0.0,
    surge_mps=0.0,
    sway_mps=0.0,
    north_mps=0.0,
    east_mps=0.0,
    roll_rate_radps=0.0,
    pitch_rate_radps=0.0,
    yaw_rate_radps=0.0,
    position_accuracy_m=math.inf,
    velocity_accuracy_mps=math.inf,
    heading_accuracy_rad=math.inf,
    position_age_s=math.inf,
    heading_age_s=math.inf,
    imu_age_s=math.inf,
    fix=FixType.NONE,
    satellites=None,
    hdop=None,
    time_unix_ns=None,
)
"""Before the first tick."""


@dataclass(frozen=True, slots=True)
class LeaderSight:
    """`fault`: why the leader cannot be followed now; `good_s`: for how long nothing has been wrong; `stays`: why the boat would not go back to Follow
    by itself."""

    fault: str | None = "no leader heard"
    good_s: float = 0.0
    stays: str | None = None


NO_LEADER = LeaderSight()


@quick
@dataclass(frozen=True, slots=True)
class Situation:
    """`intended`: the mode last asked for by a person. `mode_refusal`: why the present mode could not be entered now, or None.

    `sticks_age_s`: since the sticks in charge were heard, None if none ever were. `station_age_s` likewise for ground stations.
    `bridges`, `sensors`: health by name.
    """

    now_s: float
    nav: NavState
    inputs: Inputs
    bridges: Mapping[str, DeviceHealth]
    sensors: Mapping[str, DeviceHealth]
    parameters: Parameters
    armed: bool
    mode: Mode
    intended: Mode
    mode_refusal: str | None
    sticks_age_s: float | None
    station_age_s: float | None
    safe_switch: bool
    failed_thrusters: tuple[str, ...] = ()
    lost_motions: tuple[str, ...] = ()  # what thrusters that have failed leave the boat unable to do
    fence: str | None = None  # what is wrong with the boat's place, or soon will be
    leader: LeaderSight = NO_LEADER
    offboard: str | None = None  # why there is nothing to steer by in Offboard


def usable(nav: NavState) -> NavState:
    """The estimate; one that is not finite counts as invalid, so that the failsafes see it and the modes do not."""
    motion = nav.north_m + nav.east_m + nav.surge_mps + nav.sway_mps + nav.north_mps + nav.east_mps + nav.lat_deg + nav.lon_deg
    position_ok, heading_ok = math.isfinite(motion), math.isfinite(nav.yaw_rad + nav.yaw_rate_radps)
    if position_ok and heading_ok:
        return nav
    return replace(nav, position_valid=nav.position_valid and position_ok, heading_valid=nav.heading_valid and heading_ok)


def estimate_refusal(mode: Mode, nav: NavState) -> str | None:
    """Why the estimate does not do for `mode`, or None."""
    if mode.needs_position and not nav.position_valid:
        return "position not valid"
    if mode.needs_heading and not nav.heading_valid:
        return "heading not valid"
    return None
