"""The data that telemetry messages are built from, and conversions to the messages' integer fields."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from companion.core.decision import ModeId, Status
from companion.core.tick import Tick
from companion.io.mavlink.wire.personas import Persona
from companion.loop import Vessel
from companion.modes.table import DECLARATIONS

UINT8_UNKNOWN = 0xFF
UINT16_UNKNOWN = 0xFFFF
INT16_MAX = 0x7FFF
INT32_MAX = 0x7FFFFFFF


@dataclass(slots=True)
class View:
    """The vessel at one moment. `status` may be newer than `tick`; `tick` is None before the first one."""

    vessel: Vessel
    tick: Tick | None
    status: Status
    now_s: float
    modes_seq: int = 0
    control: tuple[int, bool] = (0, True)  # system with operator control, whether another may take it over
    event_sequence: tuple[int, bool] = (0, True)  # number of the newest event; whether there has been none yet
    modes_asked: Mapping[Persona, int] = field(default_factory=dict)  # the number of a mode that was asked for last
    received: int = 0  # packets of the leader module on the endpoint that the message is for

    @property
    def boot_ms(self) -> int:
        """Vessel time in ms, modulo 2³²."""
        return int(self.now_s * 1000.0) & 0xFFFFFFFF

    def custom_mode(self, persona: Persona, mode: ModeId) -> int:
        """The number of `mode` as clients of that persona should see it; they see Guided that holds as Guided."""
        if self.status.guided and persona.offboard_may_wait and mode is ModeId.HOLD:
            mode = ModeId.OFFBOARD
        return persona.custom_mode(mode, self.modes_asked.get(persona))

    @property
    def unix_us(self) -> int:
        """Unix time of the tick in µs; 0 where it is not known."""
        return 0 if self.tick is None else max(0, self.tick.time_unix_ns // 1000)


def fitted(value: float | None, scale: float, low: int, high: int, unknown: int) -> int:
    """`value * scale`, rounded and limited to [low, high]; `unknown` for None and for values that are not finite."""
    if value is None or not math.isfinite(value):
        return unknown
    return min(high, max(low, round(value * scale)))


def degrees_e7(value_deg: float) -> int:
    """Latitude or longitude as MAVLink's degE7; 0 where not finite."""
    return fitted(value_deg, 1e7, -INT32_MAX, INT32_MAX, 0)


def millimetres(value_m: float | None) -> int:
    """Length in mm; 0 where unknown or not finite."""
    return fitted(value_m, 1000.0, -INT32_MAX, INT32_MAX, 0)


def centidegrees(angle_rad: float | None) -> int:
    """Angle in 0.01°, 0…35999; UINT16_UNKNOWN where unknown or not finite."""
    if angle_rad is None or not math.isfinite(angle_rad):
        return UINT16_UNKNOWN
    return round(math.degrees(angle_rad) * 100.0) % 36000


def whole_degrees(angle_rad: float) -> int:
    """Angle in whole degrees, 0…359; 0 where not finite."""
    return round(math.degrees(angle_rad)) % 360 if math.isfinite(angle_rad) else 0


def standard_mode(mode: ModeId) -> int:
    """MAV_STANDARD_MODE as reported. A mode that shows one loses its own name in QGroundControl, so only Mission
    does."""
    declared = DECLARATIONS[mode]
    return declared.standard_mode if declared.shows_standard else 0
