"""Heading: holds the heading; sticks demand force, or a speed, and turn the held heading."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.reversing import can_reverse
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.control.manual import beyond_deadband, stick_to_wrench
from companion.core.angles import wrap_pi
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs, Need, TextKind
from companion.core.events import EventLog
from companion.core.readings import ManualInput
from companion.core.setpoint import NEUTRAL_SETPOINT, HeadingSetpoint, PathSetpoint, Setpoint
from companion.guidance.motion_request import MotionRequest
from companion.guidance.sideslip import steered_hull_of
from companion.guidance.velocity_course import VelocityCourse
from companion.modes.mode import Mode
from companion.params.store import Parameters

_LARGEST_LEAD_RAD = math.radians(45.0)


class HeadingMode(Mode):
    """The yaw stick turns the held heading at up to MAN_YAW_RATE, to at most 45° from the boat's own heading.

    With MAN_SPEED above 0 the sticks demand speeds over ground while the position is valid, and forces while it is not.
    Remembers the held heading, the speed demanded last, and whether sticks demand speeds.
    """

    declaration = ModeDeclaration(
        id=ModeId.HEADING,
        text="Heading is held; sticks give force, or speed with MAN_SPEED, and turn the heading",
        px4=0x00070000,
        rover=3,  # STEERING
        by_stick=True,
        slows=True,
        needs=frozenset({Need.HEADING}),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters, events: EventLog) -> None:
        self._config = config
        self._parameters = parameters
        self._events = events
        self._course = VelocityCourse(
            parameters, top_speed_mps(config), can_reverse(config.thrusters), steered_hull_of(config)
        )
        self._can_sway = config.limits.sway_n > 0.0
        self._yaw_rad = 0.0
        self._by_speed = False

    def enter(self, inputs: ModeInputs) -> str | None:
        """Hold the present heading."""
        self._yaw_rad = inputs.nav.yaw_rad
        self._by_speed = False
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The held heading, turned by the yaw stick, with the force or the speed that the sticks demand."""
        stick = inputs.manual
        if stick is None:
            self._yaw_rad = inputs.nav.yaw_rad
            self._by_speed = False
            return NEUTRAL_SETPOINT
        dead = self._parameters["MAN_DEADBAND"]
        rate_radps = math.radians(self._parameters["MAN_YAW_RATE"]) * beyond_deadband(stick.yaw, dead)
        if self._demands_speed(inputs):
            return self._at_speed(stick, rate_radps, inputs)
        lead_rad = wrap_pi(self._yaw_rad - inputs.nav.yaw_rad) + rate_radps * inputs.dt_s
        if rate_radps != 0.0 and abs(lead_rad) > _LARGEST_LEAD_RAD:
            lead_rad = math.copysign(_LARGEST_LEAD_RAD, lead_rad)
            rate_radps = 0.0
        self._yaw_rad = wrap_pi(inputs.nav.yaw_rad + lead_rad)
        wrench = stick_to_wrench(stick.surge or 0.0, stick.sway or 0.0, 0.0, self._config, self._parameters)
        return HeadingSetpoint(self._yaw_rad, wrench, rate_radps)

    def _demands_speed(self, inputs: ModeInputs) -> bool:
        """Whether the sticks demand speeds now. A change is announced."""
        by_speed = self._parameters["MAN_SPEED"] > 0.0 and inputs.nav.position_valid
        if by_speed and not self._by_speed:
            self._course.start(replace(inputs.nav, yaw_rad=self._yaw_rad))
        elif self._by_speed and not inputs.nav.position_valid:
            text = "Heading: no position, sticks give force"
            self._events.say(inputs.now_s, TextKind.ATTENTION, "sticks_give_force", text)
        self._by_speed = by_speed
        return by_speed

    def _at_speed(self, stick: ManualInput, rate_radps: float, inputs: ModeInputs) -> Setpoint:
        """Speed ahead by PATH_ACC, turned at PATH_YAW_RATE at most; sideways at most DP_SPEED_SWAY, and only as far as
        the boat has sideways thrust."""
        dead = self._parameters["MAN_DEADBAND"]
        ahead_mps = beyond_deadband(stick.surge or 0.0, dead) * self._parameters["MAN_SPEED"]
        wanted = MotionRequest(velocity=(ahead_mps, 0.0), body=True, yaw_rate_radps=rate_radps)
        setpoint = self._course.update(wanted, inputs.nav, inputs.dt_s)
        if not isinstance(setpoint, PathSetpoint):
            return setpoint
        self._yaw_rad = setpoint.yaw_rad
        if not self._can_sway:
            return setpoint
        sideways = beyond_deadband(stick.sway or 0.0, dead) * self._parameters["DP_SPEED_SWAY"]
        return replace(setpoint, sway_mps=sideways)
