"""Readings beside those of `types`, which others take them from."""

from __future__ import annotations

from dataclasses import dataclass

from companion.core.records import quick


@quick
@dataclass(frozen=True, slots=True)
class MagneticField:
    """Magnetic field in body axes as the device measures it, in its own unit: `mag_offset` and `mag_matrix` are not applied yet."""

    t_s: float
    source: str
    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True)
class Depth:
    """Depth of water below the transducer. `offset_m`: from the transducer up to the surface (positive) or down to the keel (negative),
    where the sounder knows it."""

    t_s: float
    source: str
    below_transducer_m: float
    offset_m: float | None = None
    range_m: float | None = None  # the most that it can sound now


@dataclass(frozen=True, slots=True)
class Corrections:
    """What a satellite receiver says of the corrections that its fix rests on."""

    t_s: float
    source: str
    age_s: float
    station: int | None  # number of the reference station


@dataclass(frozen=True, slots=True)
class Measurement:
    """What an instrument measures and only the log wants to know: `name` bears the unit, as `rudder_rad`, `water_surge_mps`, `rate_of_turn_radps`."""

    t_s: float
    source: str
    value: float
    name: str
