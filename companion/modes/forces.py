"""Forces: sticks demand a wrench, which the allocation shares among the thrusters.

Source: manual thrust allocation of the ReVolt thesis.
"""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.control.manual import stick_to_wrench
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs
from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint, WrenchSetpoint
from companion.modes.mode import Mode
from companion.params.store import Parameters


class ForcesMode(Mode):
    """Sticks demand surge and sway force and yaw moment. Needs no estimate. Gives no thrust without sticks."""

    declaration = ModeDeclaration(
        id=ModeId.FORCES,
        text="Sticks demand force ahead, sideways and turning moment",
        px4=0x00020000,
        rover=31,  # of its own: Rover has no such mode
        by_stick=True,
        needs=frozenset(),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters

    @property
    def text(self) -> str:
        """What the sticks demand on this boat."""
        if self._config.limits.sway_n == 0.0:
            return "Sticks demand force ahead and turning moment"
        return self.declaration.text

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The wrench that the sticks demand; neutral without sticks."""
        stick = inputs.manual
        if stick is None:
            return NEUTRAL_SETPOINT
        wrench = stick_to_wrench(
            stick.surge or 0.0, stick.sway or 0.0, stick.yaw or 0.0, self._config, self._parameters
        )
        return WrenchSetpoint(wrench)
