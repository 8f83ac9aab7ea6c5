"""What must be true of a propeller with a rudder, and of the vessel around it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import ThrusterConfig
from companion.config.kinds import Problem
from companion.config.rudder import RudderConfig

_BESIDE = ("rudder", "fixed")
_ACROSS = 0.1  # share of a thruster's push across the hull that counts
_MOST_RAD = math.radians(60.0)
_MOST_SHARE = 1.0  # of the thrust, as side force at rest: the race has no more to give
_MOST_ASPECT = 8.0


def rudder_problems(thrusters: Sequence[ThrusterConfig], sway_n: float) -> list[Problem]:
    """Faults of rudders and of the vessel around them, with their places. `sway_n`: the side force that the controller
    may ask for."""
    problems: list[Problem] = []
    for i, thruster in enumerate(thrusters):
        if thruster.kind != "rudder":
            if thruster.rudder is not None and thruster.kind != "sail":
                text = f"only for a thruster of kind 'rudder' or 'sail', not '{thruster.kind}'"
                problems.append((("thruster", i, "rudder"), text))
            continue
        problems += [(("thruster", i, *key), text) for key, text in _of_rudder(thruster)]
        if (other := next((t for t in thrusters if t.kind not in _BESIDE), None)) is not None:
            text = (
                f"beside a propeller with a rudder there can be others and fixed thrusters: '{other.name}' is neither"
            )
            problems.append((("thruster", i, "kind"), text))
        if thruster.y_m != 0.0 and len(thrusters) == 1:
            text = "a single propeller with a rudder lies in the middle of the boat: should be 0"
            problems.append((("thruster", i, "y_m"), text))
        if sway_n > 0.0 and not _pushes_sideways(thrusters):
            text = "rudders cannot push a boat at rest sideways: should be 0"
            problems.append((("limits", "sway_n"), text))
    return problems


def _pushes_sideways(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether something but rudders pushes sideways."""
    return any(t.kind == "fixed" and abs(math.sin(t.azimuth_rad)) > _ACROSS for t in thrusters)


def _of_rudder(thruster: ThrusterConfig) -> list[tuple[tuple[str, ...], str]]:
    rudder = thruster.rudder
    if rudder is None:
        return [
            (("kind",), "a rudder needs its table [thruster.rudder] with span_m and chord_m, or [hull] with a form")
        ]
    return [*_stop_problems(thruster), *_place_problems(thruster, rudder), *_blade_problems(thruster, rudder)]


def _stop_problems(thruster: ThrusterConfig) -> list[tuple[tuple[str, ...], str]]:
    low, high = thruster.azimuth_min_rad, thruster.azimuth_max_rad
    problems: list[tuple[tuple[str, ...], str]] = []
    if low is None or high is None or not -_MOST_RAD <= low < 0.0 < high <= _MOST_RAD:
        text = "a rudder needs stops either side of amidships, azimuth_min_deg and azimuth_max_deg, within 60 degrees"
        problems.append((("azimuth_max_deg",), text))
    if thruster.forbidden_rad or thruster.retractable:
        problems.append((("forbidden_deg" if thruster.forbidden_rad else "retractable",), "not for a rudder"))
    return problems


def _place_problems(thruster: ThrusterConfig, rudder: RudderConfig) -> list[tuple[tuple[str, ...], str]]:
    problems: list[tuple[tuple[str, ...], str]] = []
    if thruster.azimuth_rad != 0.0:
        problems.append((("azimuth_deg",), "a propeller with a rudder pushes ahead: should be 0"))
    if rudder.x_m >= 0.0:
        problems.append((("rudder", "x_m"), "a rudder is at the stern, behind the middle of the boat: below 0"))
    elif rudder.x_m > thruster.x_m and rudder.race_share > 0.0:
        text = "stands ahead of its propeller, whose race goes astern: race_share should be 0"
        problems.append((("rudder", "x_m"), text))
    return problems


def _blade_problems(thruster: ThrusterConfig, rudder: RudderConfig) -> list[tuple[tuple[str, ...], str]]:
    if thruster.propeller_m is None:
        return [(("propeller_m",), "is missing: the diameter of the propeller, whose race the rudder stands in")]
    problems: list[tuple[tuple[str, ...], str]] = []
    if rudder.aspect > _MOST_ASPECT:
        text = f"a blade {rudder.aspect:.0f} times as high as wide: check span_m and chord_m, in m"
        problems.append((("rudder", "span_m"), text))
    share = rudder.side_share(min(_MOST_RAD, thruster.azimuth_max_rad or 0.0), thruster.propeller_m)
    if share > _MOST_SHARE:
        text = f"this blade would push sideways with {share:.1f} times the thrust: check its size and propeller_m, in m"
        problems.append((("rudder", "chord_m"), text))
    return problems
