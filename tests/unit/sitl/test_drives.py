"""The simulated drive between a bridge and a propeller, against the bridge's own calibration."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.io.actuators.calibration import AzimuthServo
from sitl.drives import DriveModel


@pytest.mark.parametrize(("low_deg", "high_deg"), [(-90.0, 90.0), (0.0, 180.0), (-180.0, 0.0), (0.0, 35.0)])
def test_a_servo_turns_where_it_is_sent_whatever_its_stops(low_deg: float, high_deg: float) -> None:
    """One with a stop at 0 turned as if that were half a turn away."""
    thruster = replace(
        load(find("aboat")).thrusters[0], azimuth_min_rad=math.radians(low_deg), azimuth_max_rad=math.radians(high_deg)
    )
    asked_rad = math.radians(low_deg + 0.7 * (high_deg - low_deg))
    pulse_us = AzimuthServo(thruster).pulse_us(asked_rad, 0.0)
    assert pulse_us is not None
    drive = DriveModel(thruster, pulses=True)
    assert drive.servo_azimuth_rad(pulse_us) == pytest.approx(asked_rad)
    assert drive.servo_pulse_us(asked_rad) == pytest.approx(pulse_us)
