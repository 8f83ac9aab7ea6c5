"""The sensors by the name of their driver: the dataclass of their row in a file, and its checks.

All of these share the keys of `SensorConfig`, since the filter needs most of them of any sensor. A driver with keys of
its own has a file here with its subclass of SensorConfig, which its row names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from companion.config.devices import SensorConfig
from companion.config.kinds import ByDriver, SensorKind
from companion.config.sensors.rc import sbus_problems

SENSORS: Mapping[str, SensorKind] = {
    "nmea0183": SensorKind(),
    "mtdata2": SensorKind(inertial=True, averages=True),
    "vectornav": SensorKind(inertial=True),
    "mavlink_imu": SensorKind(inertial=True),
    "ais": SensorKind(),
    "mavlink_range": SensorKind(),
    "sbus": SensorKind(problems=sbus_problems),
    "crsf": SensorKind(),
}

SensorRow = Annotated[SensorConfig, ByDriver(SENSORS)]
"""The type of a row in a file: read into the dataclass of its driver."""


def is_inertial(row: SensorConfig) -> bool:
    """Whether the sensor gives accelerations and rates. Of a plug-in's: if the row uses its yaw."""
    kind = SENSORS.get(row.driver)
    return row.heading != "none" if kind is None else kind.inertial


def is_averaging(row: SensorConfig) -> bool:
    """Whether an inertial sensor integrates: its accelerations and rates are means since the sample before."""
    kind = SENSORS.get(row.driver)
    return kind is not None and kind.averages
