"""What a boat can do astern and without way, by its thrusters alone."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig


def can_reverse(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether a thruster can push astern, by reversing or by turning round."""
    return any(thruster.pushes_astern for thruster in thrusters)


def turns_on_the_spot(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether the boat turns without way. A rudder and the nozzle of a jet steer by their own stream, which goes ahead
    only."""
    return can_reverse(thrusters) and not any(
        thruster.kind in ("rudder", "jet") for thruster in without_blades(thrusters)
    )


def turns_in_place(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether the boat turns without going on. A lone thruster that steers by its direction, as an outboard, pushes the
    boat ahead or astern as it turns it."""
    return turns_on_the_spot(thrusters) and (len(thrusters) > 1 or thrusters[0].turns_round)


def stern_first_refusal(thrusters: Sequence[ThrusterConfig]) -> str | None:
    """Why the boat cannot sail stern first, or None: it needs thrust astern, and steering without way ahead."""
    if not can_reverse(thrusters):
        return "this boat has no way astern"
    if not turns_on_the_spot(thrusters):
        return "this boat does not steer astern"
    return None
