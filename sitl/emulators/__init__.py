"""Emulated devices, by the driver that reads them. A new one is one file and one row."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.vessel import ConfigError
from sitl.battery import BatteryModel
from sitl.emulators.ais import AisEmulator
from sitl.emulators.compass import CompassEmulator
from sitl.emulators.device import Board, Device, SensedWorld
from sitl.emulators.gnss import GnssEmulator
from sitl.emulators.lidar import LidarEmulator
from sitl.emulators.mavlink_servo import MavlinkServoEmulator
from sitl.emulators.microcontroller import MicrocontrollerEmulator
from sitl.emulators.nanotec import NanotecEmulator
from sitl.emulators.nmea2000 import Nmea2000Emulator
from sitl.emulators.pixhawk import PixhawkEmulator
from sitl.emulators.radar import RadarEmulator
from sitl.emulators.rc_receiver import CrsfEmulator, SbusEmulator
from sitl.emulators.sounder import SounderEmulator
from sitl.emulators.vectornav import VectorNavEmulator
from sitl.emulators.wind_sensor import WindEmulator
from sitl.emulators.xsens import XsensEmulator
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import ThrusterModel

_INSTRUMENTS: Mapping[str, Callable[[SensorConfig, MemoryDevice, SensedWorld], Device]] = {
    "wind": WindEmulator,
    "compass": CompassEmulator,
    "sounder": SounderEmulator,
    "radar": RadarEmulator,
}


def is_receiver(config: SensorConfig) -> bool:
    """Whether the sensor is simulated as a satellite receiver of NMEA 0183."""
    return config.driver == "nmea0183" and not config.name.startswith(tuple(_INSTRUMENTS))


def _nmea0183(config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> Device:
    """One driver reads many kinds of device: the name's beginning wind…, compass…, sounder… or radar… chooses; any
    other is a receiver."""
    for name, kind in _INSTRUMENTS.items():
        if config.name.startswith(name):
            return kind(config, port, around)
    return GnssEmulator(config, port, around)


SENSORS: Mapping[str, Callable[[SensorConfig, MemoryDevice, SensedWorld], Device]] = {
    "nmea0183": _nmea0183,
    "mtdata2": XsensEmulator,
    "vectornav": VectorNavEmulator,
    "mavlink_imu": PixhawkEmulator,
    "ais": AisEmulator,
    "mavlink_range": LidarEmulator,
    "sbus": SbusEmulator,
    "crsf": CrsfEmulator,
}
BOARDS: Mapping[str, Callable[[Any, MemoryDevice, Sequence[ThrusterModel], BatteryModel, Faults], Board]] = {
    "mavlink_servo": MavlinkServoEmulator,
    "microcontroller": MicrocontrollerEmulator,
    "nanotec": NanotecEmulator,
    "nmea2000": Nmea2000Emulator,
}


def sensor(config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> Device:
    """The device that the driver `config.driver` reads. Raises ConfigError where there is none."""
    make = SENSORS.get(config.driver)
    if make is None:
        there_is = ", ".join(SENSORS)
        raise ConfigError(
            [
                f"sensor '{config.name}': no simulated device for driver '{config.driver}'; there is {there_is}. "
                "For one of your own run `companion sitl` with a file without this row, and beside it `companion run "
                "--devices` with this file and a program of yours that prints what the device would"
            ]
        )
    return make(config, port, around)


def board(
    config: ActuatorConfig,
    port: MemoryDevice,
    thrusters: Mapping[str, ThrusterModel],
    battery: BatteryModel,
    faults: Faults,
) -> Board:
    """The board that the driver `config.driver` commands. `thrusters`: all of the vessel, by name. Raises ConfigError
    where there is none."""
    make = BOARDS.get(config.driver)
    if make is None:
        there_is = ", ".join(BOARDS)
        raise ConfigError(
            [f"actuator '{config.name}': no simulated device for driver '{config.driver}'; there is {there_is}"]
        )
    driven = dict.fromkeys((*config.thrusters, *config.azimuths))
    return make(config, port, [thrusters[name] for name in driven], battery, faults)
