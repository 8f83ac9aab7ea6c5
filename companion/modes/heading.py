"""Heading: holds the heading; sticks demand force and turn the held heading."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.control.manual import beyond_deadband, stick_to_wrench
from companion.core.angles import wrap_pi
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs, Need
from companion.core.setpoint import NEUTRAL_SETPOINT, HeadingSetpoint, Setpoint
from companion.modes.mode import Mode
from companion.params.store import Parameters

_LARGEST_LEAD_RAD = math.radians(45.0)


class HeadingMode(Mode):
    """Remembers the held heading. The yaw stick turns it at up to MAN_YAW_RATE, to at most 45° from the boat's own
    heading."""

    declaration = ModeDeclaration(
        id=ModeId.HEADING,
        text="Heading is held; sticks give force and turn the heading",
        px4=0x00070000,
        rover=3,  # STEERING
        by_stick=True,
        needs=frozenset({Need.HEADING}),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self._yaw_rad = 0.0

    def enter(self, inputs: ModeInputs) -> str | None:
        """Hold the present heading."""
        self._yaw_rad = inputs.nav.yaw_rad
        return None

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The held heading, turned by the yaw stick, with the force that the sticks demand."""
        stick = inputs.manual
        if stick is None:
            self._yaw_rad = inputs.nav.yaw_rad
            return NEUTRAL_SETPOINT
        rate_radps = math.radians(self._parameters["MAN_YAW_RATE"]) * beyond_deadband(
            stick.yaw, self._parameters["MAN_DEADBAND"]
        )
        lead_rad = wrap_pi(self._yaw_rad - inputs.nav.yaw_rad) + rate_radps * inputs.dt_s
        if rate_radps != 0.0 and abs(lead_rad) > _LARGEST_LEAD_RAD:
            lead_rad = math.copysign(_LARGEST_LEAD_RAD, lead_rad)
            rate_radps = 0.0
        self._yaw_rad = wrap_pi(inputs.nav.yaw_rad + lead_rad)
        wrench = stick_to_wrench(stick.surge or 0.0, stick.sway or 0.0, 0.0, self._config, self._parameters)
        return HeadingSetpoint(self._yaw_rad, wrench, rate_radps)
