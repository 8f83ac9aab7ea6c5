"""Tables within a bridge's row that stand for one thruster each: [[actuator.drive]], [[actuator.motor]]."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import ActuatorConfig
from companion.config.kinds import Place, Problem


def part_problems(
    bridge: ActuatorConfig, at: Place, table: str, parts: Sequence[tuple[str, str, int]]
) -> list[Problem]:
    """Each thruster of the bridge has one part, under a number of its own, and no part is without a thruster. Such a
    bridge has no servos and no relays.

    `at`: place of the bridge. `parts`: thruster, key of the number, number, in the order of the file.
    """
    driven = dict.fromkeys((*bridge.thrusters, *bridge.azimuths))
    served = [thruster for thruster, _, _ in parts]
    numbers = [number for _, _, number in parts]
    problems: list[Problem] = [
        ((*at, "driver"), f"needs an [[actuator.{table}]] for '{name}'") for name in driven if name not in served
    ]
    if not driven:
        problems.append(((*at, "driver"), "drives nothing: name thrusters, or azimuths"))
    for key in ("servos", "relays"):
        if getattr(bridge, key):
            problems.append(((*at, key), f"this bridge drives no {key}: name them in those of another"))
    for k, (name, key, number) in enumerate(parts):
        if name not in driven:
            text = f"'{name}' is not among the thrusters or azimuths of this bridge"
            problems.append(((*at, table, k, "thruster"), text))
        if name in served[:k]:
            problems.append(((*at, table, k, "thruster"), f"'{name}' has two"))
        if number in numbers[:k]:
            problems.append(((*at, table, k, key), f"{number} is used twice"))
    return problems
