"""Dock: comes alongside the mission's berth, or the vessel's own, and holds there until disarmed."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.core.decision import SELF_STEERED_NEEDS, KnownRefusal, ModeDeclaration, ModeId, ModeInputs, Need
from companion.core.setpoint import Setpoint
from companion.modes.mode import Mode
from companion.modes.parts.berth import BerthChoice
from companion.modes.parts.docking import Docking, DockingPhase


class DockMode(Mode):
    """Comes alongside and pushes against the berth. Its `Docking` keeps all state."""

    declaration = ModeDeclaration(
        id=ModeId.DOCK,
        text="Comes alongside the berth and holds there until disarmed",
        px4=0x06040000,
        rover=8,
        again="docking that was given up is tried again",
        needs=SELF_STEERED_NEEDS | {Need.SIDEWAYS_THRUST},
        refusals=(
            KnownRefusal(r"no berth.*", "no berth", "Add [dock] to the vessel file, or NAV_LAND to the mission."),
            KnownRefusal(
                r"this boat cannot push itself sideways",
                "this boat cannot push itself sideways",
                "Choose another mode.",
            ),
            KnownRefusal(r"thruster .* failed", "a thruster has failed", "Repair it. The other modes work without it."),
            KnownRefusal(r"boat is behind the berth.*", "the boat is behind the berth", "Sail round to its front."),
            KnownRefusal(
                r"way to the berth crosses the fence", "the way to the berth crosses the fence", "Change the fence."
            ),
        ),
    )

    def __init__(self, config: VesselConfig, docking: Docking, choice: BerthChoice) -> None:
        self._docking = docking
        self._choice = choice
        self._can_sway = config.limits.sway_n > 0.0

    @property
    def text(self) -> str:
        """What Dock does on this boat, or why this boat cannot dock."""
        return self.declaration.text if self._can_sway else "Not for this boat: it cannot push itself sideways"

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """Start docking again if it was given up."""
        return self._docking.phase is DockingPhase.ABORTED

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Stop docking if the way to the berth now crosses the fence; a boat alongside stays there."""
        return self._docking.fence_refusal(inputs)

    @property
    def voyage_over(self) -> bool:
        """Whether the boat has docked."""
        return self._docking.docked

    @property
    def docking(self) -> bool:
        """Always: the berth is no obstacle."""
        return True

    @property
    def alongside(self) -> bool:
        """Whether the boat pushes against the berth."""
        return self._docking.alongside

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway to the berth; None if unknown."""
        return self._docking.stuck_s(now_s)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._docking.excuse()

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without a berth, or if the boat cannot dock at it now."""
        berth = self._choice.find(inputs.nav)
        if berth is None:
            return "no berth: add a [dock] table or NAV_LAND item"
        return self._docking.refusal(berth, inputs)

    def enter(self, inputs: ModeInputs) -> str | None:
        """Choose the berth and start docking."""
        berth = self._choice.find(inputs.nav)
        return self.check(inputs) if berth is None else self._docking.start(berth, inputs)

    def resume(self, inputs: ModeInputs) -> str | None:
        """Go on at the berth chosen on entry."""
        return self._docking.resume(inputs)

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The setpoint of the present docking phase."""
        return self._docking.update(inputs)
