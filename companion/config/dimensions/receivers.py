"""How good a simulated receiver is where `[sitl]` does not say: as the sensors' rows say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from companion.config.devices import SensorConfig

_POSITIONING = ("nmea0183",)


def grade_of(sensors: Sequence[SensorConfig]) -> Literal["rtk", "sbas"]:
    """`rtk` where a receiver takes corrections by RTCM or has two antennas, else `sbas`."""
    receivers = [row for row in sensors if row.driver in _POSITIONING and "wind" not in row.name]
    return "rtk" if any(row.rtcm or row.antennas == 2 for row in receivers) else "sbas"
