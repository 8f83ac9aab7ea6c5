"""Manual: stick to thrusters, past the allocation."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.control.manual import stick_to_thrusters
from companion.core.types import NEUTRAL_SETPOINT, ModeId, Setpoint, SetpointKind
from companion.modes.mode import Mode, ModeInputs
from companion.params import Parameters


class ManualMode(Mode):
    """Each thruster follows the sticks by the vessel's manual mapping. Needs no estimate at all. Without sticks: no thrust."""

    id = ModeId.MANUAL
    text = "Sticks drive the thrusters directly"
    by_stick = True
    allocates = False
    needs_position = False
    needs_heading = False

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters

    def update(self, inputs: ModeInputs) -> Setpoint:
        stick = inputs.manual
        if stick is None:
            return NEUTRAL_SETPOINT
        thrusters = stick_to_thrusters(stick.surge or 0.0, stick.sway or 0.0, stick.yaw or 0.0, self._config, self._parameters)
        return Setpoint(SetpointKind.THRUSTERS, thrusters=thrusters)
