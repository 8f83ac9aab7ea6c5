"""Follow: keeps a station on the lead boat."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config import VesselConfig
from companion.core.types import ZERO_WRENCH, Leader, ModeId, NavState, Setpoint, SetpointKind, Severity
from companion.guidance.clearance import closes_too_fast
from companion.guidance.coasting import Coasting
from companion.guidance.follow import FollowLaw, Motion
from companion.guidance.thesis_following import ThesisFollowing
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.headway import Headway
from companion.modes.mode import Mode, ModeInputs
from companion.modes.propulsion import can_reverse
from companion.modes.station import Station
from companion.params import Parameters

_THESIS = 1  # FOLL_LAW
_FURTHEST_M = 2000.0
_MOVED_M = 1.0  # of the station of a leader at rest, before the boat is sent after it
_MAKING_WAY_MPS = 0.5
_DECIDE_S = 1.0
_FASTEST_MPS = 25.0


class FollowMode(Mode):
    """Along the track of the lead boat, or beside it; beside a leader that stands it lies by dynamic positioning where it can, else it drifts.

    Remembers its law, the station held while the leader stands, whether it waits inside the fence for a leader whose station is outside, and the way made.
    """

    id = ModeId.FOLLOW
    early = True  # ground stations tell of their place only once the boat is in Follow

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._parameters = parameters
        self._events = events
        self._fence = fence
        self._reverses = can_reverse(config.thrusters)
        self._coasting = Coasting(config.hull, _FASTEST_MPS)
        self.law = FollowLaw(config, parameters, self._reverses)
        self._thesis = ThesisFollowing(config, parameters)
        self._station = Station(config, parameters, fence)
        self._headway = Headway("Follow", events)
        self._held: tuple[float, float] | None = None
        self._waiting = False
        self._by_thesis = False
        self._way_m = 0.0
        standing = "holds by dynamic positioning" if config.limits.sway_n > 0.0 else "holds" if self._reverses else "drifts, and turns away from a leader that goes astern"
        self.text = f"Keeps a station on the lead boat, astern in its track; beside a leader at rest it {standing}"

    def check(self, inputs: ModeInputs) -> str | None:
        leader = inputs.leader
        if inputs.leader_fault is not None or leader is None:
            return inputs.leader_fault or "no leader heard"
        distance_m = math.hypot(leader.north_m - inputs.nav.north_m, leader.east_m - inputs.nav.east_m)
        return f"the leader is {distance_m / 1000.0:.1f} km away" if inputs.nav.position_valid and distance_m > _FURTHEST_M else None

    def enter(self, inputs: ModeInputs) -> str | None:
        if (reason := self.check(inputs)) is not None:
            return reason
        assert inputs.leader is not None
        self.law.start(inputs.nav, inputs.leader, inputs.station, inputs.now_s)
        self._thesis.start()
        self._headway.reset()
        self._held = None
        self._waiting = False
        return None

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

    def excuse(self) -> None:
        self._headway.reset()

    def update(self, inputs: ModeInputs) -> Setpoint:
        nav, leader = inputs.nav, inputs.leader
        if leader is None:
            return self._wait(nav, inputs)
        motion = self.law.update(nav, leader, inputs.station, inputs.now_s)
        by_thesis = self._parameters["FOLL_LAW"] == _THESIS
        if by_thesis and not self._by_thesis:
            self._thesis.start()
        self._by_thesis = by_thesis
        if self._must_wait(motion, nav, inputs) and not motion.evading:
            return self._shown(self._wait(nav, inputs), motion)
        if not motion.evading and closes_too_fast(nav, leader, self._parameters["FOLL_MIN_DIST"], self._parameters["FOLL_TTC"]):
            return self._shown(self._braked(nav), motion)
        if by_thesis:
            return self._thesis.update(nav, leader, inputs.station[0], inputs.dt_s)
        if motion.resting and self._reverses:
            return self._shown(self._rest(motion, leader, inputs), motion)
        self._held = None
        self._make_way(motion, nav, inputs)
        return self.law.setpoint(motion, nav, inputs.dt_s)

    # --- beside a leader at rest -----------------------------------------------------------------------------------

    def _rest(self, motion: Motion, leader: Leader, inputs: ModeInputs) -> Setpoint:
        """Held at the station, with the leader's heading."""
        if self._held is None:
            self._station.stop_here(inputs.nav)
        if self._held is None or math.dist(self._held, motion.station) > _MOVED_M:
            self._station.go_to(inputs.nav, *motion.station, leader.yaw_rad, None, fresh=False)
            self._held = motion.station
        return self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)

    # --- the fence -------------------------------------------------------------------------------------------------

    def _must_wait(self, motion: Motion, nav: NavState, inputs: ModeInputs) -> bool:
        """Whether following would lead out of the fence: it stops where it is, inside, until its station is inside as well."""
        fence = self._fence
        if fence.areas() is None:
            self._waiting = False
            return False
        here = (nav.north_m, nav.east_m)
        beyond = fence.point_refusal(*motion.station) or (fence.line_refusal((here, self._stop(nav))) if fence.point_refusal(*here) is None else None)
        if self._waiting:
            beyond = beyond or fence.line_refusal((here, motion.station))
        if beyond is not None and not self._waiting:
            self._station.stop_here(nav)
            self._held = None
            self._events.say(inputs.now_s, Severity.WARNING, "follow_waits", f"Follow: waiting inside the fence: {beyond}")
        elif beyond is None and self._waiting:
            self._events.say(inputs.now_s, Severity.NOTICE, "follow_goes_on", "Follow: going on")
        self._waiting = beyond is not None
        return self._waiting

    def _stop(self, nav: NavState) -> tuple[float, float]:
        """Where the boat would come to rest if it were told to now."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        if speed < _MAKING_WAY_MPS:
            return nav.north_m, nav.east_m
        way_m = speed * speed / (2.0 * self._parameters["PATH_ACC"]) if self._reverses else self._coasting.way_m(speed)
        share = (way_m + _DECIDE_S * speed) / speed
        return nav.north_m + share * nav.north_mps, nav.east_m + share * nav.east_mps

    def _wait(self, nav: NavState, inputs: ModeInputs) -> Setpoint:
        if not self._waiting and self._held is None:
            self._station.stop_here(nav)
            self._held = (nav.north_m, nav.east_m)
        return self._station.update(nav, None, inputs.speed_mps, inputs.dt_s)

    def _braked(self, nav: NavState) -> Setpoint:
        """No thrust ahead; astern where the boat has it."""
        if not self._reverses:
            return Setpoint(SetpointKind.WRENCH, wrench=ZERO_WRENCH)
        return Setpoint(SetpointKind.PATH, yaw_rad=nav.yaw_rad, surge_mps=-self._parameters["DP_SPEED_ASTERN"])

    # --- parts -----------------------------------------------------------------------------------------------------

    @staticmethod
    def _shown(setpoint: Setpoint, motion: Motion) -> Setpoint:
        return replace(
            setpoint, target_north_m=motion.station[0], target_east_m=motion.station[1], cross_track_error_m=motion.cross_m,
            course_rad=motion.track_rad, distance_to_go_m=motion.off_m,
        )  # fmt: skip

    def _make_way(self, motion: Motion, nav: NavState, inputs: ModeInputs) -> None:
        """Way is made along the course asked for, whatever the leader does; a boat that is to stand makes none."""
        if motion.speed_mps < _MAKING_WAY_MPS:
            self._headway.reset()
            return
        along = nav.north_mps * math.cos(motion.course_rad) + nav.east_mps * math.sin(motion.course_rad)
        self._way_m += along * inputs.dt_s
        self._headway.update(self._way_m, motion.speed_mps, inputs.now_s)
