"""How a bridge reaches its drives, and what a drive is told for a throttle, as a vessel's file describes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import FROM_DEGREES, STRICT, NonNegative, Positive

PULSE_DRIVERS = frozenset({"mavlink_servo"})  # bridges whose drives are told pulses in µs; all others, a share −1…1 of what they can
_Relay = Annotated[int, Field(ge=0, le=15)]
_Pulse = Annotated[float, Field(ge=500.0, le=2500.0)]


@dataclass(frozen=True, slots=True)
class Scale:
    """What a drive is told at standstill, at full ahead and at full astern; up to `dead_band` either side of standstill it does nothing."""

    trim: float
    ahead: float
    astern: float
    dead_band: float


@dataclass(frozen=True, slots=True)
class OutputConfig:
    """Calibration of one thruster's drive, `[thruster.output]`, in the unit of its bridge: µs of servo pulses, or a share −1…1.

    `trim` at standstill, `ahead` and `astern` at full throttle; None: 1500, 2000 and 1000 µs, or 0, 1 and −1. `reversed` swaps the two. A share's
    trim is 0, since a board that goes neutral by itself knows no other.
    `dead_band` either side of trim is skipped. `rate_ps`: most change of throttle a second away from standstill; towards it none is held back.
    Azimuth drives that are told angles: `azimuth_trim_rad` is what the drive shows with the thruster ahead, `azimuth_reversed` that it counts
    counter-clockwise. Azimuth servos: their pulses at the thruster's azimuth_min_deg and azimuth_max_deg, of which either may be the longer.
    """

    __pydantic_config__ = STRICT
    trim: float | None = None
    ahead: float | None = None
    astern: float | None = None
    dead_band: NonNegative = 0.0
    reversed: bool = False
    rate_ps: Positive | None = None
    azimuth_trim_rad: Annotated[float, Field(alias="azimuth_trim_deg", ge=-180.0, le=180.0), FROM_DEGREES] = 0.0
    azimuth_reversed: bool = False
    azimuth_min_us: _Pulse = 1000.0
    azimuth_max_us: _Pulse = 2000.0

    def scale(self, pulses: bool) -> Scale:
        """With what was left out, and `reversed` seen to."""
        trim, ahead, astern = (1500.0, 2000.0, 1000.0) if pulses else (0.0, 1.0, -1.0)
        trim = trim if self.trim is None else self.trim
        ahead = ahead if self.ahead is None else self.ahead
        astern = astern if self.astern is None else self.astern
        return Scale(trim, astern, ahead, self.dead_band) if self.reversed else Scale(trim, ahead, astern, self.dead_band)


@dataclass(frozen=True, slots=True)
class MavlinkBoardConfig:
    """`[actuator.mavlink]`: the outputs of an autopilot board, one channel for each of the bridge's thrusters, and for each that turns one more.

    By "override" (RC_CHANNELS_OVERRIDE) the board lets go of the channels when the companion falls silent. By "do_set_servo" it holds its last
    pulses for ever: `unguarded` says that the owner knows, and has something else that stops the thrusters. `system`: the id under which the board
    takes orders (MAV_GCS_SYSID of ArduPilot). `servo_channels` and `relays`: one for each of the bridge's servos and relays, the board's relays
    numbered from 0; they too stay as they are in silence, but for servos by override. `lamps`: relays of the beacon's red, yellow and green.
    """

    __pydantic_config__ = STRICT
    channels: tuple[Annotated[int, Field(ge=1, le=16)], ...]
    azimuth_channels: tuple[Annotated[int, Field(ge=0, le=16)], ...] = ()  # 0: does not turn
    servo_channels: tuple[Annotated[int, Field(ge=1, le=16)], ...] = ()
    relays: tuple[_Relay, ...] = ()
    lamps: Annotated[tuple[_Relay, ...], Field(max_length=3)] = ()
    method: Literal["override", "do_set_servo"] = "override"
    unguarded: bool = False
    system: Annotated[int, Field(ge=1, le=255)] = 255
