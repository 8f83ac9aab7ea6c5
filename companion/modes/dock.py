"""Dock: onto the berth of the mission, or the vessel's own, and held there until disarmed."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.core.types import ModeId, Setpoint
from companion.modes.berth import BerthChoice
from companion.modes.docking import Docking, Phase
from companion.modes.mode import Mode, ModeInputs


class DockMode(Mode):
    """What it remembers is in its `Docking`."""

    id = ModeId.DOCK

    def __init__(self, config: VesselConfig, docking: Docking, choice: BerthChoice) -> None:
        self._docking = docking
        self._choice = choice
        if config.limits.sway_n > 0.0:
            self.text = "Comes alongside the berth and holds there until disarmed"
        else:
            self.text = "Not for this boat: it cannot push itself sideways"

    @property
    def given_up(self) -> bool:
        """Holds off the berth; chosen again, it tries again."""
        return self._docking.phase is Phase.ABORTED

    @property
    def alongside(self) -> bool:
        return self._docking.alongside

    def check(self, inputs: ModeInputs) -> str | None:
        berth = self._choice.find(inputs.nav)
        if berth is None:
            return "no berth: give the vessel a [dock] table, or the mission a NAV_LAND item"
        return self._docking.refusal(berth, inputs)

    def enter(self, inputs: ModeInputs) -> str | None:
        berth = self._choice.find(inputs.nav)
        return self.check(inputs) if berth is None else self._docking.start(berth, inputs)

    def update(self, inputs: ModeInputs) -> Setpoint:
        return self._docking.update(inputs)
