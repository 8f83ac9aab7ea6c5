"""Accelerometers feel gravity, and from below."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.readings import Imu
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.imu_gravity import ImuGravity
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil


def down(factor: float) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.imu = [replace(imu, z_mps2=factor * imu.z_mps2) for imu in evidence.imu]

    return spoil


@pytest.mark.parametrize(
    ("factor", "fault"), [(-1.0, "is upside down"), (0.0, "force is not gravity"), (2.0, "force is not gravity")]
)
def test_wrong_gravity_is_found(factor: float, fault: str) -> None:
    passage = Passage(ImuGravity(), Boat())
    assert passage.go(10.0) == []
    found = passage.go(10.0, down(factor))
    assert found[0][0] <= 4.0 and found[-1][1].fault == fault


def test_of_a_sensor_that_is_mounted_upside_down_nothing_is_used() -> None:
    """Its gyro turns the other way, too: the heading beside it is right."""
    found = Passage(ImuGravity(), Boat()).go(6.0, down(-1.0))
    assert {finding.channel for _, finding in found} == {Channel(Sense.IMU, "imu")}
    found = Passage(ImuGravity(), Boat()).go(6.0, down(2.0))
    assert {finding.channel for _, finding in found} == {Channel(Sense.ACCELEROMETER, "imu")}


def test_slamming_is_no_lie() -> None:
    """Twice gravity for a tenth of a second, every second."""

    def slam(evidence: Evidence, age_s: float) -> None:
        if round(age_s * 10.0) % 10 == 0:
            down(2.0)(evidence, age_s)

    assert Passage(ImuGravity(), Boat()).go(60.0, slam) == []


def test_it_ends_with_the_fault() -> None:
    passage = Passage(ImuGravity(), Boat())
    assert passage.go(10.0, down(0.0))
    assert not [age_s for age_s, _ in passage.go(20.0) if age_s > 6.0]


def faults(force: tuple[float, float, float], speed_mps: float, yaw_rate_radps: float) -> set[str]:
    """What is found within 10 s of a steady force."""
    hypothesis, found = ImuGravity(), set()
    for k in range(200):
        imu = Imu(0.05 * k, "imu", *force, 0.0, 0.0, yaw_rate_radps)
        evidence = Evidence(imu=[imu], driven=True, north_mps=speed_mps)
        found |= {finding.fault for finding in hypothesis.update(evidence, imu.t_s)}
    return found


def test_a_tight_turn_at_speed_adds_to_gravity() -> None:
    """A jet that turns at 1 rad/s and 8 m/s feels 8 m/s² to the side, or none of it where it slides."""
    assert faults((0.0, 8.0, -9.81), 8.0, 1.0) == set()
    assert faults((0.0, 0.0, -9.81), 8.0, 1.0) == set()
    assert faults((0.0, 8.0, -9.81), 1.0, 1.0) == {"force is not gravity"}


def test_the_first_sample_after_a_gap_is_no_mean() -> None:
    """It may be that of a wave's crest."""
    hypothesis = ImuGravity()
    for k in range(400):
        lost = 200 <= k < 250
        length = 12.5 if k == 250 else 9.81
        imu = [] if lost else [Imu(0.1 * k, "imu", 0.0, 0.0, -length, 0.0, 0.0, 0.0)]
        assert not hypothesis.update(Evidence(driven=True, imu=imu), 0.1 * k)
