"""Docking: goes to the standoff point, lines up, moves onto the berth (sideways, bow or stern first), pushes gently.

All decisions use the smoothed motion (`alongside.py`), without the waves. Docking is given up when the boat strays, is
stopped short, or runs out of time or accuracy. It is also given up at the standoff point if wind and current leave too
little thrust for gusts.

A boat that is pushed against its fenders stays there while the push outweighs the force of the waves; otherwise the
waves throw it off, and no law can change that. So the boat measures that force, waits at the standoff point while it is
larger than the push that is left, and then pushes so much harder.
"""

from __future__ import annotations

import math
from enum import Enum

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.decision import ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.setpoint import Point, PoseSetpoint, Progress, Setpoint, desired_motion
from companion.fence.guard import FenceGuard
from companion.modes.parts.alongside import Alongside, pushing_n
from companion.modes.parts.berth import Berth
from companion.modes.parts.headway import Headway
from companion.params.store import Parameters
from companion.positioning.consequence import most_n
from companion.positioning.hold_point import HoldPoint

_BEYOND_M = 0.6  # distance of the reference's target beyond the expected berth
_BERTH_TOLERANCE_M = 0.4  # contact further than this from the expected berth is an obstacle
_STALLED_SHARE = 0.35  # share of the speed of approach below which the boat counts as stopped
_STALL_S = 0.8  # time stopped at the berth that counts as contact
_OBSTACLE_S = 5.0  # time stopped short of the berth that counts as an obstacle
_STALL_LAG_M = 0.03  # least distance of the reference ahead of a stopped boat
_STALL_SHARE_OF_PUSH = 0.3  # share of the push above the free-motion force that shows contact
_FREE_S = 4.0  # averaging time of the free-motion force
_QUIET_MPS, _QUIET_RADPS = 0.03, math.radians(1.0)
_SEA_SHARE = 0.3  # share of the waves' motion that smoothing leaves
_SETTLE_S = 10.0  # time at the standoff point until the mean force shows wind and current
_MOST_TAKEN = 0.75  # share of thrust that wind and current may take; gusts take a third more
_CALM_MPS2 = 0.015  # acceleration by gusts and thrusters in flat water
_SLOWER = 0.4  # share of DOCK_SPEED that the boat is slower in waves of as much force as the push that is left
_SEA_GROWN = 1.5  # waves that have grown so much over DOCK_SEA_MAX on the way end the approach
_LEAST_LEFT_N = 0.1
_GUSTS = 0.5  # extra push for gusts, as a share of the force of wind and current
_PRESS_RADPS = 0.2  # bandwidth of the pushing force
_PUSH_SHARE = 1.0 / 3.0  # of the largest lasting force towards the berth: the push if DOCK_PUSH_N leaves it open
_DEEPEST_M, _FURTHEST_M = 0.5, -0.1  # limits of the reference's depth behind the contact, deeper if the push needs it
_YIELD_RADPS, _SWING_MAX_RAD = 1.0, math.radians(5.0)  # the berth turns the boat, so the target heading gives way
_LEFT_M, _LEFT_S = 0.15, 2.0  # distance and time that show that the boat has left the berth
_DOCKED_S = 3.0
_SWING_ROOM_M = 0.3  # to be left between face and hull while the boat turns
_SWEEP_STEP_RAD, _SWEEP_TOLERANCE_M = math.radians(10.0), 0.05


class DockingPhase(Enum):
    """The phases of docking, in order."""

    GO = "go"
    ALIGN = "align"
    APPROACH = "approach"
    PUSH = "push"
    ABORTED = "aborted"


