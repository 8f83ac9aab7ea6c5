"""Manual: sticks drive the thrusters directly, without the allocation."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.control.manual import stick_to_thrusters
from companion.core.decision import ModeDeclaration, ModeId, ModeInputs
from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint, ThrusterSetpoint
from companion.modes.mode import Mode
from companion.params.store import Parameters


class ManualMode(Mode):
    """Each thruster follows the sticks by the vessel's manual mapping. Needs no estimate. Gives no thrust
    without sticks."""

    declaration = ModeDeclaration(
        id=ModeId.MANUAL,
        text="Sticks drive the thrusters directly",
        px4=0x00010000,
        rover=0,
        by_stick=True,
        allocates=False,
        needs=frozenset(),
    )

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The thruster commands that the sticks map to; neutral without sticks."""
        stick = inputs.manual
        if stick is None:
            return NEUTRAL_SETPOINT
        thrusters = stick_to_thrusters(
            stick.surge or 0.0, stick.sway or 0.0, stick.yaw or 0.0, self._config, self._parameters
        )
        return ThrusterSetpoint(thrusters)
