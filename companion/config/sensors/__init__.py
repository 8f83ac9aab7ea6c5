"""The sensors by the name of their driver: the dataclass of their row in a file, and its checks.

All of these share the keys of `SensorConfig`, since the filter needs most of them of any sensor. A driver with keys of
its own has a file here with its subclass of SensorConfig, which its row names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from companion.config.devices import SensorConfig
from companion.config.kinds import ByDriver, SensorKind

SENSORS: Mapping[str, SensorKind] = {
    "nmea0183": SensorKind(),
    "mtdata2": SensorKind(),
    "vectornav": SensorKind(),
    "mavlink_imu": SensorKind(),
    "ais": SensorKind(),
}

SensorRow = Annotated[SensorConfig, ByDriver(SENSORS)]
"""The type of a row in a file: read into the dataclass of its driver."""
