"""Drivers of thruster bridges: commands → bytes, one file a bridge, all in one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from companion.config import ActuatorConfig, ConfigError, VesselConfig
from companion.core.ports import Actuator, ByteStream
from companion.io.actuators.mavlink_servo import MavlinkServoBridge
from companion.io.actuators.microcontroller import MicrocontrollerBridge
from companion.io.actuators.nanotec import NanotecBridge
from companion.io.actuators.nmea2000 import Nmea2000Bridge

DRIVERS: Mapping[str, Callable[[ActuatorConfig, VesselConfig, ByteStream], Actuator]] = {
    "mavlink_servo": MavlinkServoBridge,
    "microcontroller": MicrocontrollerBridge,
    "nanotec": NanotecBridge,
    "nmea2000": Nmea2000Bridge,
}


def open_actuator(config: ActuatorConfig, vessel: VesselConfig, stream: ByteStream) -> Actuator:
    """The driver that `config` names, on `stream`. Raises ConfigError for a name that is not in the table."""
    driver = DRIVERS.get(config.driver)
    if driver is None:
        raise ConfigError([f"actuator '{config.name}': no driver '{config.driver}'; known: {', '.join(sorted(DRIVERS))}"])
    return driver(config, vessel, stream)
