"""What must be true of a sail, and of the vessel around it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from companion.config.devices import ThrusterConfig
from companion.config.kinds import Problem

if TYPE_CHECKING:
    from companion.config.vessel import VesselConfig

_MOST_RAD = math.radians(60.0)


def sail_problems(config: VesselConfig) -> list[Problem]:
    """Faults of sails and of the vessel around them, with their places."""
    problems: list[Problem] = []
    for i, thruster in enumerate(config.thrusters):
        if thruster.kind != "sail":
            if thruster.sail is not None:
                text = f"only for a thruster of kind 'sail', not '{thruster.kind}'"
                problems.append((("thruster", i, "sail"), text))
            continue
        problems += [(("thruster", i, *key), text) for key, text in _of_rig(thruster)]
        if len(config.thrusters) > 1:
            text = "a sail must be the only thruster: there is no allocation over it and others"
            problems.append((("thruster", i, "kind"), text))
        if config.limits.sway_n > 0.0:
            problems.append((("limits", "sway_n"), "a sail cannot push a boat sideways as wished: should be 0"))
    return problems


def _of_rig(thruster: ThrusterConfig) -> list[tuple[tuple[str, ...], str]]:
    problems: list[tuple[tuple[str, ...], str]] = []
    for table, held in (("sail", thruster.sail), ("rudder", thruster.rudder)):
        if held is None:
            problems.append((("kind",), f"a sail needs its table [thruster.{table}]"))
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    if low is None or high is None or not -_MOST_RAD <= low < 0.0 < high <= _MOST_RAD:
        text = "its rudder needs stops either side of amidships, azimuth_min_deg and azimuth_max_deg, within 60 degrees"
        problems.append((("azimuth_max_deg",), text))
    wing = thruster.sail is not None and thruster.sail.attack_max_rad is not None
    if wing and thruster.min_n != -thruster.max_n:
        text = f"should be {-thruster.max_n:g}, the negative of max_n: a wing turns to either side of the wind"
        problems.append((("min_n",), text))
    if not wing and thruster.min_n != 0.0:
        problems.append((("min_n",), "should be 0: a sail does not drive a boat astern"))
    if thruster.rudder is not None and thruster.rudder.x_m >= 0.0:
        problems.append((("rudder", "x_m"), "a rudder is at the stern, behind the middle of the boat: below 0"))
    if thruster.forbidden_rad or thruster.retractable:
        problems.append((("forbidden_deg" if thruster.forbidden_rad else "retractable",), "not for a sail"))
    return problems
