"""Drivers of sensors: bytes → readings, one file a protocol, all in one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from companion.config import ConfigError, SensorConfig
from companion.core.ports import ByteStream, Sensor
from companion.io.sensors.ais import AisReceiver
from companion.io.sensors.mavlink_imu import MavlinkImu
from companion.io.sensors.mtdata2 import Mtdata2Sensor
from companion.io.sensors.nmea0183 import Nmea0183Sensor
from companion.io.sensors.vectornav import VectorNavSensor

DRIVERS: Mapping[str, Callable[[SensorConfig, ByteStream], Sensor]] = {
    "nmea0183": Nmea0183Sensor,
    "mtdata2": Mtdata2Sensor,
    "vectornav": VectorNavSensor,
    "mavlink_imu": MavlinkImu,
    "ais": AisReceiver,
}


def open_sensor(config: SensorConfig, stream: ByteStream) -> Sensor:
    """The driver that `config` names, on `stream`. Raises ConfigError for a name that is not in the table."""
    driver = DRIVERS.get(config.driver)
    if driver is None:
        raise ConfigError([f"sensor '{config.name}': no driver '{config.driver}'; known: {', '.join(sorted(DRIVERS))}"])
    return driver(config, stream)
