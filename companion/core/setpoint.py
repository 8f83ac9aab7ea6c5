"""Values of the step guide: what the active mode asks for. Each way of steering has its own setpoint; `Setpoint` is any
of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.core.actuation import ThrusterCommand, Wrench


@dataclass(frozen=True, slots=True)
class Point:
    """A place in the local plane."""

    north_m: float
    east_m: float


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a setpoint leads, for people and instruments; control does not read it.

    `place`: the point on the path, or the hold point. `target`: the go-to point or the next waypoint. The cross-track
    error is positive to starboard of the path; the course and the distance to go are those of the path. `yaw_rad`: the
    desired heading of a boat that lies without thrust.
    """

    place: Point | None = None
    target: Point | None = None
    cross_track_error_m: float | None = None
    course_rad: float | None = None
    distance_to_go_m: float | None = None
    yaw_rad: float | None = None


NO_PROGRESS = Progress()


@dataclass(frozen=True, slots=True)
class NeutralSetpoint:
    """No thrust."""

    progress: Progress = NO_PROGRESS


@dataclass(frozen=True, slots=True)
class PoseSetpoint:
    """Dynamic positioning: pose of the reference, with its velocity and acceleration in the reference's body axes.

    `circle_m`: so far off may the boat be where that saves energy; 0: it keeps the pose as well as it can. `bow_on`:
    its bow turns to weather that drove it off.
    """

    north_m: float
    east_m: float
    yaw_rad: float
    surge_mps: float = 0.0
    sway_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    surge_mps2: float = 0.0
    sway_mps2: float = 0.0
    yaw_radps2: float = 0.0
    progress: Progress = NO_PROGRESS
    circle_m: float = 0.0
    bow_on: bool = False

    def within(self, circle_m: float, bow_on: bool) -> PoseSetpoint:
        """With another `circle_m` and `bow_on`. As `dataclasses.replace`, which takes much for each tick."""
        return PoseSetpoint(
            self.north_m,
            self.east_m,
            self.yaw_rad,
            self.surge_mps,
            self.sway_mps,
            self.yaw_rate_radps,
            self.surge_mps2,
            self.sway_mps2,
            self.yaw_radps2,
            self.progress,
            circle_m,
            bow_on,
        )


PATH_STEP_S = 0.3  # between the poses of `PathSetpoint.ahead`


@dataclass(frozen=True, slots=True)
class PlannedPose:
    """Where a planned path has the boat at a time."""

    north_m: float
    east_m: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class PathSetpoint:
    """Path tracking: heading, speed and yaw rate under way, in body axes. `exact`: the motion is planned, with all its
    accelerations, and the sideways speed is to be kept like the others; else sideways thrust only helps. `ahead`: the
    poses planned from now on, PATH_STEP_S apart, for laws and thrusters that look ahead. `keeps_place`: the boat keeps
    near a point, and its motion in waves is no error. `over_ground`: speed and heading are all that is asked for,
    no track beside them corrects what wind and stream do. `by_rate`: the yaw rate is asked for, and the heading leads
    the bow by what is missing of it; it is no course."""

    yaw_rad: float
    surge_mps: float = 0.0
    sway_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    surge_mps2: float = 0.0
    progress: Progress = NO_PROGRESS
    sway_mps2: float = 0.0
    yaw_radps2: float = 0.0
    exact: bool = False
    ahead: tuple[PlannedPose, ...] = ()
    keeps_place: bool = False
    over_ground: bool = False
    by_rate: bool = False


def braked(setpoint: PathSetpoint, share: float, braking_mps2: float = 0.0) -> PathSetpoint:
    """The setpoint at a share of its speed, and braking by at least `braking_mps2`, whether it leads ahead or
    astern. On the same way, its own accelerations are the square of that share: with all of a plan's braking a boat
    that a fence has slowed would stand, and its bias would learn to push against that. The poses ahead are dropped:
    they lead on at full speed."""
    way, kept = math.copysign(1.0, setpoint.surge_mps), share * share
    return replace(
        setpoint,
        surge_mps=share * setpoint.surge_mps,
        sway_mps=share * setpoint.sway_mps,
        surge_mps2=way * min(way * kept * setpoint.surge_mps2, -braking_mps2),
        sway_mps2=kept * setpoint.sway_mps2,
        ahead=(),
    )


@dataclass(frozen=True, slots=True)
class HeadingSetpoint:
    """A heading to hold, with its yaw rate. `wrench` holds the surge and sway forces of the sticks. `pushed_ned_n`:
    what pushes the boat over the limit of its speed (north, east), as far as that is known."""

    yaw_rad: float
    wrench: Wrench
    yaw_rate_radps: float = 0.0
    progress: Progress = NO_PROGRESS
    pushed_ned_n: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WrenchSetpoint:
    """The wrench itself: past the control laws."""

    wrench: Wrench
    progress: Progress = NO_PROGRESS


@dataclass(frozen=True, slots=True)
class ThrusterSetpoint:
    """A demand for each thruster: past the control laws and the allocation."""

    thrusters: tuple[ThrusterCommand, ...]
    progress: Progress = NO_PROGRESS


Setpoint = NeutralSetpoint | PoseSetpoint | PathSetpoint | HeadingSetpoint | WrenchSetpoint | ThrusterSetpoint

NEUTRAL_SETPOINT = NeutralSetpoint()


@dataclass(frozen=True, slots=True)
class DesiredMotion:
    """Pose and velocity that a setpoint asks for, None where it leaves them open; for the log and the telemetry."""

    place: Point | None
    yaw_rad: float | None
    surge_mps: float = 0.0
    sway_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    surge_mps2: float = 0.0
    sway_mps2: float = 0.0
    yaw_radps2: float = 0.0


def desired_motion(setpoint: Setpoint) -> DesiredMotion:
    """The pose, velocity and acceleration that a setpoint of any type asks for."""
    match setpoint:
        case PoseSetpoint(n, e, yaw, u, v, r, ax, ay, turn):
            return DesiredMotion(Point(n, e), yaw, u, v, r, ax, ay, turn)
        case PathSetpoint(yaw, u, v, r, ax, progress, ay, turn):
            return DesiredMotion(progress.place, yaw, u, v, r, ax, ay, turn)
        case HeadingSetpoint(yaw, _, r, progress):
            return DesiredMotion(progress.place, yaw, yaw_rate_radps=r)
        case _:
            return DesiredMotion(setpoint.progress.place, setpoint.progress.yaw_rad)
