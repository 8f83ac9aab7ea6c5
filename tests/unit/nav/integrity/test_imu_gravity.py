"""The force that accelerometers feel: gravity in a straight line and in a tight turn, else not believed."""

from __future__ import annotations

import pytest

from companion.core.readings import Imu
from companion.nav.integrity.evidence import Evidence
from companion.nav.integrity.imu_gravity import ImuGravity

G = 9.81


def faults(force: tuple[float, float, float], speed_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> set[str]:
    """What is found within 10 s."""
    hypothesis, found = ImuGravity(), set()
    for k in range(200):
        t_s = 0.05 * k
        imu = Imu(t_s, "imu", *force, 0.0, 0.0, yaw_rate_radps)
        evidence = Evidence(imu=[imu], driven=True, north_mps=speed_mps)
        found |= {finding.fault for finding in hypothesis.update(evidence, t_s)}
    return found


def test_gravity_is_believed() -> None:
    assert faults((0.3, -0.2, -G)) == set()


@pytest.mark.parametrize("scale", [0.0, 0.8, 1.2, 3.0])
def test_a_force_of_another_size_is_not(scale: float) -> None:
    assert faults((0.0, 0.0, -scale * G)) == {"force is not gravity"}


def test_a_sensor_upside_down_is_told() -> None:
    assert faults((0.0, 0.0, G)) == {"is upside down"}


def test_a_tight_turn_at_speed_adds_to_gravity() -> None:
    """A jet that turns at 1 rad/s and 8 m/s feels 8 m/s² to the side, or none of it where it slides."""
    assert faults((0.0, 8.0, -G), speed_mps=8.0, yaw_rate_radps=1.0) == set()
    assert faults((0.0, 0.0, -G), speed_mps=8.0, yaw_rate_radps=1.0) == set()
    assert faults((0.0, 8.0, -G), speed_mps=1.0, yaw_rate_radps=1.0) == {"force is not gravity"}
