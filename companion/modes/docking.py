"""Coming alongside: to the standoff point, lining up, sideways (or bow or stern first) onto the berth, pushing gently. Given up by rule.

Decided by motion with the waves taken off (`alongside.py`). Wind that takes most of what the thrusters have, away from the berth or towards
it, leaves too little for its gusts: then the boat does not even come near.
"""

from __future__ import annotations

import math
from enum import Enum

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import Setpoint, SetpointKind, Severity
from companion.modes.alongside import Alongside, pushing_n
from companion.modes.berth import Berth
from companion.modes.consequence import most_n
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.mode import ModeInputs
from companion.modes.station import Station
from companion.params import Parameters

_BEYOND_M = 0.6  # how far the reference leads past where the berth should be
_BERTH_TOLERANCE_M = 0.4  # contact further off than this from where the berth should be is none
_STALLED_SHARE = 0.35  # of DOCK_SPEED, below which the boat counts as stopped by something
_STALL_S = 0.8  # for how long, before that is believed to be the berth
_OBSTACLE_S = 5.0  # likewise, for something short of the berth
_STALL_LAG_M = 0.03  # by which the reference is then ahead
_STALL_SHARE_OF_PUSH = 0.3  # force beyond that of free motion, that shows that something resists
_FREE_S = 4.0  # over which the force of free motion is averaged
_QUIET_MPS, _QUIET_RADPS = 0.03, math.radians(1.0)
_SEA_SHARE = 0.3  # of the waves' own motion, that is left in the smoothed one
_SETTLE_S = 10.0  # at the standoff point, before the mean force says what wind and current take
_MOST_TAKEN = 0.75  # share of the most the thrusters give, that they may take: gusts are a third more
_CALM_MPS, _SEA_PUSH_S = 0.02, 4.0  # waves that move the boat more than that; in which the push undoes their motion
_GUSTS = 0.5  # share of what wind takes off the berth, pushed more for its gusts
_PRESS_RADPS = 0.2  # bandwidth of the pushing force
_DEEPEST_M, _FURTHEST_M = 0.5, -0.1  # of the reference, from where contact was made
_SWING_1PS, _SWING_MAX_RAD = 0.05, math.radians(5.0)  # alongside the berth decides the heading
_LEFT_M, _LEFT_S = 0.15, 2.0  # the boat has come off the berth
_DOCKED_S = 3.0


class Phase(Enum):
    """How far it has come."""

    GO = "go"
    ALIGN = "align"
    APPROACH = "approach"
    PUSH = "push"
    ABORTED = "aborted"


