"""A whole estimate for tests, which take from it what they do not care about."""

from __future__ import annotations

from dataclasses import replace

from companion.core.estimate import NO_ESTIMATE
from companion.core.readings import FixType

AT_REST = replace(
    NO_ESTIMATE,
    position_valid=True,
    heading_valid=True,
    lat_deg=63.4389,
    lon_deg=10.399,
    position_accuracy_m=0.02,
    velocity_accuracy_mps=0.02,
    heading_accuracy_rad=0.01,
    position_age_s=0.0,
    heading_age_s=0.0,
    imu_age_s=0.0,
    fix=FixType.RTK_FIXED,
    satellites=14,
    hdop=0.7,
)
