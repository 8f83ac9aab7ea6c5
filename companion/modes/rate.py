"""Rate: sticks demand a speed and a turn rate, which the boat keeps; no heading is held."""

from __future__ import annotations

import math

from companion.config.reversing import can_reverse
from companion.config.vessel import VesselConfig
from companion.control.manual import beyond_deadband, stick_to_wrench
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.readings import ManualInput
from companion.core.setpoint import NEUTRAL_SETPOINT, HeadingSetpoint, PathSetpoint, Setpoint, WrenchSetpoint
from companion.modes.mode import Mode
from companion.params.store import Parameters

_LARGEST_LEAD_RAD = math.radians(30.0)
_FORGET_S = 3.0  # time constant: a turn that was not made is not made up for later
_GYRO_AGE_S = 0.5  # an older inertial measurement tells no turn rate
_TURN_SENSES = ("gyro", "IMU")
_STANDING_MPS = 0.05  # a boat without way astern gives no thrust below it


class RateMode(Mode):
    """The yaw stick demands up to MAN_YAW_RATE, the surge stick a speed over ground up to MAN_SPEED, or WP_SPEED where
    that is 0; astern DP_SPEED_ASTERN, sideways DP_SPEED_SWAY at most.

    Without a position the surge and sway sticks give force. Without a turn rate, which the gyro tells where the heading
    is lost, all of them give force and moment, as in Forces. Both are announced. The loop of the turn is that of the
    heading: its setpoint leads the bow by the integral of the rate's error, which fades.

    Remembers that lead, the speed demanded last, and what was said that the sticks give.
    """

    declaration = ModeDeclaration(
        id=ModeId.RATE,
        text="Sticks demand speed and turn rate; no heading is held",
        px4=0x00050000,  # ACRO
        rover=1,  # ACRO
        by_stick=True,
        slows=True,
        needs=frozenset(),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._config = config
        self._parameters = parameters
        self._events = events
        self._can_reverse = can_reverse(config.thrusters)
        self._can_sway = config.limits.sway_n > 0.0
        self._lead_rad = self._surge_mps = 0.0
        self._given = ""  # what was said last that sticks give in place of speed and turn rate

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start from the boat's present motion."""
        self._restart(inputs.nav)
        self._given = ""
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The speed and turn rate that the sticks demand, as far as the estimate tells those; neutral without
        sticks."""
        stick, nav = inputs.manual, inputs.nav
        self._announce(nav, inputs.now_s)
        if stick is None:
            self._restart(nav)
            return NEUTRAL_SETPOINT
        if not _turn_is_known(nav):
            self._restart(nav)
            return WrenchSetpoint(self._wrench(stick, stick.yaw or 0.0))
        dead = self._parameters["MAN_DEADBAND"]
        rate_radps = math.radians(self._parameters["MAN_YAW_RATE"]) * beyond_deadband(stick.yaw, dead)
        yaw_rad = self._leading(rate_radps, inputs)
        if not _speed_is_known(nav):
            self._surge_mps = 0.0
            return HeadingSetpoint(yaw_rad, self._wrench(stick, 0.0), rate_radps)
        return self._at_speed(stick, yaw_rad, rate_radps, inputs.dt_s)

    def _restart(self, nav: NavState) -> None:
        self._lead_rad = 0.0
        self._surge_mps = nav.surge_mps if _speed_is_known(nav) else 0.0

    def _announce(self, nav: NavState, now_s: float) -> None:
        """Say what the sticks give where speed and turn rate are not known, and that they are again."""
        turns = _turn_is_known(nav)
        given = "force and moment" if not turns else "force" if not _speed_is_known(nav) else ""
        if given == self._given:
            return
        self._given = given
        if given:
            lost = "position" if turns else "turn rate"
            text = f"Rate: no {lost}, sticks give {given}"
            self._events.say(now_s, TextKind.ATTENTION, "sticks_give_force", text)
        else:
            text = "Rate: sticks give speed and turn rate again"
            self._events.say(now_s, TextKind.ROUTINE, "sticks_give_rate", text)

    def _wrench(self, stick: ManualInput, yaw: float) -> Wrench:
        return stick_to_wrench(stick.surge or 0.0, stick.sway or 0.0, yaw, self._config, self._parameters)

    def _leading(self, rate_radps: float, inputs: ModeInputs) -> float:
        """The heading to ask for: the boat's own, ahead by what is missing of the turn."""
        missing = rate_radps - inputs.nav.yaw_rate_radps - self._lead_rad / _FORGET_S
        lead = self._lead_rad + missing * inputs.dt_s
        self._lead_rad = min(_LARGEST_LEAD_RAD, max(-_LARGEST_LEAD_RAD, lead))
        return wrap_pi(inputs.nav.yaw_rad + self._lead_rad)

    def _at_speed(self, stick: ManualInput, yaw_rad: float, rate_radps: float, dt_s: float) -> Setpoint:
        """The speed of the sticks, which changes by PATH_ACC. A boat without way astern that is to stand drifts, and
        turns if it can."""
        parameters = self._parameters
        dead = parameters["MAN_DEADBAND"]
        most = min(parameters["MPC_XY_VEL_MAX"], parameters["MAN_SPEED"] or parameters["WP_SPEED"])
        astern = min(most, parameters["DP_SPEED_ASTERN"]) if self._can_reverse else 0.0
        wanted = max(-astern, beyond_deadband(stick.surge, dead) * most)
        if not self._can_reverse and wanted < _STANDING_MPS:
            self._surge_mps = 0.0
            turns = rate_radps != 0.0
            return HeadingSetpoint(yaw_rad, ZERO_WRENCH, rate_radps) if turns else WrenchSetpoint(ZERO_WRENCH)
        step, before = parameters["PATH_ACC"] * dt_s, self._surge_mps
        self._surge_mps = min(before + step, max(before - step, wanted))
        sway = beyond_deadband(stick.sway, dead) * parameters["DP_SPEED_SWAY"] if self._can_sway else 0.0
        gain = (self._surge_mps - before) / dt_s if dt_s > 0.0 else 0.0
        return PathSetpoint(yaw_rad, self._surge_mps, sway, rate_radps, gain, by_rate=True)


def _speed_is_known(nav: NavState) -> bool:
    """Whether the speed ahead can be kept: it is the velocity over ground in the direction of the heading."""
    return nav.position_valid and nav.heading_valid


def _turn_is_known(nav: NavState) -> bool:
    """Whether the turn rate can be kept: by the estimate with a heading, else by a gyro that does not lie."""
    if nav.heading_valid:
        return True
    if nav.imu_age_s > _GYRO_AGE_S or not math.isfinite(nav.yaw_rad + nav.yaw_rate_radps):
        return False
    return not any(lie.excluded and lie.sense in _TURN_SENSES for lie in nav.distrusted)
