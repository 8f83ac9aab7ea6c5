"""How a bridge reaches its drives, and what a drive is told for a throttle, as a vessel's file describes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import FROM_DEGREES, STRICT, NonNegative, Positive, means

_Pulse = Annotated[float, Field(ge=500.0, le=2500.0)]


@dataclass(frozen=True, slots=True)
class Scale:
    """What a drive is told at standstill, at full ahead and at full astern; up to `dead_band` either side of standstill
    it does nothing."""

    trim: float
    ahead: float
    astern: float
    dead_band: float


@dataclass(frozen=True, slots=True)
class OutputConfig:
    """Calibration of the drive of one thruster, in the unit of its bridge: µs of servo pulses, or a share −1…1.

    A share's trim is 0, since a board that goes to neutral by itself knows no other.
    """

    __pydantic_config__ = STRICT
    trim: Annotated[
        float | None,
        means("Command at standstill. Left out: 1500 µs, or 0 for a share. A share's trim must be 0."),
    ] = None
    ahead: Annotated[float | None, means("Command at full throttle ahead. Left out: 2000 µs, or 1.")] = None
    astern: Annotated[float | None, means("Command at full throttle astern. Left out: 1000 µs, or −1.")] = None
    dead_band: Annotated[
        NonNegative,
        means("Width on either side of `trim` in which the drive does nothing. Commands skip it."),
    ] = 0.0
    reversed: Annotated[bool, means("Swap `ahead` and `astern`.")] = False
    rate_ps: Annotated[
        Positive | None,
        means(
            "Fastest change of throttle away from standstill, as a share per second. The way back to "
            "standstill is never slowed."
        ),
    ] = None
    azimuth_trim_rad: Annotated[
        float,
        Field(alias="azimuth_trim_deg", ge=-180.0, le=180.0),
        FROM_DEGREES,
        means("Angle that the azimuth drive shows when the thruster points ahead."),
    ] = 0.0
    azimuth_reversed: Annotated[bool, means("The azimuth drive counts counter-clockwise.")] = False
    azimuth_min_us: Annotated[_Pulse, means("Pulse of an azimuth servo at `azimuth_min_deg` of the thruster.")] = 1000.0
    azimuth_max_us: Annotated[
        _Pulse,
        means("Pulse of an azimuth servo at `azimuth_max_deg` of the thruster. It may be shorter than the other."),
    ] = 2000.0

    def scale(self, pulses: bool) -> Scale:
        """With what was left out, and `reversed` seen to."""
        trim, ahead, astern = (1500.0, 2000.0, 1000.0) if pulses else (0.0, 1.0, -1.0)
        trim = trim if self.trim is None else self.trim
        ahead = ahead if self.ahead is None else self.ahead
        astern = astern if self.astern is None else self.astern
        return (
            Scale(trim, astern, ahead, self.dead_band) if self.reversed else Scale(trim, ahead, astern, self.dead_band)
        )
