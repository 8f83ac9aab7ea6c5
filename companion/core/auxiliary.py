"""Demands on outputs beside the thrusters."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Auxiliary:
    """Outputs beside the thrusters, in the order of the vessel's file: pulses of servos (None: no pulses), relays switched on."""

    servos_us: tuple[float | None, ...] = ()
    relays: tuple[bool, ...] = ()


NO_AUXILIARY = Auxiliary()
