"""Propellers with rudders beside other thrusters: two screws with a rudder each, or one with a thruster across the bow.

A rudder alone steers by flow only, and a boat that has nothing else is treated as such. Beside other thrusters it
helps: what the boat can do at rest is what propellers and fixed thrusters do, and the blades add to it under way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from companion.config.devices import ThrusterConfig


def steered_by_rudder(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether a propeller with a rudder is all that the boat has."""
    return len(thrusters) == 1 and thrusters[0].kind == "rudder"


def without_blades(thrusters: Sequence[ThrusterConfig]) -> tuple[ThrusterConfig, ...]:
    """The thrusters, in their order, with each propeller that has a rudder as a fixed one. A rudder that alone steers
    the boat stays."""
    if steered_by_rudder(thrusters):
        return tuple(thrusters)
    return tuple(_fixed(thruster) if thruster.kind == "rudder" else thruster for thruster in thrusters)


def _fixed(thruster: ThrusterConfig) -> ThrusterConfig:
    return replace(
        thruster,
        kind="fixed",
        rudder=None,
        azimuth_rate_radps=0.0,
        azimuth_min_rad=None,
        azimuth_max_rad=None,
        manual_azimuth_rad=0.0,
    )
