"""How the boat stands to its fence, as the status tells it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FenceState:
    """Of the fence in force. `breaches` counts since it came in force, `breach_s` is the begin of the last one."""

    breached: bool
    breaches: int
    breach_s: float | None
    slowed: bool  # the speed is limited so that the boat stops inside
