"""One axis repeats while the others go on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import IMU_AXES, Evidence
from companion.nav.integrity.imu_stuck import ImuStuck
from tests.unit.nav.integrity.honest_boat import Boat, Passage
from tests.unit.nav.integrity.lies import frozen_imu

FIELDS = ("x_mps2", "y_mps2", "z_mps2", "roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps")


@pytest.mark.parametrize(("axis", "field"), list(zip(IMU_AXES, FIELDS, strict=True)))
def test_each_axis_is_named(axis: str, field: str) -> None:
    def stuck(evidence: Evidence, age_s: float) -> None:
        evidence.raw_imu = [replace(imu, **{field: 20.0}) for imu in evidence.raw_imu]  # type: ignore[arg-type]

    passage = Passage(ImuStuck(), Boat())
    assert passage.go(10.0) == []
    age_s, finding = passage.go(1.0, stuck)[0]
    assert finding.fault == f"{axis} axis stuck" and age_s <= 0.7
    assert passage.go(1.0) == [], "it is over as soon as the axis moves"


def test_a_coarse_sensor_may_rest_for_some_samples() -> None:
    """Steps of 0.05 m/s² and rad/s, far above its noise."""

    def coarse(evidence: Evidence, age_s: float) -> None:
        evidence.raw_imu = [
            replace(imu, **{field: round(getattr(imu, field) * 20.0) / 20.0 for field in FIELDS if "rate" not in field})
            for imu in evidence.raw_imu
        ]

    assert Passage(ImuStuck(), Boat()).go(60.0, coarse) == []


def test_a_sensor_that_repeats_whole_is_not_stuck() -> None:
    """Which `repeated.py` judges."""
    passage = Passage(ImuStuck(), Boat())
    passage.go(10.0)
    assert passage.go(5.0, frozen_imu) == []
