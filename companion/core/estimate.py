"""Values of the step estimate: motion of the boat, of the lead boat and of the vessels around."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple

from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.readings import AisTarget, FixType, Wish


@dataclass(frozen=True, slots=True)
class Distrust:
    """A sensor that lies, as far as the others tell. `sense`: what it measures; `fault`: what it does, for people.

    `since_s`: when that began. `excluded`: it is not used. `asks`: it has jumped, and an operator may accept that.
    """

    sense: str
    source: str
    fault: str
    since_s: float
    excluded: bool
    asks: bool


@dataclass(frozen=True, slots=True)
class Judged:
    """The verdict on the newest measurement of one sense, for people. `square`: its normalised innovation squared;
    `limit`: the largest that the gate accepts."""

    sense: str
    t_s: float
    square: float
    limit: float
    accepted: bool


@dataclass(frozen=True, slots=True)
class WaveMotion:
    """What waves add to the boat's motion, as far as positioning should leave it alone: displacement and velocity of
    the origin in NED, turn and rate about the vertical; and the waves' mean frequency as the boat meets them."""

    radps: float
    north_m: float
    east_m: float
    yaw_rad: float
    north_mps: float
    east_mps: float
    yaw_rate_radps: float


@dataclass(frozen=True, slots=True)
class NavState:
    """Estimated motion of the boat's origin at `t_s`, with accuracies (one sigma) and ages of the last measurements.

    `position_valid` and `heading_valid`: whether control may use them. Before the first fix the positions are 0 and
    invalid. `north_m`, `east_m` are in the local plane of the estimator (`Estimator.frame`); surge and sway are over
    ground in body axes.
    """

    t_s: float
    position_valid: bool
    heading_valid: bool
    lat_deg: float
    lon_deg: float
    altitude_m: float
    north_m: float
    east_m: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    surge_mps: float
    sway_mps: float
    north_mps: float
    east_mps: float
    roll_rate_radps: float
    pitch_rate_radps: float
    yaw_rate_radps: float
    position_accuracy_m: float
    velocity_accuracy_mps: float
    heading_accuracy_rad: float
    position_age_s: float
    heading_age_s: float
    imu_age_s: float
    fix: FixType
    satellites: int | None
    hdop: float | None
    time_unix_ns: int | None  # absolute time from a receiver, for this tick
    wind_speed_mps: float | None = None  # true wind
    wind_from_rad: float | None = None
    current_north_mps: float | None = None  # velocity of the water over ground, estimated from thrust and motion
    current_east_mps: float | None = None
    current_accuracy_mps: float | None = None  # one sigma on the worse axis
    distrusted: tuple[Distrust, ...] = ()  # sensors that lie
    jumps_followed: int = 0  # how often the position has followed a jump that was accepted
    position_covariance_m2: tuple[float, float, float] | None = None  # north-north, north-east, east-east
    judged: tuple[Judged, ...] = ()  # the newest measurements of the inertial filter
    waves: WaveMotion | None = None  # a part of this motion; None: calm, under way, or unknown


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


def usable(nav: NavState) -> NavState:
    """The estimate with validity cleared where a value is not finite: the failsafes act on that. A place that is no
    number has no accuracy; a heading that is none is NaN, with which computations go on."""
    motion = (
        nav.north_m
        + nav.east_m
        + nav.surge_mps
        + nav.sway_mps
        + nav.north_mps
        + nav.east_mps
        + nav.lat_deg
        + nav.lon_deg
    )
    position_ok, heading_ok = math.isfinite(motion), math.isfinite(nav.yaw_rad + nav.yaw_rate_radps)
    if position_ok and heading_ok:
        return nav
    return replace(
        nav,
        position_valid=nav.position_valid and position_ok,
        heading_valid=nav.heading_valid and heading_ok,
        position_accuracy_m=nav.position_accuracy_m if position_ok else math.inf,
        yaw_rad=nav.yaw_rad if math.isfinite(nav.yaw_rad) else math.nan,
    )


Air = tuple[float, float]
"""Velocity of the air over ground: north and east, in m/s."""


class Rig(NamedTuple):
    """What drives a boat with a sail: the last wind over ground (None: none known), whether the sail is used, and the
    motors beside it."""

    air: Air | None
    sails: bool = True
    motors: bool = False