class Docking:
    """`start(berth, inputs)`, then `update(inputs)` every tick → Setpoint. Each phase is said as an event.

    Remembers the phase and since when, since when the boat has been quiet or stopped, its smoothed motion, the force that wind and current
    take, the most that the thrusters have each way, where contact was made and how deep the reference presses. Needs the achieved wrench
    and the failed thrusters in `inputs`.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard | None = None) -> None:
        self._fence = fence
        self._config = config
        self._parameters = parameters
        self._events = events
        self._station = Station(config, parameters, fence)
        self._berth = Berth(0.0, 0.0, 0.0, (0.0, -1.0), 0.0, 0.0)
        self._motion = Alongside()
        self._most_n: dict[tuple[float, float], tuple[float, float]] = {}
        self._way: list[tuple[float, float, float]] = []
        self._clearing = False
        self._free_n = self._contact_m = self._depth_m = self._yaw_rad = 0.0
        self._phase = Phase.GO
        self._since_s = 0.0
        self._left_s: float | None = None
        self._good_s: float | None = None  # since when what the phase waits for has lasted

    @property
    def phase(self) -> Phase:
        return self._phase

    @property
    def alongside(self) -> bool:
        """Pushes against the berth."""
        return self._phase is Phase.PUSH

    @property
    def docked(self) -> bool:
        """Lies against the berth, pushing."""
        return self._phase is Phase.PUSH and self._good_s is not None

    def refusal(self, berth: Berth, inputs: ModeInputs) -> str | None:
        """Why the boat cannot dock there now. Changes nothing."""
        if self._config.limits.sway_n <= 0.0:
            return "this boat cannot push itself sideways"
        if inputs.failed:
            return self._failed_text(inputs)
        off_m, _ = berth.place(inputs.nav.north_m, inputs.nav.east_m)
        if inputs.nav.position_valid and off_m + berth.reach_m < 0.0:
            return "the boat is behind the berth: bring it to the side on which it is to lie"
        line = [(inputs.nav.north_m, inputs.nav.east_m), *(berth.pose(off)[:2] for off in (berth.standoff_m, 0.0))]
        if self._fence is not None and not self._fence.allows_berth(line if inputs.nav.position_valid else line[1:]):
            return "way to the berth crosses the fence"
        return None

    def start(self, berth: Berth, inputs: ModeInputs) -> str | None:
        """Begin from the present motion; a reason where that cannot be. A boat that lies at the berth already just pushes."""
        reason = self.refusal(berth, inputs)
        if reason is not None:
            return reason
        nav = inputs.nav
        self._berth = berth
        self._motion.start(berth)
        self._look_up_most(berth.towards)
        off_m, along_m = berth.place(nav.north_m, nav.east_m)
        self._free_n = 0.0
        aligned = abs(wrap_pi(nav.yaw_rad - berth.yaw_rad)) < math.radians(self._parameters["DOCK_YAW_MAX"])
        if abs(off_m) < _LEFT_M and abs(along_m) < self._parameters["DOCK_OFF_MAX"] and aligned:
            self._press(off_m, 0.0, inputs)
            return None
        self._enter(Phase.GO, inputs.now_s, "Dock: going to the standoff point")
        standoff = berth.pose(berth.standoff_m)
        far = math.hypot(standoff[0] - nav.north_m, standoff[1] - nav.east_m) > self._parameters["DP_TRANSIT_DIST"]
        # the bow comes in on any course and swings: that wants a boat's length more of clear water
        self._way = [berth.pose(berth.standoff_m + self._config.length_m), standoff] if far else [standoff]
        self._go_on(inputs, fresh=True)
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        self._motion.update(inputs)
        reason = self._reason_to_abort(inputs)
        if reason is not None:
            self._abort(reason, inputs)
        match self._phase:
            case Phase.GO:
                return self._go(inputs)
            case Phase.ALIGN:
                return self._align(inputs)
            case Phase.APPROACH:
                return self._approach(inputs)
            case Phase.PUSH:
                return self._push(inputs)
        return self._clear(inputs)

    # --- phases ----------------------------------------------------------------------------------------------------

    def _go_on(self, inputs: ModeInputs, fresh: bool) -> None:
        north_m, east_m, yaw_rad = self._way.pop(0)
        self._station.go_to(inputs.nav, north_m, east_m, yaw_rad, None, fresh=fresh)

    def _go(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._station.arrived:
            if self._way:
                self._go_on(inputs, fresh=False)
            else:
                self._motion.settle()
                self._enter(Phase.ALIGN, inputs.now_s, "Dock: lining up with the berth")
        return setpoint

    def _align(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._lasts(self._is_aligned(), inputs.now_s, self._parameters["DOCK_ALIGN_T"]) and self._motion.settled_s >= _SETTLE_S:
            self._enter(Phase.APPROACH, inputs.now_s, f"Dock: coming alongside at {self._parameters['DOCK_SPEED']:.2f} m/s")
            self._free_n = self._motion.mean_n
            self._come_alongside(inputs, fresh=False)
        return setpoint

    def _is_aligned(self) -> bool:
        motion, parameters = self._motion, self._parameters
        near = math.hypot(motion.off_m - self._berth.standoff_m, motion.along_m) <= parameters["DOCK_TOL"]
        straight = abs(motion.turned_rad) <= math.radians(parameters["DOCK_TOL_YAW"])
        quiet_mps = _QUIET_MPS + _SEA_SHARE * motion.scatter_mps
        return near and straight and math.hypot(motion.closing_mps, motion.sliding_mps) <= quiet_mps and abs(motion.turning_radps) <= _QUIET_RADPS

    def _come_alongside(self, inputs: ModeInputs, fresh: bool) -> None:
        pose = self._berth.pose(-_BEYOND_M)
        self._station.go_to(inputs.nav, *pose, self._parameters["DOCK_SPEED"], fresh=fresh, sideways=True)

    def _approach(self, inputs: ModeInputs) -> Setpoint:
        motion, off_m = self._motion, self._motion.off_now_m
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        lag_m = motion.off_m - self._off_m(setpoint)
        resisted = motion.push_n - self._free_n > _STALL_SHARE_OF_PUSH * self._parameters["DOCK_PUSH_N"]
        stopped = motion.closing_mps < _STALLED_SHARE * self._parameters["DOCK_SPEED"] and lag_m > _STALL_LAG_M
        if min(motion.closing_mps, motion.closing_now_mps) >= _STALLED_SHARE * self._parameters["DOCK_SPEED"]:
            self._free_n += (pushing_n(self._berth, inputs) - self._free_n) * inputs.dt_s / _FREE_S
        at_berth = off_m < _BERTH_TOLERANCE_M
        if self._lasts(stopped and resisted, inputs.now_s, _STALL_S if at_berth else _OBSTACLE_S):
            if at_berth:
                self._press(motion.off_m, lag_m, inputs)
            else:
                self._abort(f"stopped {off_m:.1f} m short of the berth", inputs)
        return setpoint

    def _press(self, off_m: float, lag_m: float, inputs: ModeInputs) -> None:
        """Contact: from here on the reference rests, as deep beyond the boat as it was."""
        self._contact_m, self._depth_m = off_m, min(_DEEPEST_M, max(_FURTHEST_M, lag_m))
        self._yaw_rad = self._berth.yaw_rad
        self._enter(Phase.PUSH, inputs.now_s, f"Dock: contact, pushing with {self._parameters['DOCK_PUSH_N']:.0f} N")
        self._left_s = None

    def _push(self, inputs: ModeInputs) -> Setpoint:
        """Pose control whose target is moved until the force towards the berth is the one wanted: no integrator winds up against the fender."""
        nav, berth, dt_s, now_s = inputs.nav, self._berth, inputs.dt_s, inputs.now_s
        wanted_n = self._wanted_n()
        stiffness = self._stiffness_npm()
        depth_m = self._depth_m + _PRESS_RADPS * dt_s * (wanted_n - pushing_n(berth, inputs)) / stiffness
        self._depth_m = min(_DEEPEST_M, max(_FURTHEST_M, depth_m))
        swing_rad = wrap_pi(self._yaw_rad + _SWING_1PS * dt_s * wrap_pi(nav.yaw_rad - self._yaw_rad) - berth.yaw_rad)
        self._yaw_rad = berth.yaw_rad + min(_SWING_MAX_RAD, max(-_SWING_MAX_RAD, swing_rad))
        if self._good_s is None and now_s - self._since_s >= _DOCKED_S:
            self._good_s = now_s
            self._events.say(now_s, Severity.NOTICE, "dock_docked", "Docked: pushing until disarmed")
        self._mind_contact(inputs)
        north_m, east_m, _ = berth.pose(self._contact_m - self._depth_m)
        return Setpoint(
            SetpointKind.POSE, north_m=north_m, east_m=east_m, yaw_rad=wrap_pi(self._yaw_rad), target_north_m=berth.north_m, target_east_m=berth.east_m
        )

    def _wanted_n(self) -> float:
        """What wind and current take and something for gusts, what brings the boat back from a wave, and the push asked for."""
        back_n = self._inertia_kg() * self._motion.scatter_mps / _SEA_PUSH_S if self._motion.scatter_mps > _CALM_MPS else 0.0
        wanted_n = (1.0 + _GUSTS) * max(0.0, self._free_n) + back_n + self._parameters["DOCK_PUSH_N"]
        return min(wanted_n, self._most_n[self._berth.towards][0])

    def _mind_contact(self, inputs: ModeInputs) -> None:
        """Come alongside again after wind or wake has taken the boat off."""
        if self._motion.off_now_m - self._contact_m <= _LEFT_M:
            self._left_s = None
        elif self._left_s is None:
            self._left_s = inputs.now_s
        elif inputs.now_s - self._left_s >= _LEFT_S:
            self._enter(Phase.APPROACH, inputs.now_s, "Dock: off the berth, coming alongside again")
            self._come_alongside(inputs, fresh=True)

    def _clear(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._clearing and self._station.arrived:
            self._clearing = False
            self._events.say(inputs.now_s, Severity.NOTICE, "dock_clear", "Dock: holding off the berth; choose Dock to try again")
        return setpoint

    # --- giving up -------------------------------------------------------------------------------------------------

    def _reason_to_abort(self, inputs: ModeInputs) -> str | None:
        phase, nav, parameters = self._phase, inputs.nav, self._parameters
        if phase in (Phase.ABORTED, Phase.PUSH):
            return None
        if inputs.failed:
            return self._failed_text(inputs)
        if phase is Phase.GO:
            return None
        if nav.position_accuracy_m > parameters["DOCK_POS_ACC"]:
            return f"position known to {nav.position_accuracy_m:.2f} m only"
        if inputs.now_s - self._since_s > parameters["DOCK_TIMEOUT"]:
            return f"{'lining up' if phase is Phase.ALIGN else 'coming alongside'} took more than {parameters['DOCK_TIMEOUT']:.0f} s"
        return self._strays() if phase is Phase.APPROACH else self._overpowered()

    def _overpowered(self) -> str | None:
        """Wind and current take so much that their gusts would have the boat, or waves do."""
        if self._motion.settled_s < _SETTLE_S:
            return None
        if self._motion.scatter_mps > self._parameters["DOCK_WAVE_MAX"]:
            return f"waves move the boat by {self._motion.scatter_mps:.2f} m/s"
        taken_n, (towards_n, away_n) = self._motion.mean_n, self._most_n[self._berth.towards]
        if taken_n > _MOST_TAKEN * towards_n:
            return f"wind and current take {taken_n:.0f} N, the thrusters have {towards_n:.0f} N towards the berth"
        if -taken_n > _MOST_TAKEN * away_n:
            return f"wind and current take {-taken_n:.0f} N, the thrusters have {away_n:.0f} N to keep off the berth"
        return None

    def _strays(self) -> str | None:
        parameters, motion = self._parameters, self._motion
        if abs(motion.along_m) > parameters["DOCK_OFF_MAX"]:
            return f"{abs(motion.along_now_m):.2f} m off the line"
        if abs(motion.turned_rad) > math.radians(parameters["DOCK_YAW_MAX"]):
            return f"heading {math.degrees(abs(motion.turned_now_rad)):.0f} deg off"
        if motion.off_m < -_BERTH_TOLERANCE_M:
            return f"no berth {-motion.off_m:.1f} m beyond where it should be"
        return None

    def _abort(self, reason: str, inputs: ModeInputs) -> None:
        self._enter(Phase.ABORTED, inputs.now_s, f"Docking given up: {reason}; back to the standoff point", Severity.WARNING)
        self._clearing = True
        self._station.go_to(inputs.nav, *self._berth.pose(self._berth.standoff_m), None)

    # --- parts -----------------------------------------------------------------------------------------------------

    def _enter(self, phase: Phase, now_s: float, text: str, severity: Severity = Severity.NOTICE) -> None:
        self._phase, self._since_s, self._good_s = phase, now_s, None
        self._events.say(now_s, severity, f"dock_{phase.value}", text)

    def _lasts(self, condition: bool, now_s: float, duration_s: float) -> bool:
        """Whether `condition` has held for `duration_s`."""
        if not condition:
            self._good_s = None
            return False
        if self._good_s is None:
            self._good_s = now_s
        return now_s - self._good_s >= duration_s - 1e-9

    def _off_m(self, setpoint: Setpoint) -> float:
        return self._berth.place(setpoint.north_m or 0.0, setpoint.east_m or 0.0)[0]

    def _look_up_most(self, towards: tuple[float, float]) -> None:
        """Force towards the berth, and away from it, that the thrusters can keep up."""
        if towards not in self._most_n:
            x, y = towards
            self._most_n[towards] = most_n(self._config, x, y), most_n(self._config, -x, -y)

    def _inertia_kg(self) -> float:
        return self._config.hull.m22_kg if self._berth.towards[0] == 0.0 else self._config.hull.m11_kg

    def _stiffness_npm(self) -> float:
        """Of the pose control, towards the berth."""
        return self._inertia_kg() * self._parameters["DP_BW_SWAY" if self._berth.towards[0] == 0.0 else "DP_BW_SURGE"] ** 2

    def _failed_text(self, inputs: ModeInputs) -> str:
        names = [self._config.thrusters[i].name for i in sorted(inputs.failed)]
        return f"thruster {' and '.join(names)} failed"
