"""What must be true of a sail, and of the vessel around it."""

from __future__ import annotations

import math
from collections.abc import Iterator
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
        if i > 0:
            text = "a sail must be the first thruster; motors beside it follow"
            problems.append((("thruster", i, "kind"), text))
        problems += [(("thruster", k, *key), text) for k, key, text in _of_motors(config.thrusters, i)]
        if config.limits.sway_n > 0.0:
            problems.append((("limits", "sway_n"), "a sail cannot push a boat sideways as wished: should be 0"))
    return problems


def _of_motors(thrusters: tuple[ThrusterConfig, ...], rig: int) -> Iterator[tuple[int, tuple[str, ...], str]]:
    """Faults of the motors beside a sail."""
    for k, motor in enumerate(thrusters):
        if k == rig or motor.kind == "sail":
            continue
        if motor.kind != "fixed":
            yield k, ("kind",), "a motor beside a sail should be 'fixed': the boat steers with its rudder"
        elif motor.azimuth_rad != 0.0:
            yield k, ("azimuth_deg",), "a motor beside a sail pushes ahead: should be 0"
        elif motor.y_m != 0.0:
            yield k, ("y_m",), "a motor beside a sail is on the middle line: should be 0"


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
