"""Checks of the bridge `microcontroller`: a board with the project's own frames. Its row has no keys of its own."""

from __future__ import annotations

from companion.config.devices import ActuatorConfig
from companion.config.kinds import Equipment, Place, Problem
from companion.core.microcontroller_frame import MAX_THRUSTERS


def microcontroller_problems(bridge: ActuatorConfig, at: Place, equipment: Equipment) -> list[Problem]:
    """What must be true beside the types: thrusters that a frame holds, no azimuth without its throttle."""
    problems: list[Problem] = []
    if len(bridge.thrusters) > MAX_THRUSTERS:
        text = f"{len(bridge.thrusters)} thrusters; a board drives up to {MAX_THRUSTERS}: give it a second board"
        problems.append(((*at, "thrusters"), text))
    return problems + [
        ((*at, "azimuths"), f"a board that turns '{name}' drives its throttle too: add it to 'thrusters'")
        for name in bridge.azimuths
        if name not in bridge.thrusters
    ]
