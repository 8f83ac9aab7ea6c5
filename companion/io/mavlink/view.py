"""What telemetry messages are made from, and the numbers that fit into their fields."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.types import ModeId, Status, Tick
from companion.io.mavlink.vessel import VesselFace

UINT8_UNKNOWN = 0xFF
UINT16_UNKNOWN = 0xFFFF
INT16_MAX = 0x7FFF
INT32_MAX = 0x7FFFFFFF


@dataclass(slots=True)
class View:
    """The vessel at one moment. `status` may be newer than `tick`, which is None before the first one."""

    vessel: VesselFace
    tick: Tick | None
    status: Status
    now_s: float
    modes_seq: int = 0
    control: tuple[int, bool] = (0, True)  # the system that has it, whether another may take it over
    received: int = 0  # packets of the leader module, on the endpoint that the message is for

    @property
    def boot_ms(self) -> int:
        return int(self.now_s * 1000.0) & 0xFFFFFFFF

    @property
    def unix_us(self) -> int:
        return 0 if self.tick is None else max(0, self.tick.time_unix_ns // 1000)


def fitted(value: float | None, scale: float, low: int, high: int, unknown: int) -> int:
    """`value * scale` as the nearest whole number in [low, high]; `unknown` for what is missing or not a number."""
    if value is None or not math.isfinite(value):
        return unknown
    return min(high, max(low, round(value * scale)))


def degrees_e7(value_deg: float) -> int:
    """Latitude or longitude as MAVLink's degE7; 0 for what is not a number."""
    return fitted(value_deg, 1e7, -INT32_MAX, INT32_MAX, 0)


def millimetres(value_m: float | None) -> int:
    return fitted(value_m, 1000.0, -INT32_MAX, INT32_MAX, 0)


def centidegrees(angle_rad: float | None) -> int:
    """0…35999, clockwise from north; UINT16_MAX for unknown."""
    if angle_rad is None or not math.isfinite(angle_rad):
        return UINT16_UNKNOWN
    return round(math.degrees(angle_rad) * 100.0) % 36000


def whole_degrees(angle_rad: float) -> int:
    """0…359; 0 for what is not a number."""
    return round(math.degrees(angle_rad)) % 360 if math.isfinite(angle_rad) else 0


def standard_mode(mode: ModeId) -> int:
    """MAV_STANDARD_MODE: only Mission bears one, since the others would hide the vessel's own names in QGroundControl."""
    return 6 if mode is ModeId.MISSION else 0
