"""Offboard: another computer steers, by setpoints that it sends all the time."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config import VesselConfig
from companion.core.types import ModeId, NavState, Setpoint
from companion.guidance.crab import top_speed_mps
from companion.guidance.motion_reference import MotionReference
from companion.guidance.velocity_course import VelocityCourse
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.headway import Headway
from companion.modes.mode import Mode, ModeInputs
from companion.modes.offboard_target import OffboardTarget
from companion.modes.propulsion import can_reverse
from companion.modes.station import Station
from companion.params import Parameters

_FURTHEST_M = 20_000.0
_MOVED_M = 0.001  # of the point, before the boat is sent after it
_MOVED_UNDER_WAY_M = 0.25


class OffboardMode(Mode):
    """`take` a setpoint whenever one comes, in the mode or before it; the newest counts. A point alone is gone to and held as in Hold; all else is sailed by
    dynamic positioning, or where the boat cannot push itself sideways as course and speed.

    Remembers the newest setpoint and when it came, the newest refusal, and which of its parts steers.
    """

    id = ModeId.OFFBOARD

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._parameters = parameters
        self._fence = fence
        self._can_sway = config.limits.sway_n > 0.0
        self._station = Station(config, parameters, fence)
        self._reference = MotionReference(config.length_m, parameters, fence.reach_mps)
        self._course = VelocityCourse(parameters, top_speed_mps(config), can_reverse(config.thrusters))
        self._headway = Headway("Offboard", events)
        self._target: OffboardTarget | None = None
        self._came_s = -math.inf
        self._refused: tuple[str, float] = ("", -math.inf)
        self._cleared: tuple[object, ...] | None = None  # fence and point that were last found to agree
        self._gone_to: tuple[float, float, float | None] | None = None  # point and heading that the station has
        self._by_motion = False
        how = "by dynamic positioning" if self._can_sway else "as course and speed: no heading is held, no way made sideways"
        self.text = f"Another computer steers by position, velocity, acceleration, heading or yaw rate; {how}"

    # --- what comes in ---------------------------------------------------------------------------------------------

    def take(self, target: OffboardTarget, nav: NavState, now_s: float) -> str | None:
        """A setpoint has come. A reason where it is not obeyed: the last one counts on then, until it is too old."""
        reason = self._refusal(target, nav)
        if reason is not None:
            self._refused = (reason, now_s)
            return reason
        self._target, self._came_s = target.fixed(nav), now_s
        return None

    def _refusal(self, target: OffboardTarget, nav: NavState) -> str | None:
        if target.needs_place and not (nav.position_valid and nav.heading_valid):
            return "the boat's own place is not known"
        place = target.fixed(nav).position
        if place is None:
            return None
        away_m = math.hypot(place[0] - nav.north_m, place[1] - nav.east_m)
        if away_m > _FURTHEST_M:
            return f"point {away_m / 1000.0:.0f} km away"
        agreed = (self._fence.key, place)
        if agreed != self._cleared:
            self._cleared = None
            if (reason := self._fence.go_refusal(nav, *place)) is not None:
                return f"point {reason}" if not reason.startswith("way") else reason
            self._cleared = agreed
        return None

    def fault(self, now_s: float) -> str | None:
        """Why there is nothing to steer by, or None."""
        most_s = self._parameters["OFFB_TIMEOUT"]
        age_s = now_s - self._came_s
        if self._target is not None and age_s <= most_s:
            return None
        reason, refused_s = self._refused
        if now_s - refused_s <= most_s:
            return f"setpoints refused: {reason}"
        return "no setpoint has come: they must be streaming first" if self._target is None else f"no setpoint for {age_s:.1f} s"

    # --- the mode --------------------------------------------------------------------------------------------------

    def check(self, inputs: ModeInputs) -> str | None:
        return self.fault(inputs.now_s)

    def enter(self, inputs: ModeInputs) -> str | None:
        if (reason := self.check(inputs)) is not None:
            return reason
        self._headway.reset()
        self._station.stop_here(inputs.nav)
        self._start_motion(inputs.nav)
        self._gone_to = None
        return None

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        return () if self._by_motion else self._station.way_ahead

    def excuse(self) -> None:
        self._headway.reset()

    def update(self, inputs: ModeInputs) -> Setpoint:
        target = self._target
        assert target is not None  # or it would not have been entered
        if target.is_point or (target.position is not None and target.velocity is None and not self._can_sway):
            return self._to_point(target, inputs)
        if not self._by_motion:
            self._start_motion(inputs.nav)
            self._gone_to = None
        self._headway.reset()
        wanted = target.motion(inputs.now_s - self._came_s)
        if self._can_sway:
            return self._reference.update(wanted, inputs.nav, inputs.dt_s)
        return self._course.update(wanted, inputs.nav, inputs.dt_s)

    def _start_motion(self, nav: NavState) -> None:
        self._by_motion = True
        self._reference.start(self._fence.slowed(nav))
        self._course.start(nav)

    def _to_point(self, target: OffboardTarget, inputs: ModeInputs) -> Setpoint:
        assert target.position is not None
        nav, station = inputs.nav, self._station
        north_m, east_m = target.position
        before = self._gone_to
        if before is None or self._has_moved(before, target):
            if before is None and not self._by_motion:
                station.stop_here(nav)
            station.go_to(nav, north_m, east_m, target.yaw_rad, None, fresh=before is None)
            self._gone_to = (north_m, east_m, target.yaw_rad)
            self._headway.rebase()
        self._by_motion = False
        setpoint = station.update(nav, None, inputs.speed_mps, inputs.dt_s)
        if station.way_m is not None:
            self._headway.update(station.way_m, inputs.speed_mps, inputs.now_s)
        return setpoint

    def _has_moved(self, before: tuple[float, float, float | None], target: OffboardTarget) -> bool:
        """Under way to a point far off the path is not laid anew for less than it can tell."""
        assert target.position is not None
        moved_m = math.dist(before[:2], target.position)
        return target.yaw_rad != before[2] or moved_m > (_MOVED_UNDER_WAY_M if self._station.in_transit else _MOVED_M)
