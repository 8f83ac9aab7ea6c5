"""Forces: stick to wrench, the allocation does the rest (the ReVolt thesis's manual thrust allocation)."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.control.manual import stick_to_wrench
from companion.core.types import NEUTRAL_SETPOINT, ModeId, Setpoint, SetpointKind
from companion.modes.mode import Mode, ModeInputs
from companion.params import Parameters


class ForcesMode(Mode):
    """Sticks demand surge and sway force and yaw moment. Needs no estimate. Without sticks: no thrust."""

    id = ModeId.FORCES
    text = "Sticks demand force ahead, sideways and turning moment"
    by_stick = True
    needs_position = False
    needs_heading = False

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        if config.limits.sway_n == 0.0:
            self.text = "Sticks demand force ahead and turning moment"

    def update(self, inputs: ModeInputs) -> Setpoint:
        stick = inputs.manual
        if stick is None:
            return NEUTRAL_SETPOINT
        wrench = stick_to_wrench(stick.surge or 0.0, stick.sway or 0.0, stick.yaw or 0.0, self._config, self._parameters)
        return Setpoint(SetpointKind.WRENCH, wrench=wrench)
