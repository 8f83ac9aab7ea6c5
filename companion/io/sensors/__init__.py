"""Drivers of sensors: bytes → readings. One file a protocol, all in one table.

A new sensor is

- its file here, with a class as `companion.core.ports.Sensor` describes it (`StreamDriver` has what most of them
  share), and its row in DRIVERS,
- its row in `companion.config.sensors.SENSORS`, and a file there if it has keys of its own.

A sensor of another package is a `SensorDriver` behind an entry point of the group `usv_companion.sensors`; see
`companion.io.plugins`. Its row in a file may have keys of its own: those of the dataclass that its kind names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from companion.config.devices import SensorConfig
from companion.config.kinds import Place, Problem, SensorKind, completed
from companion.config.mistakes import remedy
from companion.config.toml_places import dotted
from companion.config.vessel import ConfigError
from companion.core.ports import ByteStream, Sensor
from companion.io import plugins
from companion.io.sensors.ais import AisReceiver
from companion.io.sensors.crsf import CrsfReceiver
from companion.io.sensors.mavlink_imu import MavlinkImu
from companion.io.sensors.mavlink_range import MavlinkRange
from companion.io.sensors.mtdata2 import Mtdata2Sensor
from companion.io.sensors.nmea0183 import Nmea0183Sensor
from companion.io.sensors.sbus import SbusReceiver
from companion.io.sensors.vectornav import VectorNavSensor

DRIVERS: Mapping[str, Callable[[Any, ByteStream], Sensor]] = {
    "nmea0183": Nmea0183Sensor,
    "mtdata2": Mtdata2Sensor,
    "vectornav": VectorNavSensor,
    "mavlink_imu": MavlinkImu,
    "ais": AisReceiver,
    "mavlink_range": MavlinkRange,
    "sbus": SbusReceiver,
    "crsf": CrsfReceiver,
}
GROUP = "usv_companion.sensors"


@dataclass(frozen=True, slots=True)
class SensorDriver:
    """What another package registers: the dataclass and the checks of its row, and the driver itself.

    `open(row, stream)` → the driver on its port; `row` is of the class that `kind` names.
    """

    kind: SensorKind
    open: Callable[[Any, ByteStream], Sensor]


def refusal(driver: str) -> str | None:
    """Why a file cannot name that driver; None for one that is there."""
    return plugins.refusal(driver, DRIVERS, GROUP)


def plugin_problems(sensors: Sequence[SensorConfig]) -> list[Problem]:
    """Faults of the rows whose driver another package has, with their places."""
    problems: list[Problem] = []
    for i, sensor in enumerate(sensors):
        if sensor.driver not in DRIVERS and refusal(sensor.driver) is None:
            problems += _judged(sensor, ("sensor", i))[1]
    return problems


def open_sensor(config: SensorConfig, stream: ByteStream) -> Sensor:
    """The driver that `config` names, on `stream`. Raises ConfigError for a driver that is not there or cannot be
    used."""
    if (factory := DRIVERS.get(config.driver)) is not None:
        return factory(config, stream)
    if (text := refusal(config.driver)) is not None:
        raise ConfigError([f"sensor '{config.name}': {text}"])
    plugin = plugins.loaded(config.driver, GROUP, SensorDriver)
    row, problems = _judged(config, (f"sensor '{config.name}'",))
    if problems:
        raise ConfigError([f"{dotted(place)}: {text}" for place, text in problems])
    return plugins.guarded(config.driver, lambda: plugin.open(row, stream), GROUP)


def _judged(sensor: SensorConfig, at: Place) -> tuple[SensorConfig, list[Problem]]:
    """The row as its plug-in declares it, and what is wrong with it. `at`: place of the row."""
    try:
        kind = plugins.loaded(sensor.driver, GROUP, SensorDriver).kind
        row = completed(sensor, kind.row)
        return row, plugins.guarded(sensor.driver, lambda: kind.problems(row, at), GROUP)
    except ValidationError as error:
        return sensor, [((*at, *found["loc"]), remedy(found["msg"])) for found in error.errors()]
    except ConfigError as error:
        return sensor, [((*at, "driver"), text) for text in error.problems]
