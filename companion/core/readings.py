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
