"""Coming alongside: to the standoff point, lining up, sideways (or bow or stern first) onto the berth, pushing gently. Given up by rule."""

from __future__ import annotations

import math
from enum import Enum

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import Setpoint, SetpointKind, Severity
from companion.modes.berth import Berth
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

    Remembers the phase and since when, since when the boat has been quiet or stopped, the force that wind and current take, where contact
    was made and how deep the reference presses. Needs the achieved wrench and the failed thrusters in `inputs`.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard | None = None) -> None:
        self._fence = fence
        self._config = config
        self._parameters = parameters
        self._events = events
        self._station = Station(config, parameters, fence)
        self._berth = Berth(0.0, 0.0, 0.0, (0.0, -1.0), 0.0, 0.0)
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
                self._enter(Phase.ALIGN, inputs.now_s, "Dock: lining up with the berth")
        return setpoint

    def _align(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._lasts(self._is_aligned(inputs), inputs.now_s, self._parameters["DOCK_ALIGN_T"]):
            self._enter(Phase.APPROACH, inputs.now_s, f"Dock: coming alongside at {self._parameters['DOCK_SPEED']:.2f} m/s")
            self._free_n = self._pushing_n(inputs)
            self._come_alongside(inputs, fresh=False)
        return setpoint

    def _is_aligned(self, inputs: ModeInputs) -> bool:
        nav, berth = inputs.nav, self._berth
        north_m, east_m, _ = berth.pose(berth.standoff_m)
        near = math.hypot(nav.north_m - north_m, nav.east_m - east_m) <= self._parameters["DOCK_TOL"]
        straight = abs(wrap_pi(nav.yaw_rad - berth.yaw_rad)) <= math.radians(self._parameters["DOCK_TOL_YAW"])
        return near and straight and math.hypot(nav.surge_mps, nav.sway_mps) <= _QUIET_MPS and abs(nav.yaw_rate_radps) <= _QUIET_RADPS

    def _come_alongside(self, inputs: ModeInputs, fresh: bool) -> None:
        pose = self._berth.pose(-_BEYOND_M)
        self._station.go_to(inputs.nav, *pose, self._parameters["DOCK_SPEED"], fresh=fresh, sideways=True)

    def _approach(self, inputs: ModeInputs) -> Setpoint:
        nav, berth = inputs.nav, self._berth
        setpoint = self._station.update(nav, None, inputs.speed_mps, inputs.dt_s)
        off_m, _ = berth.place(nav.north_m, nav.east_m)
        lag_m = off_m - self._off_m(setpoint)
        push_n = self._pushing_n(inputs)
        resisted = push_n - self._free_n > _STALL_SHARE_OF_PUSH * self._parameters["DOCK_PUSH_N"]
        stopped = berth.closing_mps(nav) < _STALLED_SHARE * self._parameters["DOCK_SPEED"] and lag_m > _STALL_LAG_M
        if not stopped:
            self._free_n += (push_n - self._free_n) * inputs.dt_s / _FREE_S
        at_berth = off_m < _BERTH_TOLERANCE_M
        if self._lasts(stopped and resisted, inputs.now_s, _STALL_S if at_berth else _OBSTACLE_S):
            if at_berth:
                self._press(off_m, lag_m, inputs)
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
        wanted_n = max(0.0, self._free_n) + self._parameters["DOCK_PUSH_N"]
        stiffness = self._stiffness_npm()
        depth_m = self._depth_m + _PRESS_RADPS * dt_s * (wanted_n - self._pushing_n(inputs)) / stiffness
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

    def _mind_contact(self, inputs: ModeInputs) -> None:
        """Come alongside again after wind or wake has taken the boat off."""
        off_m, _ = self._berth.place(inputs.nav.north_m, inputs.nav.east_m)
        if off_m - self._contact_m <= _LEFT_M:
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
        return self._strays(inputs) if phase is Phase.APPROACH else None

    def _strays(self, inputs: ModeInputs) -> str | None:
        nav, parameters = inputs.nav, self._parameters
        off_m, along_m = self._berth.place(nav.north_m, nav.east_m)
        turned_deg = math.degrees(abs(wrap_pi(nav.yaw_rad - self._berth.yaw_rad)))
        if abs(along_m) > parameters["DOCK_OFF_MAX"]:
            return f"{abs(along_m):.2f} m off the line"
        if turned_deg > parameters["DOCK_YAW_MAX"]:
            return f"heading {turned_deg:.0f} deg off"
        if off_m < -_BERTH_TOLERANCE_M:
            return f"no berth {-off_m:.1f} m beyond where it should be"
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

    def _pushing_n(self, inputs: ModeInputs) -> float:
        """What the thrusters give towards the berth."""
        (x, y), given = self._berth.towards, inputs.achieved
        return given.surge_n * x + given.sway_n * y

    def _stiffness_npm(self) -> float:
        """Of the pose control, towards the berth."""
        sideways = self._berth.towards[0] == 0.0
        inertia_kg = self._config.hull.m22_kg if sideways else self._config.hull.m11_kg
        return inertia_kg * self._parameters["DP_BW_SWAY" if sideways else "DP_BW_SURGE"] ** 2

    def _failed_text(self, inputs: ModeInputs) -> str:
        names = [self._config.thrusters[i].name for i in sorted(inputs.failed)]
        return f"thruster {' and '.join(names)} failed"
