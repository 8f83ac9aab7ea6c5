"""The bridges by the name of their driver: the dataclass of their row in a vessel's file, and its checks.

A new bridge is its file here, its file in `companion.io.actuators`, and one row in the table of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from companion.config.actuators.mavlink_servo import MavlinkServoConfig, mavlink_servo_problems
from companion.config.actuators.microcontroller import microcontroller_problems
from companion.config.actuators.nanotec import NanotecConfig, nanotec_problems
from companion.config.actuators.nmea2000 import Nmea2000Config, nmea2000_problems
from companion.config.devices import ActuatorConfig
from companion.config.kinds import BridgeKind, ByDriver

BRIDGES: Mapping[str, BridgeKind] = {
    "mavlink_servo": BridgeKind(MavlinkServoConfig, mavlink_servo_problems, pulses=True),
    "microcontroller": BridgeKind(problems=microcontroller_problems),
    "nanotec": BridgeKind(NanotecConfig, nanotec_problems),
    "nmea2000": BridgeKind(Nmea2000Config, nmea2000_problems),
}

BridgeRow = Annotated[ActuatorConfig, ByDriver(BRIDGES)]
"""The type of a row in a file: read into the dataclass of its driver."""
