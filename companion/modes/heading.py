"""Heading: the heading is held; sticks give force and turn the heading that is held."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.control.manual import stick_to_wrench
from companion.core.angles import wrap_pi
from companion.core.types import NEUTRAL_SETPOINT, ModeId, Setpoint, SetpointKind
from companion.modes.mode import Mode, ModeInputs
from companion.modes.sticks import beyond_deadband
from companion.params import Parameters

_LARGEST_LEAD_RAD = math.radians(45.0)


class HeadingMode(Mode):
    """Remembers the heading held. The yaw stick turns it at up to MAN_YAW_RATE, never further than 45° ahead of the boat itself."""

    id = ModeId.HEADING
    text = "Heading is held; sticks give force and turn the heading"
    by_stick = True
    needs_position = False

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self._yaw_rad = 0.0

    def enter(self, inputs: ModeInputs) -> str | None:
        self._yaw_rad = inputs.nav.yaw_rad
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        stick = inputs.manual
        if stick is None:
            self._yaw_rad = inputs.nav.yaw_rad
            return NEUTRAL_SETPOINT
        rate_radps = math.radians(self._parameters["MAN_YAW_RATE"]) * beyond_deadband(stick.yaw, self._parameters["MAN_DEADBAND"])
        lead_rad = wrap_pi(self._yaw_rad - inputs.nav.yaw_rad) + rate_radps * inputs.dt_s
        if rate_radps != 0.0 and abs(lead_rad) > _LARGEST_LEAD_RAD:
            lead_rad = math.copysign(_LARGEST_LEAD_RAD, lead_rad)
            rate_radps = 0.0
        self._yaw_rad = wrap_pi(inputs.nav.yaw_rad + lead_rad)
        wrench = stick_to_wrench(stick.surge or 0.0, stick.sway or 0.0, 0.0, self._config, self._parameters)
        return Setpoint(SetpointKind.HEADING, yaw_rad=self._yaw_rad, yaw_rate_radps=rate_radps, wrench=wrench)
