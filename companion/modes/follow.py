"""Follow: keeps the follow position relative to the lead boat."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.baselines.following import ThesisFollowing
from companion.config.reversing import can_reverse
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.decision import (
    SELF_STEERED_NEEDS,
    KnownRefusal,
    LossFailsafe,
    ModeDeclaration,
    ModeId,
    ModeInputs,
    Need,
    TextKind,
)
from companion.core.estimate import Leader, NavState
from companion.core.events import EventLog
from companion.core.setpoint import PathSetpoint, Point, Setpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.following.clearance import closes_too_fast
from companion.following.keeping_up import KeepingUp
from companion.following.law import BESIDE_MPS, FollowLaw, FollowMotion, WayRound
from companion.guidance.coasting import Coasting
from companion.modes.mode import Mode
from companion.modes.parts.headway import Headway
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint

_THESIS = 1  # FOLL_LAW
_FURTHEST_M = 2000.0
_MOVED_M = 1.0  # move of a resting leader's follow position that makes the boat go to it again
_MAKING_WAY_MPS = 0.5
_DECIDE_S = 1.0
_FREE_S = 2.0  # for which the way must be free before a boat that waits inside the fence goes on: it has slowed down
_FASTEST_MPS = 25.0
_LOOK_S = 0.5  # between two looks for a way round the fence: the follow position moves
_TURN_SHARE = 0.75  # of PATH_YAW_RATE, that the boat surely reaches


class FollowMode(Mode):
    """Follows in the track of the lead boat, or beside it. Beside a leader at rest the boat holds its position if it
    has reverse thrust; otherwise it drifts.

    Remembers the state of its law, the follow position that it holds beside a leader at rest, whether it stops before
    that, and the way made. It also remembers whether it waits inside the fence because the follow position is outside
    or the way there is, by which way it goes round the fence meanwhile, and whether it waits for the leader.
    """

    declaration = ModeDeclaration(
        id=ModeId.FOLLOW,
        text="Keeps a position on the lead boat, astern in its track",
        px4=0x08040000,
        rover=6,
        needs=SELF_STEERED_NEEDS | {Need.LEADER},
        early=True,  # ground stations send their position only once the boat is in Follow
        failsafe=LossFailsafe(
            "leader_lost",
            TextKind.ALARM,
            "FOLL_LOSS_ACT",
            "Leader can be followed again",
            back_after="FOLL_BACK_T",
        ),
        commands=(32, 33, 31012),  # DO_FOLLOW, DO_FOLLOW_REPOSITION, USER_3: follow position
        refusals=(
            KnownRefusal(
                r"no leader heard|leader \d+ not heard",
                "no leader heard",
                "Start the leader module, or Follow Me. <param>FOLL_SYSID</param> names the leader.",
            ),
            KnownRefusal(
                r"leader silent.*|leader has only just been heard",
                "the leader is not heard steadily",
                "Wait, or look at the link to the lead boat.",
            ),
            KnownRefusal(
                r"leader without a position.*|leader has no position",
                "the leader has no position",
                "Look at the receiver of the lead boat.",
            ),
            KnownRefusal(
                r"leader jumped .*|leader repeats its position",
                "the leader's position cannot be true",
                "Look at the receiver of the lead boat.",
            ),
            KnownRefusal(r"own position .*", "own position is not known", "Wait for a satellite fix."),
            KnownRefusal(r"the leader is .* km away", "the leader is over 2 km away", "Sail nearer to the leader."),
        ),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._parameters = parameters
        self._events = events
        self._fence = fence
        self._reverses = can_reverse(config.thrusters)
        self._coasting = Coasting(config.hull, _FASTEST_MPS)
        self.law = FollowLaw(config, parameters, self._reverses)
        self._thesis = ThesisFollowing(config, parameters)
        self._hold_point = HoldPoint(config, parameters, fence)
        self._headway = Headway("Follow", events)
        self._keeping_up = KeepingUp(events)
        self._held: tuple[float, float] | None = None
        self._waiting = self._stopping = False
        self._barred_s = -math.inf  # when the fence last barred the way
        self._way: WayRound | None = None  # round the fence
        self._looked_s = -math.inf
        self._standing_by = False
        self._by_thesis = False
        self._way_m = 0.0
        standing = (
            "holds by dynamic positioning"
            if config.limits.sway_n > 0.0
            else "holds"
            if self._reverses
            else "drifts, and turns away from a leader that goes astern"
        )
        self._text = f"{self.declaration.text}; beside a leader at rest it {standing}"

    @property
    def text(self) -> str:
        """What Follow does on this boat, with its behaviour beside a leader at rest."""
        return self._text

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without a valid leader, or if the leader is over 2 km away."""
        leader = inputs.leader
        if inputs.leader_fault is not None or leader is None:
            return inputs.leader_fault or "no leader heard"
        distance_m = math.hypot(leader.north_m - inputs.nav.north_m, leader.east_m - inputs.nav.east_m)
        return (
            f"the leader is {distance_m / 1000.0:.1f} km away"
            if inputs.nav.position_valid and distance_m > _FURTHEST_M
            else None
        )

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start the following law from the present motion of both boats."""
        if (reason := self.check(inputs)) is not None:
            return reason
        assert inputs.leader is not None
        self.law.start(inputs.nav, inputs.leader, inputs.station, inputs.now_s)
        self._thesis.start()
        self._headway.reset()
        self._held = self._way = None
        self._waiting = self._standing_by = self._stopping = False
        return None

    def stand_by(self, inputs: ModeInputs) -> Setpoint:
        """Hold here until the leader is heard."""
        if not self._standing_by:
            self._hold_point.stop_here(inputs.nav)
            self._standing_by = True
        return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)

    def leave(self) -> None:
        """Stand by no longer."""
        self._standing_by = False

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway along the course to the follow position; None if unknown."""
        return self._headway.stuck_s(now_s)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Wait, brake, hold or follow, depending on the fence and the leader's motion."""
        nav, leader = inputs.nav, inputs.leader
        if leader is None:
            return self._wait(nav, inputs)
        motion = self.law.update(nav, leader, inputs.station, inputs.now_s, inputs.steers_late_s, self._way)
        by_thesis = self._parameters["FOLL_LAW"] == _THESIS
        if by_thesis and not self._by_thesis:
            self._thesis.start()
        self._by_thesis = by_thesis
        if self._must_wait(motion, nav, inputs) and self._way is None and not motion.evading:
            return self._shown(self._wait(nav, inputs), motion)
        if not motion.evading and closes_too_fast(
            nav, leader, self._parameters["FOLL_MIN_DIST"], self._parameters["FOLL_TTC"]
        ):
            return self._shown(self._braked(nav), motion)
        if by_thesis and self._way is None:
            return self._thesis.update(nav, leader, inputs.station[0], inputs.dt_s)
        if motion.resting and self._reverses:
            return self._shown(self._rest(motion, leader, inputs), motion)
        self._held, self._stopping = None, False
        self._make_way(motion, nav, inputs)
        return self.law.setpoint(motion, nav, inputs.dt_s)

    # --- beside a leader at rest -----------------------------------------------------------------------------------

    def _rest(self, motion: FollowMotion, leader: Leader, inputs: ModeInputs) -> Setpoint:
        """Hold the follow position, with the leader's heading. A boat that is faster than it may be there first
        stops."""
        self.law.let_go()
        fast = math.hypot(inputs.nav.north_mps, inputs.nav.east_mps) > BESIDE_MPS
        if self._held is None and not self._stopping:
            self._hold_point.stop_here(inputs.nav)
        self._stopping = self._held is None and fast
        if self._stopping:
            return self._hold_point.update(inputs.nav, None, min(inputs.speed_mps, BESIDE_MPS), inputs.dt_s)
        if self._held is None or math.dist(self._held, motion.target) > _MOVED_M:
            self._hold_point.go_to(inputs.nav, *motion.target, leader.yaw_rad, None, fresh=False)
            self._held = motion.target
        return self._hold_point.update(inputs.nav, None, min(inputs.speed_mps, BESIDE_MPS), inputs.dt_s)

    # --- the fence -------------------------------------------------------------------------------------------------

    def _must_wait(self, motion: FollowMotion, nav: NavState, inputs: ModeInputs) -> bool:
        """Whether following would lead out of the fence. The boat then stops inside, and goes round the fence where it
        can; else it waits until the follow position is inside too."""
        fence = self._fence
        if fence.areas() is None:
            self._waiting, self._way = False, None
            return False
        here = (nav.north_m, nav.east_m)
        outside = fence.point_refusal(*motion.target)
        beyond = outside
        if self._way is None and fence.point_refusal(*here) is None:
            beyond = beyond or fence.line_refusal((here, self._stop(nav)))
        if self._waiting:
            beyond = beyond or fence.line_refusal((here, motion.target))
        if beyond is not None:
            self._barred_s = inputs.now_s
        if beyond is not None and not self._waiting:
            self._stop_inside(beyond, nav, inputs.now_s)
        elif self._waiting and inputs.now_s - self._barred_s >= _FREE_S:
            self._way = None
            self._tell(inputs.now_s, TextKind.ROUTINE, "follow_goes_on", "Follow: going on")
        if self._waiting:
            self._go_round(outside, motion, nav, inputs.now_s)
        return self._waiting

    def _stop_inside(self, beyond: str, nav: NavState, now_s: float) -> None:
        self._hold_point.stop_here(nav)
        self._held = None
        self._tell(now_s, TextKind.ATTENTION, "follow_waits", f"Follow waits inside the fence: {beyond}")

    def _go_round(self, outside: str | None, motion: FollowMotion, nav: NavState, now_s: float) -> None:
        """Look for a way round the fence to a follow position inside it, and take it once the boat is so slow that it
        can turn there. A way round a fence with very many corners takes too long to find."""
        going = self._way is not None
        if outside is not None or not self._has_room(nav, going):
            if going:
                self._way = None
                self._stop_inside(outside or "no room", nav, now_s)
            return
        if now_s - self._looked_s < _LOOK_S or not self._fence.allowed.is_small:
            return
        self._looked_s = now_s
        way = self._fence.way((nav.north_m, nav.east_m), motion.target)
        if way is None:
            if going:
                self._way = None
                self._stop_inside("no way round", nav, now_s)
            return
        if not going and len(way.points) == 2:
            return  # straight: it goes on by itself
        radius_m = self._parameters["NAV_ACC_RAD"] if way.radius_m is None else way.radius_m
        self._way = WayRound(way.points[1:], radius_m)
        if not going:
            text = f"Follow goes round the fence: {way.length_m:.0f} m"
            self._events.say(now_s, TextKind.ROUTINE, "follow_goes_round", text)

    def _has_room(self, nav: NavState, going: bool) -> bool:
        """Whether the boat stops before the fence, or can turn before it and is about to."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        if speed < _MAKING_WAY_MPS:
            return True
        place = (nav.north_m, nav.east_m)
        room_m = self._fence.room_m(place, math.atan2(nav.east_mps, nav.north_mps))
        turn_m = _DECIDE_S * speed + speed / (_TURN_SHARE * math.radians(self._parameters["PATH_YAW_RATE"]))
        return room_m >= (min(turn_m, math.dist(place, self._stop(nav))) if going else turn_m)

    def _tell(self, now_s: float, kind: TextKind, name: str, text: str) -> None:
        """Wait or go on, and say so: each is news after the other, however soon."""
        self._waiting = name == "follow_waits"
        self._events.renew("follow_goes_on" if self._waiting else "follow_waits")
        self._events.say(now_s, kind, name, text)

    def _stop(self, nav: NavState) -> tuple[float, float]:
        """The (north_m, east_m) at which the boat would come to rest if it began to stop now."""
        speed = math.hypot(nav.north_mps, nav.east_mps)
        if speed < _MAKING_WAY_MPS:
            return nav.north_m, nav.east_m
        way_m = speed * speed / (2.0 * self._parameters["PATH_ACC"]) if self._reverses else self._coasting.way_m(speed)
        share = (way_m + _DECIDE_S * speed) / speed
        return nav.north_m + share * nav.north_mps, nav.east_m + share * nav.east_mps

    def _wait(self, nav: NavState, inputs: ModeInputs) -> Setpoint:
        self.law.let_go()
        if not self._waiting and self._held is None:
            self._hold_point.stop_here(nav)
            self._held = (nav.north_m, nav.east_m)
        return self._hold_point.update(nav, None, inputs.speed_mps, inputs.dt_s)

    def _braked(self, nav: NavState) -> Setpoint:
        """Slow down: go astern if the boat has reverse thrust, else give no thrust."""
        if not self._reverses:
            return WrenchSetpoint(ZERO_WRENCH)
        return PathSetpoint(nav.yaw_rad, -self._parameters["DP_SPEED_ASTERN"])

    # --- parts -----------------------------------------------------------------------------------------------------

    @staticmethod
    def _shown(setpoint: Setpoint, motion: FollowMotion) -> Setpoint:
        """The setpoint with the progress that ground stations show."""
        progress = replace(
            setpoint.progress,
            target=Point(*motion.target),
            cross_track_error_m=motion.cross_m,
            course_rad=motion.track_rad,
            distance_to_go_m=motion.off_m,
        )
        return replace(setpoint, progress=progress)

    def _make_way(self, motion: FollowMotion, nav: NavState, inputs: ModeInputs) -> None:
        """Watch the headway along the requested course, unless the boat should stand still, and whether it keeps up."""
        along = nav.north_mps * math.cos(motion.course_rad) + nav.east_mps * math.sin(motion.course_rad)
        if not motion.evading:
            self._keeping_up.update(motion.off_m, motion.speed_mps, along, inputs.now_s, self.law.most_mps)
        if motion.speed_mps < _MAKING_WAY_MPS:
            self._headway.reset()
            return
        self._way_m += along * inputs.dt_s
        self._headway.update(self._way_m, motion.speed_mps, inputs.now_s)