class Docking:
    """Call `start(berth, inputs)`, then `update(inputs)` every tick → Setpoint. Each phase is announced as an event.

    Remembers the phase and its start, how long its end condition has lasted, and the smoothed motion. Remembers too the
    force of wind and current, that of the waves before contact, whether the boat waits for them, the speed of approach,
    the largest thrust each way, the place of contact and the depth of the reference. Needs the achieved wrench and the
    failed thrusters in `inputs`.
    """

    def __init__(
        self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard | None = None
    ) -> None:
        self._fence = fence
        self._config = config
        self._parameters = parameters
        self._events = events
        self._hold_point = HoldPoint(config, parameters, fence)
        self._headway = Headway("Dock", events)
        self._berth = Berth(0.0, 0.0, 0.0, (0.0, -1.0), 0.0, 0.0)
        self._motion = Alongside()
        self._most_n: dict[tuple[float, float], tuple[float, float]] = {}
        self._way: list[tuple[float, float, float]] = []
        self._clearing = self._far = False
        self._speed_mps = self._free_n = self._sea_n = self._contact_m = self._depth_m = self._yaw_rad = 0.0
        self._phase = DockingPhase.GO
        self._since_s = 0.0
        self._left_s: float | None = None
        self._waits = False
        self._good_s: float | None = None  # when the condition that the phase waits for began to hold

    @property
    def phase(self) -> DockingPhase:
        """The present phase."""
        return self._phase

    @property
    def alongside(self) -> bool:
        """Whether the boat pushes against the berth."""
        return self._phase is DockingPhase.PUSH

    @property
    def docked(self) -> bool:
        """Whether the boat has pushed against the berth for long enough to count as docked."""
        return self._phase is DockingPhase.PUSH and self._good_s is not None

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway on the way to the standoff point; None if unknown."""
        return self._headway.stuck_s(now_s)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()

    def refusal(self, berth: Berth, inputs: ModeInputs) -> str | None:
        """Return why the boat cannot dock at the berth now, or None. Changes nothing."""
        if self._config.limits.sway_n <= 0.0:
            return "this boat cannot push itself sideways"
        if inputs.failed:
            return self._failed_text(inputs)
        off_m, _ = berth.place(inputs.nav.north_m, inputs.nav.east_m)
        if inputs.nav.position_valid and off_m + berth.reach_m < 0.0:
            return "boat is behind the berth: go round to its front"
        return self._fence_refusal(berth, inputs)

    def fence_refusal(self, inputs: ModeInputs) -> str | None:
        """Return why a new fence ends docking at the present berth, or None. A boat that pushes against it is there."""
        return None if self.alongside else self._fence_refusal(self._berth, inputs)

    def _fence_refusal(self, berth: Berth, inputs: ModeInputs) -> str | None:
        line = [(inputs.nav.north_m, inputs.nav.east_m), *(berth.pose(off)[:2] for off in (berth.standoff_m, 0.0))]
        if self._fence is not None and not self._fence.allows_berth(line if inputs.nav.position_valid else line[1:]):
            return "way to the berth crosses the fence"
        return None

    def start(self, berth: Berth, inputs: ModeInputs) -> str | None:
        """Start from the present motion. Return a reason if docking is refused, else None. A boat already at the berth
        starts to push."""
        reason = self.refusal(berth, inputs)
        if reason is not None:
            return reason
        nav = inputs.nav
        self._berth = berth
        self._motion.start(berth)
        self._look_up_most(berth.towards)
        self._free_n = self._sea_n = 0.0
        if self._lies_alongside(nav):
            self._press(berth.place(nav.north_m, nav.east_m)[0], 0.0, inputs)
            return None
        self._enter(DockingPhase.GO, inputs.now_s, "Dock: going to the standoff point")
        standoff, turning = berth.pose(berth.standoff_m), self._turning_pose()
        far_m = math.hypot(standoff[0] - nav.north_m, standoff[1] - nav.east_m)
        self._far = far_m > self._parameters["DP_TRANSIT_DIST"]
        self._headway.reset()
        if self._far and self._may_go(nav, turning, standoff):
            self._way = [turning, standoff]
        elif not self._far and self._would_swing_into(berth, nav):
            self._way = [(*turning[:2], nav.yaw_rad), turning, standoff]
        else:
            self._way = [standoff]
        self._go_on(inputs, fresh=True)
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Go on at the same berth after the thrusters were in neutral. What was given up stays so. A boat that still
        lies alongside pushes on, with a failed thruster too. Return a reason if docking is refused, else None."""
        if self._phase is DockingPhase.ABORTED:
            self._hold_point.rejoin(inputs.nav)
            return None
        if self.alongside and self._lies_alongside(inputs.nav):
            self._press(self._berth.place(inputs.nav.north_m, inputs.nav.east_m)[0], 0.0, inputs)
            return None
        return self.start(self._berth, inputs)

    def _would_swing_into(self, berth: Berth, nav: NavState) -> bool:
        """Whether bow or stern would come to the face as the boat turns here or at the standoff point. It goes out
        first then, with its present heading."""
        turned_rad = abs(wrap_pi(nav.yaw_rad - berth.yaw_rad))
        steps = math.ceil(turned_rad / _SWEEP_STEP_RAD) + 1
        reaches_m = [self._reach_m(berth, turned_rad * i / steps) for i in range(steps + 1)]
        room_m = min(berth.place(nav.north_m, nav.east_m)[0], berth.standoff_m) + berth.reach_m
        if max(reaches_m) <= reaches_m[-1] + _SWEEP_TOLERANCE_M or max(reaches_m) + _SWING_ROOM_M <= room_m:
            return False
        return self._may_go(nav, self._turning_pose())

    def _may_go(self, nav: NavState, *poses: tuple[float, float, float]) -> bool:
        """Whether the fence lets the boat go from pose to pose."""
        line = [(nav.north_m, nav.east_m), *(pose[:2] for pose in poses)]
        return self._fence is None or self._fence.allows_berth(line)

    def _reach_m(self, berth: Berth, turned_rad: float) -> float:
        """How far a hull turned from the berth's heading reaches from its middle towards the face."""
        c, s = abs(math.cos(turned_rad)), abs(math.sin(turned_rad))
        half_m = 0.5 * self._config.length_m, 0.5 * self._config.beam_m
        along, across = half_m if berth.towards[0] else (half_m[1], half_m[0])
        return c * along + s * across

    def _lies_alongside(self, nav: NavState) -> bool:
        off_m, along_m = self._berth.place(nav.north_m, nav.east_m)
        aligned = abs(wrap_pi(nav.yaw_rad - self._berth.yaw_rad)) < math.radians(self._parameters["DOCK_YAW_MAX"])
        return abs(off_m) < _LEFT_M and abs(along_m) < self._parameters["DOCK_OFF_MAX"] and aligned

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Give up if a rule requires it, then return the setpoint of the present phase."""
        self._motion.update(inputs)
        reason = self._reason_to_abort(inputs)
        if reason is not None:
            self._abort(reason, inputs)
        match self._phase:
            case DockingPhase.GO:
                return self._go(inputs)
            case DockingPhase.ALIGN:
                return self._align(inputs)
            case DockingPhase.APPROACH:
                return self._approach(inputs)
            case DockingPhase.PUSH:
                return self._push(inputs)
        return self._clear(inputs)

    # --- phases ----------------------------------------------------------------------------------------------------

    def _go_on(self, inputs: ModeInputs, fresh: bool) -> None:
        north_m, east_m, yaw_rad = self._way.pop(0)
        self._headway.rebase()
        self._hold_point.go_to(inputs.nav, north_m, east_m, yaw_rad, None, fresh=fresh, sideways=not self._far)

    def _on_way(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._hold_point.way_m is not None:
            self._headway.update(self._hold_point.way_m, inputs.speed_mps, inputs.now_s)
        return setpoint

    def _go(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._on_way(inputs)
        if self._hold_point.arrived:
            if self._way:
                self._go_on(inputs, fresh=False)
            else:
                self._motion.settle()
                self._waits = False
                self._enter(DockingPhase.ALIGN, inputs.now_s, "Dock: lining up with the berth")
        return setpoint

    def _align(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        settled = self._motion.settled_s >= _SETTLE_S
        rough = settled and self._sea_share(self._motion.mean_n) > self._parameters["DOCK_SEA_MAX"]
        if rough and not self._waits:
            self._waits = True
            text = f"Dock: waits off, {self._sea_text(self._motion.mean_n)}"
            self._events.say(inputs.now_s, TextKind.ATTENTION, "dock_waits", text)
        ready = self._lasts(self._is_aligned() and not rough, inputs.now_s, self._parameters["DOCK_ALIGN_T"])
        if ready and settled:
            self._free_n = self._motion.mean_n
            self._come_alongside(inputs, fresh=False)
            text = f"Dock: coming alongside at {self._speed_mps:.2f} m/s"
            self._enter(DockingPhase.APPROACH, inputs.now_s, text)
        return setpoint

    def _is_aligned(self) -> bool:
        motion, parameters = self._motion, self._parameters
        near = math.hypot(motion.off_m - self._berth.standoff_m, motion.along_m) <= parameters["DOCK_TOL"]
        straight = abs(motion.turned_rad) <= math.radians(parameters["DOCK_TOL_YAW"])
        quiet_mps = _QUIET_MPS + _SEA_SHARE * motion.scatter_mps
        return (
            near
            and straight
            and math.hypot(motion.closing_mps, motion.sliding_mps) <= quiet_mps
            and abs(motion.turning_radps) <= _QUIET_RADPS
        )

    def _come_alongside(self, inputs: ModeInputs, fresh: bool) -> None:
        pose = self._berth.pose(-_BEYOND_M)
        self._speed_mps = self._slowed_mps()
        self._hold_point.go_to(inputs.nav, *pose, self._speed_mps, fresh=fresh, sideways=True)

    def _slowed_mps(self) -> float:
        """DOCK_SPEED, less in waves, whose own speed adds to it at contact."""
        return self._parameters["DOCK_SPEED"] * (1.0 - _SLOWER * min(1.0, self._sea_share(self._free_n)))

    def _approach(self, inputs: ModeInputs) -> Setpoint:
        motion, off_m = self._motion, self._motion.off_now_m
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        lag_m = motion.off_m - self._off_m(setpoint)
        resisted = motion.push_n - self._free_n > _STALL_SHARE_OF_PUSH * self._push_n()
        stopped = motion.closing_mps < _STALLED_SHARE * self._speed_mps and lag_m > _STALL_LAG_M
        if min(motion.closing_mps, motion.closing_now_mps) >= _STALLED_SHARE * self._speed_mps:
            self._free_n += (pushing_n(self._berth, inputs) - self._free_n) * inputs.dt_s / _FREE_S
            self._sea_n = self._wave_n()
        at_berth = off_m < _BERTH_TOLERANCE_M
        if self._lasts(stopped and resisted, inputs.now_s, _STALL_S if at_berth else _OBSTACLE_S):
            if at_berth:
                self._press(motion.off_m, lag_m, inputs)
            else:
                self._abort(f"stopped {off_m:.1f} m short of the berth", inputs)
        return setpoint

    def _press(self, off_m: float, lag_m: float, inputs: ModeInputs) -> None:
        """React to contact: keep the reference at its present depth beyond the boat, and start to push."""
        self._motion.settle()
        self._contact_m, self._depth_m = off_m, min(_DEEPEST_M, max(_FURTHEST_M, lag_m))
        self._yaw_rad = self._berth.yaw_rad
        self._enter(DockingPhase.PUSH, inputs.now_s, f"Dock: contact, pushing with {_newton(self._push_n())} N")
        self._left_s = None

    def _push(self, inputs: ModeInputs) -> Setpoint:
        """Move the target of the pose control until the force towards the berth is the wanted one, and the moment none:
        the fenders keep the heading. So no integrator winds up against them."""
        berth, dt_s, now_s = self._berth, inputs.dt_s, inputs.now_s
        wanted_n = self._wanted_n()
        stiffness = self._stiffness_npm()
        depth_m = self._depth_m + _PRESS_RADPS * dt_s * (wanted_n - pushing_n(berth, inputs)) / stiffness
        self._depth_m = min(max(_DEEPEST_M, wanted_n / stiffness), max(_FURTHEST_M, depth_m))
        give_rad = _YIELD_RADPS * dt_s * inputs.achieved.yaw_nm / self._stiffness_nmprad()
        swing_rad = wrap_pi(self._yaw_rad - give_rad - berth.yaw_rad)
        self._yaw_rad = berth.yaw_rad + min(_SWING_MAX_RAD, max(-_SWING_MAX_RAD, swing_rad))
        if self._good_s is None and now_s - self._since_s >= _DOCKED_S:
            self._good_s = now_s
            self._events.say(now_s, TextKind.ROUTINE, "dock_docked", "Docked: pushing until disarmed")
        self._mind_contact(inputs)
        north_m, east_m, _ = berth.pose(self._contact_m - self._depth_m)
        progress = Progress(target=Point(berth.north_m, berth.east_m))
        return PoseSetpoint(north_m, east_m, wrap_pi(self._yaw_rad), progress=progress)

    def _wanted_n(self) -> float:
        """The force to push with, N: against wind, current and gusts, against the waves, plus the push."""
        back_n = max(self._sea_n, self._wave_n())
        wanted_n = (1.0 + _GUSTS) * max(0.0, self._free_n) + back_n + self._push_n()
        return min(wanted_n, self._most_n[self._berth.towards][0])

    def _push_n(self) -> float:
        """The push of DOCK_PUSH_N; by default as much of its force as a boat of any size keeps up, N."""
        push_n = self._parameters["DOCK_PUSH_N"]
        return push_n if push_n >= 0.0 else _PUSH_SHARE * self._most_n[self._berth.towards][0]

    def _mind_contact(self, inputs: ModeInputs) -> None:
        """Come alongside again after wind or wake has moved the boat off the berth."""
        if self._motion.off_now_m - self._contact_m <= _LEFT_M:
            self._left_s = None
        elif self._left_s is None:
            self._left_s = inputs.now_s
        elif inputs.now_s - self._left_s >= _LEFT_S:
            self._enter(DockingPhase.APPROACH, inputs.now_s, "Dock: off the berth, coming alongside again")
            self._come_alongside(inputs, fresh=True)

    def _clear(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._on_way(inputs)
        if self._clearing and self._hold_point.arrived:
            self._clearing = False
            self._events.say(
                inputs.now_s, TextKind.ATTENTION, "dock_clear", "Dock: holding off the berth; choose Dock to retry"
            )
        return setpoint

    # --- giving up -------------------------------------------------------------------------------------------------

    def _reason_to_abort(self, inputs: ModeInputs) -> str | None:
        phase, nav, parameters = self._phase, inputs.nav, self._parameters
        if phase in (DockingPhase.ABORTED, DockingPhase.PUSH):
            return None
        if inputs.failed:
            return self._failed_text(inputs)
        if phase is DockingPhase.GO:
            return None
        if nav.position_accuracy_m > parameters["DOCK_POS_ACC"]:
            return f"position known to {nav.position_accuracy_m:.2f} m only"
        if inputs.now_s - self._since_s > self._longest_s():
            if phase is DockingPhase.ALIGN and self._waits:
                return self._sea_text(self._motion.mean_n)
            what = "lining up" if phase is DockingPhase.ALIGN else "coming alongside"
            return f"{what} took more than {self._longest_s():.0f} s"
        return self._strays() if phase is DockingPhase.APPROACH else self._overpowered()

    def _longest_s(self) -> float:
        """How long the present phase may last: DOCK_TIMEOUT, and the time that the way to the berth takes."""
        if self._phase is DockingPhase.ALIGN:
            return self._parameters["DOCK_TIMEOUT"]
        return self._parameters["DOCK_TIMEOUT"] + (self._berth.standoff_m + _BEYOND_M) / self._speed_mps

    def _overpowered(self) -> str | None:
        """Return why wind, current or waves are too strong to come alongside, or None."""
        if self._motion.settled_s < _SETTLE_S:
            return None
        if self._motion.scatter_mps > self._parameters["DOCK_WAVE_MAX"]:
            return f"waves move the boat by {self._motion.scatter_mps:.2f} m/s"
        taken_n, (towards_n, away_n) = self._motion.mean_n, self._most_n[self._berth.towards]
        if taken_n > _MOST_TAKEN * towards_n:
            return f"weather {_newton(taken_n)} N, thrust {_newton(towards_n)} N"
        if -taken_n > _MOST_TAKEN * away_n:
            return f"weather {_newton(-taken_n)} N, thrust {_newton(away_n)} N off the berth"
        return None

    def _strays(self) -> str | None:
        parameters, motion = self._parameters, self._motion
        if abs(motion.along_m) > parameters["DOCK_OFF_MAX"]:
            return f"{abs(motion.along_now_m):.2f} m off the line"
        if abs(motion.turned_rad) > math.radians(parameters["DOCK_YAW_MAX"]):
            return f"heading {math.degrees(abs(motion.turned_now_rad)):.0f} deg off"
        if self._sea_share(self._free_n) > _SEA_GROWN * parameters["DOCK_SEA_MAX"]:
            return self._sea_text(self._free_n)
        if motion.off_m < -_BERTH_TOLERANCE_M:
            return f"no berth {-motion.off_m:.1f} m beyond where it should be"
        return None

    def _abort(self, reason: str, inputs: ModeInputs) -> None:
        """Hold off the berth: a boat that has lined up at the standoff point, any other where it has room to turn."""
        going = self._phase is DockingPhase.GO
        self._enter(DockingPhase.ABORTED, inputs.now_s, f"Docking given up: {reason}", TextKind.ATTENTION)
        self._clearing = True
        turning, standoff = self._turning_pose(), self._berth.pose(self._berth.standoff_m)
        clear = turning if going and self._may_go(inputs.nav, turning) else standoff
        self._headway.rebase()
        self._hold_point.go_to(inputs.nav, *clear, None)

    def _turning_pose(self) -> tuple[float, float, float]:
        """A boat length further out than the standoff point: it arrives there on any course and swings its bow."""
        return self._berth.pose(self._berth.standoff_m + self._config.length_m)

    # --- parts -----------------------------------------------------------------------------------------------------

    def _enter(self, phase: DockingPhase, now_s: float, text: str, kind: TextKind = TextKind.ROUTINE) -> None:
        self._phase, self._since_s, self._good_s = phase, now_s, None
        self._events.say(now_s, kind, f"dock_{phase.value}", text)

    def _lasts(self, condition: bool, now_s: float, duration_s: float) -> bool:
        """Whether `condition` has held for `duration_s`."""
        if not condition:
            self._good_s = None
            return False
        if self._good_s is None:
            self._good_s = now_s
        return now_s - self._good_s >= duration_s - 1e-9

    def _off_m(self, setpoint: Setpoint) -> float:
        place = desired_motion(setpoint).place or Point(0.0, 0.0)
        return self._berth.place(place.north_m, place.east_m)[0]

    def _look_up_most(self, towards: tuple[float, float]) -> None:
        """Compute the largest lasting force towards the berth and away from it, once for each direction."""
        if towards not in self._most_n:
            x, y = towards
            self._most_n[towards] = most_n(self._config, x, y), most_n(self._config, -x, -y)

    def _wave_n(self) -> float:
        """The rms force that would keep the boat from moving with the waves towards the berth and away from it, N."""
        return self._inertia_kg() * math.sqrt(max(0.0, self._motion.shaken_mps2**2 - _CALM_MPS2**2))

    def _left_n(self, taken_n: float) -> float:
        """The push that is left where wind and current take `taken_n`, N. What they add counts for nothing: it ends."""
        return max(_LEAST_LEFT_N, self._most_n[self._berth.towards][0] - max(0.0, taken_n))

    def _sea_share(self, taken_n: float) -> float:
        """The force of the waves as a share of the push that is left."""
        return self._wave_n() / self._left_n(taken_n)

    def _sea_text(self, taken_n: float) -> str:
        return f"waves {_newton(self._wave_n())} N, push left {_newton(self._left_n(taken_n))} N"

    def _inertia_kg(self) -> float:
        return self._config.hull.m22_kg if self._berth.towards[0] == 0.0 else self._config.hull.m11_kg

    def _stiffness_npm(self) -> float:
        """The stiffness of the pose control towards the berth, N/m."""
        return (
            self._inertia_kg() * self._parameters["DP_BW_SWAY" if self._berth.towards[0] == 0.0 else "DP_BW_SURGE"] ** 2
        )

    def _stiffness_nmprad(self) -> float:
        """The stiffness of the pose control in yaw, N·m/rad."""
        return self._config.hull.m33_kgm2 * self._parameters["DP_BW_YAW"] ** 2

    def _failed_text(self, inputs: ModeInputs) -> str:
        names = [self._config.thrusters[i].name for i in sorted(inputs.failed)]
        return f"thruster {' and '.join(names)} failed"


def _newton(force_n: float) -> str:
    """A force for a text, with a digit behind the point where a small boat pushes."""
    return f"{force_n:.0f}" if force_n >= 3.0 else f"{force_n:.1f}"
