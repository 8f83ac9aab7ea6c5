"""What every mode of the vessel is: it may refuse to be entered, then gives one setpoint a tick."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.records import quick
from companion.core.types import ZERO_WRENCH, Home, Leader, ManualInput, ModeId, NavState, Setpoint, Wrench


@quick
@dataclass(frozen=True, slots=True)
class ModeInputs:
    """What a mode sees of a tick. `manual`: live sticks that may be obeyed, else None. `speed_mps`: what a self-steered mode should sail at.

    `achieved`: what the thrusters gave in the last cycle; `failed`: indices of those that have failed, `up` of those that are not lowered. `leader`: the lead boat, None while none has been heard;
    `leader_fault`: why it cannot be followed now. `station` on it: (distance_m, bearing_rad in its frame, π astern).
    """

    nav: NavState
    manual: ManualInput | None
    home: Home | None
    speed_mps: float
    now_s: float
    dt_s: float
    achieved: Wrench = ZERO_WRENCH
    failed: frozenset[int] = frozenset()
    up: frozenset[int] = frozenset()
    leader: Leader | None = None
    leader_fault: str | None = None
    station: tuple[float, float] = (20.0, math.pi)


@dataclass(frozen=True, slots=True)
class ModeInfo:
    """One mode as ground stations list it."""

    id: ModeId
    selectable: bool
    by_stick: bool
    text: str


class Mode(ABC):
    """One way of steering the boat. It is entered only while armed; while disarmed a chosen mode idles.

    `text` is shown to people. `by_stick`: silence of the sticks is a failure. `allocates`: the allocation drives the thrusters, and
    retractable ones are down. `needs_position`, `needs_heading`: what of the
    estimate must be valid for it. `early`: it may be chosen while disarmed although it cannot be entered yet; arming asks again.
    """

    id: ModeId
    text: str
    by_stick: bool = False
    allocates: bool = True
    needs_position: bool = True
    needs_heading: bool = True
    selectable: bool = True
    early: bool = False

    def check(self, inputs: ModeInputs) -> str | None:
        """Why it could not be entered now, apart from the validity of position and heading. Changes nothing."""
        return None

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start from the boat's present motion. A reason where that cannot be."""
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Go on with what it was about, after a failsafe had the thrusters in neutral."""
        return self.enter(inputs)

    def stuck_s(self, now_s: float) -> float | None:
        """For how long the boat has made no way to where the mode leads; None where it is not under way."""
        return None

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """(north_m, east_m) of the path that the mode sails along, from where the boat is on it; empty where it sails along none."""
        return ()

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """At which it sails there."""
        return inputs.speed_mps

    def excuse(self) -> None:  # noqa: B027  most modes do not mind
        """Something else keeps the boat from making way."""

    @abstractmethod
    def update(self, inputs: ModeInputs) -> Setpoint:
        """What the boat should do now."""

    @property
    def alongside(self) -> bool:
        """Whether it keeps the boat against a berth: failsafes that would hold or go home leave it there."""
        return False

    def leave(self) -> None:  # noqa: B027  most modes have nothing to put away
        """Another mode takes over, or the boat is disarmed."""
