"""From throttle to what a drive is told and back, against the plant's own piecewise drive and against figures worked
out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.bridges import OutputConfig
from companion.config.devices import ThrusterConfig
from companion.config.vessel import find, load
from companion.core.actuation import ThrusterCommand
from companion.io.actuators.calibration import AzimuthServo, ThrusterOutput
from sitl.drives import DriveModel

POD = load(find("aboat")).thrusters[0]


def thruster(output: OutputConfig | None) -> ThrusterConfig:
    return replace(POD, output=output)


def told(output: OutputConfig | None, throttle: float, pulses: bool = True, armed: bool = True) -> float:
    return ThrusterOutput(thruster(output), pulses).level(ThrusterCommand(0.0, throttle, None), armed, 0.0)


@pytest.mark.parametrize(
    ("output", "levels"),
    [
        (None, {-1.0: 1000.0, -0.5: 1250.0, 0.0: 1500.0, 0.25: 1625.0, 1.0: 2000.0}),
        (
            OutputConfig(trim=1520.0, ahead=1900.0, astern=1100.0),
            {-1.0: 1100.0, -0.5: 1310.0, 0.0: 1520.0, 0.5: 1710.0, 1.0: 1900.0},
        ),
        (OutputConfig(dead_band=40.0), {-1.0: 1000.0, -0.5: 1230.0, 0.0: 1500.0, 0.5: 1770.0, 1.0: 2000.0}),
        (OutputConfig(reversed=True, dead_band=40.0), {-1.0: 2000.0, 0.5: 1230.0, 1.0: 1000.0}),
        (
            OutputConfig(trim=1000.0, astern=1000.0),
            {-1.0: 1000.0, -0.1: 1000.0, 0.0: 1000.0, 0.5: 1500.0, 1.0: 2000.0},
        ),  # an engine
        (OutputConfig(), {7.0: 2000.0, -7.0: 1000.0, math.nan: 1500.0, math.inf: 1500.0}),
    ],
)
def test_levels_worked_out_by_hand(output: OutputConfig | None, levels: dict[float, float]) -> None:
    assert {throttle: told(output, throttle) for throttle in levels} == pytest.approx(levels, nan_ok=True)


def test_a_drive_without_calibration_takes_throttles_as_they_are() -> None:
    for throttle in (-1.0, -0.37, 0.0, 1e-9, 0.123456789, 1.0):
        assert told(None, throttle, pulses=False) == throttle


def test_disarmed_is_standstill() -> None:
    assert told(OutputConfig(trim=1520.0, dead_band=30.0), 1.0, armed=False) == 1520.0


outputs = st.builds(
    OutputConfig,
    trim=st.floats(1400.0, 1600.0),
    ahead=st.floats(1700.0, 2200.0),
    astern=st.floats(800.0, 1300.0),
    dead_band=st.floats(0.0, 90.0),
    reversed=st.booleans(),
)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(outputs, st.floats(-1.0, 1.0).map(lambda value: round(value, 3)))
def test_the_plants_drive_does_what_the_throttle_asked_and_its_level_says_so(
    output: OutputConfig, throttle: float
) -> None:
    drive = DriveModel(thruster(output), pulses=True)
    level = told(output, throttle)
    assert drive.throttle(level) == pytest.approx(throttle, abs=1e-9)
    assert ThrusterOutput(thruster(output), True).throttle(drive.level(throttle)) == pytest.approx(throttle, abs=1e-9)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(st.floats(-1.0, 1.0), st.booleans(), st.floats(-math.pi, math.pi))
def test_azimuths_come_back_as_they_went(trim_rad: float, reverse: bool, azimuth_rad: float) -> None:
    output = OutputConfig(azimuth_trim_rad=trim_rad, azimuth_reversed=reverse)
    calibrated, drive = ThrusterOutput(thruster(output), False), DriveModel(thruster(output), pulses=False)
    shown = calibrated.drive_azimuth(azimuth_rad)
    assert drive.azimuth_rad(shown) == pytest.approx(azimuth_rad, abs=1e-9)
    back = calibrated.azimuth(shown)
    assert back is not None and math.remainder(back - azimuth_rad, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_throttle_rises_at_its_rate_and_falls_at_once() -> None:
    output = ThrusterOutput(thruster(OutputConfig(rate_ps=0.5)), pulses=False)

    def at(now_s: float, throttle: float, armed: bool = True) -> float:
        return output.level(ThrusterCommand(0.0, throttle, None), armed, now_s)

    assert [at(0.0, 1.0), at(1.0, 1.0), at(1.5, 1.0)] == pytest.approx([0.0, 0.5, 0.75])
    assert at(1.6, 0.3) == 0.3  # less, at once
    assert at(2.0, -1.0) == pytest.approx(-0.2)  # through standstill, from there at the rate
    assert at(2.0, 1.0, armed=False) == 0.0
    assert at(2.1, 1.0) == pytest.approx(0.05)
    assert at(1.0, 1.0) == pytest.approx(0.05)  # a clock that went back


def test_an_azimuth_servo_keeps_to_its_stops_and_its_rate() -> None:
    servo = AzimuthServo(
        replace(
            POD,
            azimuth_min_rad=-1.0,
            azimuth_max_rad=1.0,
            azimuth_rate_radps=0.5,
            output=OutputConfig(azimuth_min_us=2000.0, azimuth_max_us=1200.0),
        )
    )
    assert servo.pulse_us(None, 0.0) is None
    assert servo.pulse_us(0.0, 0.0) == pytest.approx(1600.0)
    assert servo.pulse_us(5.0, 1.0) == pytest.approx(1400.0)
    assert servo.pulse_us(math.nan, 1.5) == servo.pulse_us(None, 1.5) == pytest.approx(1400.0)
    assert servo.pulse_us(5.0, 9.0) == pytest.approx(1200.0)
    assert servo.azimuth_rad(1400.0) == pytest.approx(0.5)
    with pytest.raises(ValueError, match="no stops"):
        AzimuthServo(replace(POD, azimuth_min_rad=None))
