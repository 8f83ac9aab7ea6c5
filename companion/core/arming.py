"""Values of the arming checks: what speaks against arming, or against a mode."""

from __future__ import annotations

from dataclasses import dataclass

from companion.core.decision import ModeId
from companion.core.named import Named


class ArmingCheck(Named):
    """What a finding is about."""

    POSITION = "position"
    HEADING = "heading"
    DEVICE = "device"
    THRUSTER = "thruster"
    BATTERY = "battery"
    BATTERY_LOW = "battery low"
    LEAK = "leak"
    AUTHORITY = "authority"
    KILL_SWITCH = "kill switch"
    KILL_SWITCH_FAULT = "kill switch fault"
    FENCE = "fence"
    MODE = "mode"


@dataclass(frozen=True, slots=True)
class ArmingFinding:
    """One thing that is wrong. `text`: for people. `subject`: name of the device or thruster. `value`: of a battery the
    share left, of a device the seconds since it was heard; None: never, or not known.

    `modes`: those that it concerns; None: all. `blocks` False: a warning only.
    """

    check: ArmingCheck
    text: str
    subject: str = ""
    value: float | None = None
    modes: frozenset[ModeId] | None = None
    blocks: bool = True


@dataclass(frozen=True, slots=True)
class ArmingReport:
    """All findings, and the modes in which the boat could be armed now, and to which an armed boat could change.
    `measured`: the checks for which there is something aboard to look at."""

    findings: tuple[ArmingFinding, ...]
    can_arm: frozenset[ModeId]
    can_run: frozenset[ModeId]
    measured: frozenset[ArmingCheck]
