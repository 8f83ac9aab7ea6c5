"""Offboard: another computer steers by a continuous stream of setpoints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.config.reversing import can_reverse
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.decision import KnownRefusal, LossFailsafe, ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.setpoint import Setpoint
from companion.fence.guard import FenceGuard
from companion.guidance.motion_reference import MotionReference
from companion.guidance.sideslip import steered_hull_of
from companion.guidance.velocity_course import VelocityCourse
from companion.modes.mode import Mode
from companion.modes.parts.guided_limits import GuidedLimits
from companion.modes.parts.headway import Headway
from companion.modes.parts.offboard_target import OffboardTarget
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint

SLOWEST_S = 3.0  # between setpoints that still are a stream, of clients who know Rover's Guided
_PERIODS = 2.5  # of a slow sender, for which its setpoint counts: one may be lost
_FURTHEST_M = 20_000.0
_MOVED_M = 0.001  # move of the point that makes the boat go to it again
_MOVED_UNDER_WAY_M = 0.25


class OffboardMode(Mode):
    """Call `take` with each setpoint, also before the mode is entered; the newest one counts.

    The boat goes to a position setpoint and holds it as in Hold. It follows any other setpoint by dynamic positioning,
    or as course and speed if it cannot push itself sideways.

    Remembers the newest setpoint, its time and how long it counts, the newest refusal, and which part steers.
    `limits`: of this stay, or of the next one.
    """

    declaration = ModeDeclaration(
        id=ModeId.OFFBOARD,
        text="Another computer steers by position, velocity, acceleration, heading or yaw rate",
        px4=0x00060000,
        rover=15,  # GUIDED
        advanced=True,
        slows=True,
        has_plan=False,
        failsafe=LossFailsafe(
            "offboard_lost", TextKind.ALARM, "OFFB_LOSS_ACT", "Offboard setpoints are back", prefix="Offboard: "
        ),
        refusals=(
            KnownRefusal(r"no setpoint.*", "no setpoints come", "Stream setpoints first, several a second."),
            KnownRefusal(r"setpoints refused: .*", "setpoints are refused", "Send points inside the fence."),
        ),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> None:
        self._parameters = parameters
        self._fence = fence
        self._can_sway = config.limits.sway_n > 0.0
        self._hold_point = HoldPoint(config, parameters, fence)
        self._reference = MotionReference(config.length_m, parameters, fence.reach_mps)
        self._course = VelocityCourse(
            parameters, top_speed_mps(config), can_reverse(config.thrusters), steered_hull_of(config)
        )
        self._headway = Headway("Offboard", events)
        self.limits = GuidedLimits()
        self._target: OffboardTarget | None = None
        self._came_s = -math.inf
        self._lasts_s = 0.0  # for how long the newest setpoint counts, where that is longer than OFFB_TIMEOUT
        self._refused: tuple[str, float] = ("", -math.inf)
        self._cleared: tuple[object, ...] | None = None  # the fence and the point that last passed the check together
        self._gone_to: tuple[float, float, float | None] | None = (
            None  # the point and heading last given to the hold point
        )
        self._by_motion = False
        how = (
            "by dynamic positioning"
            if self._can_sway
            else "as course and speed: no heading is held, no way made sideways"
        )
        self._text = f"{self.declaration.text}; {how}"

    @property
    def text(self) -> str:
        """What Offboard does on this boat, depending on its sway force."""
        return self._text

    # --- incoming setpoints ----------------------------------------------------------------------------------------

    def take(self, target: OffboardTarget, nav: NavState, now_s: float, slow: bool = False) -> str | None:
        """Accept a setpoint, or return why it is refused. The last accepted setpoint counts until it times out. `slow`:
        its sender may send once a second, as ArduPilot's pages say: its setpoint counts for two and a half of the
        periods at which they come, SLOWEST_S at most."""
        reason = self._refusal(target, nav)
        if reason is not None:
            self._refused = (reason, now_s)
            return reason
        since_s = now_s - self._came_s
        self._lasts_s = min(SLOWEST_S, _PERIODS * since_s) if slow and since_s <= SLOWEST_S else 0.0
        self._target, self._came_s = target.fixed(nav), now_s
        return None

    def _refusal(self, target: OffboardTarget, nav: NavState) -> str | None:
        if target.needs_place and not (nav.position_valid and nav.heading_valid):
            return "own position or heading is not valid"
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

    def loss(self, now_s: float) -> str | None:
        """Return which limit of the stay is reached, or why there is no valid setpoint; None for neither."""
        return self.limits.reached or self.silence(now_s)

    def silence(self, now_s: float) -> str | None:
        """Return why there is no valid setpoint, or None."""
        most_s = max(self._parameters["OFFB_TIMEOUT"], self._lasts_s)
        age_s = now_s - self._came_s
        if self._target is not None and age_s <= most_s:
            return None
        reason, refused_s = self._refused
        if now_s - refused_s <= most_s:
            return f"setpoints refused: {reason}"
        return "no setpoint yet: stream first" if self._target is None else f"no setpoint for {age_s:.1f} s"

    # --- the mode --------------------------------------------------------------------------------------------------

    @property
    def unplanned(self) -> bool:
        """Velocities of a boat that keeps no place by them: without way it drifts."""
        return self._by_motion and not self._can_sway

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse unless valid setpoints arrive."""
        return self.silence(inputs.now_s)

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start from the present motion; the next tick obeys the newest setpoint."""
        return self._begin(inputs, self.limits.begin)

    def resume(self, inputs: ModeInputs) -> str | None:
        """As `enter`, in the same stay."""
        return self._begin(inputs, self.limits.go_on)

    def _begin(self, inputs: ModeInputs, count: Callable[[NavState, float], None]) -> str | None:
        if (reason := self.check(inputs)) is not None:
            return reason
        count(inputs.nav, inputs.now_s)
        self._headway.reset()
        self._hold_point.stop_here(inputs.nav)
        self._start_motion(inputs.nav)
        self._gone_to = None
        return None

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway to a position setpoint; None if unknown."""
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """The path to a position setpoint; empty for other setpoints."""
        return () if self._by_motion else self._hold_point.way_ahead

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()

    def leave(self) -> None:
        """Forget the limits of the stay."""
        self.limits.end()

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Go to the position setpoint, or follow the requested motion."""
        self.limits.watch(inputs.nav, inputs.now_s)
        target = self._target
        assert target is not None  # `enter` refuses without a setpoint
        if target.is_point or (target.position is not None and target.stands and not self._can_sway):
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
        nav, hold_point = inputs.nav, self._hold_point
        north_m, east_m = target.position
        before = self._gone_to
        if before is None or self._has_moved(before, target):
            if before is None and not self._by_motion:
                hold_point.stop_here(nav)
            hold_point.go_to(nav, north_m, east_m, target.yaw_rad, None, fresh=before is None)
            self._gone_to = (north_m, east_m, target.yaw_rad)
            self._headway.rebase()
        self._by_motion = False
        setpoint = hold_point.update(nav, None, inputs.speed_mps, inputs.dt_s)
        if hold_point.way_m is not None:
            self._headway.update(hold_point.way_m, inputs.speed_mps, inputs.now_s)
        return setpoint

    def _has_moved(self, before: tuple[float, float, float | None], target: OffboardTarget) -> bool:
        """Whether the target differs enough for a new path. In transit, moves of up to 0.25 m are ignored."""
        assert target.position is not None
        moved_m = math.dist(before[:2], target.position)
        return target.yaw_rad != before[2] or moved_m > (
            _MOVED_UNDER_WAY_M if self._hold_point.in_transit else _MOVED_M
        )
