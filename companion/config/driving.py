"""Which bridge drives what: each throttle, azimuth, servo and relay by exactly one."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ActuatorConfig, ThrusterConfig
from companion.config.kinds import Problem

_PART = {"thrusters": "the throttle of ", "azimuths": "the azimuth of "}


def azimuths_of(
    bridge: ActuatorConfig, thrusters: Sequence[ThrusterConfig], bridges: Sequence[ActuatorConfig]
) -> tuple[int, ...]:
    """Indices of the thrusters whose azimuth `bridge` drives: those that its `azimuths` name, then those of its
    throttles that turn and that no bridge of `bridges` names in `azimuths`."""
    names = [thruster.name for thruster in thrusters]
    taken = {name for other in bridges for name in other.azimuths}
    own = [
        name for name in bridge.thrusters if name in names and thrusters[names.index(name)].turns and name not in taken
    ]
    return tuple(names.index(name) for name in (*bridge.azimuths, *own) if name in names)


def driving_problems(
    bridges: Sequence[ActuatorConfig], thrusters: Sequence[ThrusterConfig], servos: Sequence[str], relays: Sequence[str]
) -> list[Problem]:
    """Throttles, azimuths, servos and relays that no bridge or two bridges drive, and names that do not exist, with
    their places."""
    names = [thruster.name for thruster in thrusters]
    problems: list[Problem] = []
    for table, known in (("thruster", names), ("servo", servos), ("relay", relays)):
        problems += _once(bridges, f"{table}s", table, known)
        driven = {name for bridge in bridges for name in getattr(bridge, f"{table}s")}
        problems += [
            (
                (table,),
                f"{_PART.get(table + 's', '')}'{name}' is driven by no bridge: add it to the list of an [[actuator]]",
            )
            for name in sorted(set(known) - driven)
        ]
    problems += _once(bridges, "azimuths", "thruster", names)
    turning = {thruster.name for thruster in thrusters if thruster.turns}
    for i, bridge in enumerate(bridges):
        problems += [
            (("actuator", i, "azimuths"), f"'{name}' does not turn")
            for name in bridge.azimuths
            if name in names and name not in turning
        ]
    return problems


def _once(bridges: Sequence[ActuatorConfig], field: str, table: str, known: Sequence[str]) -> list[Problem]:
    problems: list[Problem] = []
    driven: set[str] = set()
    for i, bridge in enumerate(bridges):
        for name in getattr(bridge, field):
            if name not in known:
                text = f"no {table} named '{name}'; there is {', '.join(known) or 'none'}"
                problems.append((("actuator", i, field), text))
            if name in driven:
                problems.append((("actuator", i, field), f"{_PART.get(field, '')}'{name}' is driven by two bridges"))
            driven.add(name)
    return problems
