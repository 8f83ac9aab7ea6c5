"""Emulated devices, by the driver that talks to them. A new one is one file and one row."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from companion.config import ActuatorConfig, ConfigError, SensorConfig
from sitl.battery import BatteryModel
from sitl.emulators.ais import AisEmulator
from sitl.emulators.compass import CompassEmulator
from sitl.emulators.device import Board, Device, Surroundings
from sitl.emulators.gnss import GnssEmulator
from sitl.emulators.mavlink_servo import MavlinkServoEmulator
from sitl.emulators.microcontroller import MicrocontrollerEmulator
from sitl.emulators.nanotec import NanotecEmulator
from sitl.emulators.nmea2000 import Nmea2000Emulator
from sitl.emulators.pixhawk import PixhawkEmulator
from sitl.emulators.sounder import SounderEmulator
from sitl.emulators.vectornav import VectorNavEmulator
from sitl.emulators.wind_sensor import WindEmulator
from sitl.emulators.xsens import XsensEmulator
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import Thruster

_INSTRUMENTS: Mapping[str, Callable[[SensorConfig, MemoryDevice, Surroundings], Device]] = {
    "wind": WindEmulator,
    "compass": CompassEmulator,
    "sounder": SounderEmulator,
}


def _nmea0183(config: SensorConfig, port: MemoryDevice, around: Surroundings) -> Device:
    """Many kinds of device speak it: one called wind…, compass… or sounder… is that, any other a satellite receiver."""
    for name, kind in _INSTRUMENTS.items():
        if config.name.startswith(name):
            return kind(config, port, around)
    return GnssEmulator(config, port, around)


SENSORS: Mapping[str, Callable[[SensorConfig, MemoryDevice, Surroundings], Device]] = {
    "nmea0183": _nmea0183,
    "mtdata2": XsensEmulator,
    "vectornav": VectorNavEmulator,
    "mavlink_imu": PixhawkEmulator,
    "ais": AisEmulator,
}
BOARDS: Mapping[str, Callable[[ActuatorConfig, MemoryDevice, Sequence[Thruster], BatteryModel, Faults], Board]] = {
    "mavlink_servo": MavlinkServoEmulator,
    "microcontroller": MicrocontrollerEmulator,
    "nanotec": NanotecEmulator,
    "nmea2000": Nmea2000Emulator,
}


def sensor(config: SensorConfig, port: MemoryDevice, around: Surroundings) -> Device:
    """The device that `config.driver` talks to. Raises ConfigError where there is none."""
    make = SENSORS.get(config.driver)
    if make is None:
        raise ConfigError([f"sensor '{config.name}': no simulated device for driver '{config.driver}'; there is {', '.join(SENSORS)}"])
    return make(config, port, around)


def board(config: ActuatorConfig, port: MemoryDevice, thrusters: Mapping[str, Thruster], battery: BatteryModel, faults: Faults) -> Board:
    """The board that `config.driver` talks to, with those of `thrusters` that it drives, by name. Raises ConfigError where there is none."""
    make = BOARDS.get(config.driver)
    if make is None:
        raise ConfigError([f"actuator '{config.name}': no simulated device for driver '{config.driver}'; there is {', '.join(BOARDS)}"])
    driven = dict.fromkeys((*config.thrusters, *config.azimuths))
    return make(config, port, [thrusters[name] for name in driven], battery, faults)
