"""Which bridge drives what: each throttle, azimuth, servo and relay by exactly one."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ActuatorConfig, ThrusterConfig

Problem = tuple[tuple[str | int, ...], str]
_PART = {"thrusters": "the throttle of ", "azimuths": "the azimuth of "}


def azimuths_of(bridge: ActuatorConfig, thrusters: Sequence[ThrusterConfig], bridges: Sequence[ActuatorConfig]) -> tuple[int, ...]:
    """Indices of the thrusters whose azimuth `bridge` drives: those it names in `azimuths`, then those of its throttles that turn and whose
    azimuth no bridge of `bridges` names."""
    names = [thruster.name for thruster in thrusters]
    taken = {name for other in bridges for name in other.azimuths}
    own = [name for name in bridge.thrusters if name in names and thrusters[names.index(name)].turns and name not in taken]
    return tuple(names.index(name) for name in (*bridge.azimuths, *own) if name in names)


def driving_problems(
    bridges: Sequence[ActuatorConfig], thrusters: Sequence[ThrusterConfig], servos: Sequence[str], relays: Sequence[str]
) -> list[Problem]:
    """Places and texts of what is driven by no bridge or by two, and of what a bridge drives that is not there."""
    names = [thruster.name for thruster in thrusters]
    problems: list[Problem] = []
    for table, known in (("thruster", names), ("servo", servos), ("relay", relays)):
        problems += _once(bridges, f"{table}s", table, known)
        driven = {name for bridge in bridges for name in getattr(bridge, f"{table}s")}
        problems += [((table,), f"{_PART.get(table + 's', '')}'{name}' is driven by no bridge") for name in sorted(set(known) - driven)]
    problems += _once(bridges, "azimuths", "thruster", names)
    turning = {thruster.name for thruster in thrusters if thruster.turns}
    for i, bridge in enumerate(bridges):
        problems += [(("actuator", i, "azimuths"), f"'{name}' does not turn") for name in bridge.azimuths if name in names and name not in turning]
        drives = [(drive.thruster, "address", drive.address) for drive in bridge.drives]
        motors = [(motor.thruster, "instance", motor.instance) for motor in bridge.motors]
        problems += _part_problems(i, bridge, "drive", drives) + _part_problems(i, bridge, "motor", motors)
    return problems


def _once(bridges: Sequence[ActuatorConfig], field: str, table: str, known: Sequence[str]) -> list[Problem]:
    problems: list[Problem] = []
    driven: set[str] = set()
    for i, bridge in enumerate(bridges):
        for name in getattr(bridge, field):
            if name not in known:
                problems.append((("actuator", i, field), f"no {table} named '{name}'"))
            if name in driven:
                problems.append((("actuator", i, field), f"{_PART.get(field, '')}'{name}' is driven by two bridges"))
            driven.add(name)
    return problems


def _part_problems(i: int, bridge: ActuatorConfig, table: str, parts: Sequence[tuple[str, str, int]]) -> list[Problem]:
    """A drive or motor serves one thruster of its bridge, under a number of its own; `parts`: thruster, key of the number, number."""
    problems: list[Problem] = []
    driven = {*bridge.thrusters, *bridge.azimuths}
    for k, (name, key, number) in enumerate(parts):
        if name not in driven:
            problems.append((("actuator", i, table, k, "thruster"), f"'{name}' is not among the thrusters or azimuths of this bridge"))
        if name in (other for other, _, _ in parts[:k]):
            problems.append((("actuator", i, table, k, "thruster"), f"'{name}' has two"))
        if number in (other for _, _, other in parts[:k]):
            problems.append((("actuator", i, table, k, key), f"{number} is used twice"))
    return problems