def air_over_ground(nav: NavState) -> Air | None:
    """The true wind as a velocity; None if it is not known."""
    return air_of(nav.wind_speed_mps, nav.wind_from_rad)


def air_of(speed_mps: float | None, from_rad: float | None) -> Air | None:
    """The velocity of a wind; None where either is unknown."""
    if speed_mps is None or from_rad is None:
        return None
    return -speed_mps * math.cos(from_rad), -speed_mps * math.sin(from_rad)


def without_waves(nav: NavState) -> NavState:
    """The estimate less its wave motion."""
    waves = nav.waves
    if waves is None:
        return nav
    yaw_rad = wrap_pi(nav.yaw_rad - waves.yaw_rad)
    north_mps, east_mps = nav.north_mps - waves.north_mps, nav.east_mps - waves.east_mps
    surge_mps, sway_mps = ned_to_body(north_mps, east_mps, yaw_rad)
    return replace(
        nav,
        north_m=nav.north_m - waves.north_m,
        east_m=nav.east_m - waves.east_m,
        yaw_rad=yaw_rad,
        north_mps=north_mps,
        east_mps=east_mps,
        surge_mps=surge_mps,
        sway_mps=sway_mps,
        yaw_rate_radps=nav.yaw_rate_radps - waves.yaw_rate_radps,
        waves=None,
    )


class RelativeBy(Enum):
    """What the place of the lead boat relative to this one rests on."""

    POSITIONS = "positions"  # two positions of receivers of different kinds, or of one that does not say its kind
    DIFFERENCE = "difference"  # two receivers of one kind: their common errors cancel
    MOVING_BASE = "moving base"  # carrier phase between the two boats


@dataclass(frozen=True, slots=True)
class Leader:
    """Estimated motion of the lead boat now, in the local plane. `yaw_rad` is its heading, or its course if it reports
    no heading; None if neither is known.

    `age_s`: age of its last position; `interval_s`: recent interval between positions. `counter`: 0…40, up with each
    lost message, down with each received one. `acceleration_mps2`: along its course. `astern`: it goes stern first;
    known only for a leader that reports its heading. `relative_m`: one sigma on each axis of its place relative to this
    boat, which rests on `relative_by`; infinite while that is not known. `heading_lies`: the heading that it reports
    cannot be true beside its course.
    """

    system_id: int
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    yaw_rad: float | None
    yaw_rate_radps: float
    accuracy_m: float
    age_s: float
    interval_s: float
    wish: Wish | None
    counter: int = 0
    acceleration_mps2: float = 0.0
    astern: bool = False
    relative_m: float = math.inf
    relative_by: RelativeBy = RelativeBy.POSITIONS
    heading_lies: bool = False

    @property
    def speed_mps(self) -> float:
        """Speed over ground, negative while it goes astern."""
        speed = math.hypot(self.north_mps, self.east_mps)
        return -speed if self.astern else speed


@dataclass(frozen=True, slots=True)
class TrackedTarget:
    """All that is known of one vessel. `known.t_s`: time of its position; `heard_s`: time of its newest message."""

    known: AisTarget
    heard_s: float
    reports: int  # number of position reports

    @property
    def label(self) -> str:
        """Its name, or its MMSI if it has none; for people."""
        return self.known.name or f"MMSI {self.known.mmsi}"


@dataclass(frozen=True, slots=True)
class Contact:
    """A vessel's motion now, dead-reckoned along its course: centre of its hull in the local plane, velocity over
    ground, and the radius of the circle around the centre that contains the hull."""

    mmsi: int
    label: str
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    radius_m: float
    status: int | None

    @property
    def speed_mps(self) -> float:
        """Speed over ground."""
        return math.hypot(self.north_mps, self.east_mps)


def through_water(nav: NavState) -> tuple[float, float]:
    """(surge, sway) in m/s through the water; over ground if no current is known."""
    if nav.current_north_mps is None or nav.current_east_mps is None:
        return nav.surge_mps, nav.sway_mps
    ahead_mps, aside_mps = ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)
    return nav.surge_mps - ahead_mps, nav.sway_mps - aside_mps
