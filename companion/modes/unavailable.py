"""Modes that have their place in the table and cannot be entered in this version."""

from __future__ import annotations

from companion.core.types import NEUTRAL_SETPOINT, ModeId, Setpoint
from companion.modes.mode import Mode, ModeInputs


class UnavailableMode(Mode):
    """Shown to ground stations, refused with a reason."""

    def __init__(self, mode: ModeId) -> None:
        self.id = mode
        self.text = "Not available in this version"

    def check(self, inputs: ModeInputs) -> str | None:
        return "not available in this version"

    def enter(self, inputs: ModeInputs) -> str | None:
        return self.check(inputs)

    def update(self, inputs: ModeInputs) -> Setpoint:
        return NEUTRAL_SETPOINT
