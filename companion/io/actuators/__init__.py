"""Drivers of actuator bridges: commands → bytes. One file a bridge, all in one table.

A new bridge is

- its file here, with a class as `companion.core.ports.Actuator` describes it, and its row in DRIVERS,
- its row in `companion.config.actuators.BRIDGES`, and a file there if it has keys of its own.

A bridge of another package is an `ActuatorDriver` behind an entry point of the group `usv_companion.actuators`; see
`companion.io.plugins`. Its row in a vessel's file may have keys of its own: those of the dataclass that its kind names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from companion.config.bridge_checks import problems_of_kind
from companion.config.devices import ActuatorConfig
from companion.config.kinds import BridgeKind, Equipment, Problem, completed
from companion.config.mistakes import remedy
from companion.config.toml_places import dotted
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.ports import Actuator, ByteStream
from companion.io import plugins
from companion.io.actuators.mavlink_servo import MavlinkServoBridge
from companion.io.actuators.microcontroller import MicrocontrollerBridge
from companion.io.actuators.nanotec import NanotecBridge
from companion.io.actuators.nmea2000 import Nmea2000Bridge

DRIVERS: Mapping[str, Callable[[Any, VesselConfig, ByteStream], Actuator]] = {
    "mavlink_servo": MavlinkServoBridge,
    "microcontroller": MicrocontrollerBridge,
    "nanotec": NanotecBridge,
    "nmea2000": Nmea2000Bridge,
}
GROUP = "usv_companion.actuators"


@dataclass(frozen=True, slots=True)
class ActuatorDriver:
    """What another package registers: the dataclass and the checks of its row, and the driver itself.

    `open(row, vessel, stream)` → the driver on its port; `row` is of the class that `kind` names.
    """

    kind: BridgeKind
    open: Callable[[Any, VesselConfig, ByteStream], Actuator]


def refusal(driver: str) -> str | None:
    """Why a file cannot name that driver; None for one that is there."""
    return plugins.refusal(driver, DRIVERS, GROUP)


def plugin_problems(vessel: VesselConfig) -> list[Problem]:
    """Faults of the rows whose driver another package has, with their places."""
    problems: list[Problem] = []
    for bridge in vessel.actuators:
        if bridge.driver not in DRIVERS and refusal(bridge.driver) is None:
            problems += _judged(bridge, vessel)[1]
    return problems


def open_actuator(config: ActuatorConfig, vessel: VesselConfig, stream: ByteStream) -> Actuator:
    """The driver that `config` names, on `stream`. Raises ConfigError for a driver that is not there or cannot be
    used."""
    if (factory := DRIVERS.get(config.driver)) is not None:
        return factory(config, vessel, stream)
    if (text := refusal(config.driver)) is not None:
        raise ConfigError([f"actuator '{config.name}': {text}"])
    plugin = plugins.loaded(config.driver, GROUP, ActuatorDriver)
    row, problems = _judged(config, vessel)
    if problems:
        raise ConfigError([f"{dotted(place)}: {text}" for place, text in problems])
    return plugins.guarded(config.driver, lambda: plugin.open(row, vessel, stream), GROUP)


def _judged(bridge: ActuatorConfig, vessel: VesselConfig) -> tuple[ActuatorConfig, list[Problem]]:
    """The row as its plug-in declares it, and what is wrong with it."""
    i = next(i for i, row in enumerate(vessel.actuators) if row.name == bridge.name)
    try:
        kind = plugins.loaded(bridge.driver, GROUP, ActuatorDriver).kind
        row = completed(bridge, kind.row)
        equipment = Equipment(vessel.thrusters, vessel.actuators, vessel.servos)
        return row, plugins.guarded(bridge.driver, lambda: problems_of_kind(row, i, kind, equipment), GROUP)
    except ValidationError as error:
        return bridge, [(("actuator", i, *found["loc"]), remedy(found["msg"])) for found in error.errors()]
    except ConfigError as error:
        return bridge, [(("actuator", i, "driver"), text) for text in error.problems]
