"""The base of every mode. A mode may refuse to be entered; once entered, it returns one setpoint a tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from companion.core.decision import ModeDeclaration, ModeId, ModeInputs, Need, OrbitState
from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint
from companion.obstacles.way_round import WayRound

FURTHEST_LEG_M = 50_000.0  # a destination further away is another boat's plan or a typing error


@dataclass(frozen=True, slots=True)
class ModeInfo:
    """One mode as ground stations list it. `text` says what it does on this boat."""

    declaration: ModeDeclaration
    text: str

    @property
    def id(self) -> ModeId:
        """The declared id."""
        return self.declaration.id


class Mode(ABC):
    """One way of steering the boat. It is entered only while armed; while disarmed a chosen mode idles.

    `declaration` holds the facts about the mode that other parts need. `text` may add facts about this boat.
    """

    declaration: ClassVar[ModeDeclaration]

    @property
    def id(self) -> ModeId:
        """The declared id."""
        return self.declaration.id

    @property
    def text(self) -> str:
        """What the mode does on this boat, as shown to the operator."""
        return self.declaration.text

    @property
    def by_stick(self) -> bool:
        """Whether the operator's sticks steer the boat in this mode."""
        return self.declaration.by_stick

    @property
    def unplanned(self) -> bool:
        """Whether what steers the boat now knows of no fence, so that it may lead the boat out."""
        return self.by_stick

    @property
    def slows(self) -> bool:
        """Whether a boat steered without a plan is slowed down ahead of the fence while the heading is known."""
        return self.declaration.slows

    @property
    def needs_position(self) -> bool:
        """Whether the mode needs a valid position."""
        return Need.POSITION in self.declaration.needs

    @property
    def needs_heading(self) -> bool:
        """Whether the mode needs a valid heading."""
        return Need.HEADING in self.declaration.needs

    def check(self, inputs: ModeInputs) -> str | None:
        """Return why the mode cannot be entered now, or None. Callers check position and heading. Changes nothing."""
        return None

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start from the boat's present motion. Return a reason if the mode cannot start, else None."""
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Continue after a failsafe kept the thrusters in neutral. Return a reason if the mode cannot, else None."""
        return self.enter(inputs)

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """React when the operator chooses the active mode again while armed. Return whether to call `enter` again."""
        return False

    def loss(self, now_s: float) -> str | None:
        """Return the cause of the failsafe that the mode declares: the input that it lost. None: nothing is lost."""
        return None

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """React to a new fence while active. Return why the mode cannot continue (the boat then holds), or None."""
        return None

    @property
    def blocked(self) -> str | None:
        """Why the active mode cannot continue, found under way; the boat then holds. None: not blocked."""
        return None

    def stuck_s(self, now_s: float) -> float | None:
        """Return for how many seconds the boat has made no headway; None while it is not under way."""
        return None

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """Return the rest of the present path as (north_m, east_m) points; empty without a path."""
        return ()

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """Return the speed along the path of `way_ahead`, m/s."""
        return inputs.speed_mps

    def excuse(self) -> None:  # noqa: B027  most modes do not watch their headway
        """Restart the headway watch: something else stops the boat, so it is not stuck."""

    @property
    def docking(self) -> bool:
        """Whether the boat goes alongside: the berth is no obstacle."""
        return False

    @property
    def goes_round(self) -> bool:
        """Whether the mode now has a way that it can lead round obstacles."""
        return False

    @property
    def drifts(self) -> bool:
        """Whether the boat now moves about a point that it cannot keep: wind and current may set it onto something."""
        return False

    @property
    def held_point(self) -> tuple[float, float] | None:
        """The point about which such a boat moves; None where it keeps none."""
        return None

    def hold_instead(self, north_m: float, east_m: float) -> None:  # noqa: B027  most modes hold no point
        """Hold another point than `held_point`: obstacles lie too near to that."""

    def way_round(self, inputs: ModeInputs) -> WayRound[Any] | None:
        """How to lead the rest of the way round the obstacles; None where the mode has no way of its own."""
        return None

    def drop_speed(self) -> None:  # noqa: B027  most modes sail at the set speed
        """Forget the speed of the last order, because the operator has set another one."""

    @property
    def orbit(self) -> OrbitState | None:
        """The circle that the mode sails, for ground stations to draw; None without one."""
        return None

    @abstractmethod
    def update(self, inputs: ModeInputs) -> Setpoint:
        """Return the setpoint of this tick."""

    def stand_by(self, inputs: ModeInputs) -> Setpoint:
        """The setpoint while the mode is chosen but waits for what it needs to be entered."""
        return NEUTRAL_SETPOINT

    @property
    def voyage_over(self) -> bool:
        """Whether the boat has come to the end of its voyage: at home, at a berth, or where it was told to land."""
        return False

    @property
    def alongside(self) -> bool:
        """Whether the mode keeps the boat against a berth. Failsafes that hold or return home then leave it there."""
        return False

    def leave(self) -> None:  # noqa: B027  most modes have nothing to stop
        """Stop, because another mode takes over or the boat is disarmed."""
