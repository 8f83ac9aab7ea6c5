"""What the sensors of a simulated boat get wrong beyond noise and slow biases."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import FROM_DEGREES, STRICT, NonNegative, Positive, means


@dataclass(frozen=True, slots=True)
class SensorErrorConfig:
    """Errors of the boat's sensors that come from how they are made and where they stand. The defaults are published
    figures; a plant without this table has none of these errors."""

    __pydantic_config__ = STRICT
    imu_scale: Annotated[
        float,
        Field(ge=0.0, le=0.1),
        means("One sigma of the scale factor of each inertial axis. InvenSense ICM-20602: within 1 %."),
    ] = 0.005
    imu_misalignment_rad: Annotated[
        float,
        Field(alias="imu_misalignment_deg", ge=0.0, le=10.0),
        FROM_DEGREES,
        means("One sigma of each angle of the inertial axes, as made and as mounted. MPU-6000: within 2 % of an axis."),
    ] = math.radians(0.5)
    vibration_mps: Annotated[
        NonNegative,
        means(
            "Vibration at the inertial sensor, RMS of the velocity with one thruster at full revolutions. ISO 10816-1: "
            "1.8 mm/s is the most that a small machine may have for long."
        ),
    ] = 0.0018
    full_rps: Annotated[
        Positive, means("Revolutions of a propeller at full throttle, 1/s. A trolling motor: 20 to 25; an M200: 55.")
    ] = 30.0
    compass_nt_per_a: Annotated[
        NonNegative,
        means(
            "Magnetic field of the battery's current at the compass. Two wires 20 mm apart, half a metre away: 16 nT "
            "per ampere (Biot and Savart)."
        ),
    ] = 16.0
    wind_upwash: Annotated[
        float,
        Field(ge=0.0, le=0.5),
        means("Share by which wind on the beam is faster over the hull. Moat et al. 2004: 0.18 above a ship's bridge."),
    ] = 0.1
    wind_shadow: Annotated[
        float,
        Field(ge=0.0, le=1.0),
        means("Share of the wind that is lost behind mast and gear. Moat et al. 2004: up to all of it."),
    ] = 0.3
    shadow_from_rad: Annotated[
        float,
        Field(alias="shadow_from_deg", ge=-360.0, le=360.0),
        FROM_DEGREES,
        means("Direction of mast and gear as the wind sensor sees them, clockwise from the bow."),
    ] = math.pi
